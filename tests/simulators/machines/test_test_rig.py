"""The teaching rig in limits with closed forms, its rigid-body laws, its linearity, its variants."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators.effects.coupling_misalignment import CouplingMisalignment
from rotorwise.simulators.effects.coupling_stiffness_harmonics import CouplingStiffnessHarmonics
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.machines.test_rig import (
    BEARING_A,
    BEARING_B,
    DISC,
    ELEMENTS,
    FREE_END,
    HUB_DIAMETER_M,
    STEEL,
    shaft_lengths_m,
)
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from scipy.linalg import eigh

RIG = find_machine("test_rig")
#: Nothing connects the shaft to the motor, except in torsion, which cannot be cut.
UNCOUPLED = {
    "coupling_radial_stiffness_n_m": 0.0,
    "coupling_angular_stiffness_n_m_rad": 0.0,
    "coupling_axial_stiffness_n_m": 0.0,
}
#: The plate stands on rigid ground. (A heavy plate on weak mounts would not do: it yields as 1 / (mass speed^2).)
GROUND = {"mount_stiffness_n_m": 1e12}
STIFF = {f"{part}_{axis}_hz": 1e5 for part in ("housing", "cap") for axis in ("x", "y", "axial")}
#: Almost no shaft beyond the bearings.
SHORT = {"coupling_overhang_m": 0.01, "free_end_m": 0.01, "hub_mass_kg": 0.01}
SOFT_BEARINGS = {"bearing_stiffness_n_m": 1e3, "bearing_axial_stiffness_n_m": 0.0}


def matrices(machine):
    """Return names, mass and stiffness matrix of the linear core."""
    system = machine.system(speed_rpm=1.0)
    n = len(system.coordinates)
    return system.coordinates, system.mass_matrix, -system.mass_matrix @ system.core[n : 2 * n, :n]


def mode_hz(machine, motion):
    """Return the natural frequency of the mode that holds most of ``motion``, a mapping of coordinate to share."""
    names, mass, stiffness = matrices(machine)
    squares, shapes = eigh((stiffness + stiffness.T) / 2, mass)
    wanted = np.array([motion.get(name, 0.0) for name in names])
    return math.sqrt(squares[np.argmax(np.abs(wanted @ mass @ shapes))]) / (2 * math.pi)


def shaft_motion(axis, *, slope=0.0, about_m=0.0):
    """Return the rigid motion of the shaft in x or y: translation by 1, or tilt with a slope about a point."""
    values = {}
    for node, position in enumerate(np.concatenate([[0.0], np.cumsum(pieces(RIG.with_parameters(**SHORT)))])):
        values[f"shaft_{node}.{axis}"] = 1.0 if not slope else slope * (position - about_m)
        values[f"shaft_{node}.angle_{'y' if axis == 'x' else 'x'}"] = slope if axis == "x" else -slope
    return values


def pieces(machine):
    """Return the length of every element."""
    lengths = shaft_lengths_m(machine.values)
    return [length / count for length, count in zip(lengths, ELEMENTS, strict=True) for _ in range(count)]


def one_x(machine, speed_rpm):
    """Return the moduli of 1X by probe."""
    motion = harmonic_balance(machine, speed_rpm=speed_rpm, harmonics=1)
    return {probe.name: abs(motion.amplitude(probe.name, 1.0)) for probe in motion.probes}


# -- closed forms --------------------------------------------------------------------------------------------------


def test_shaft_in_rigid_bearings_with_a_heavy_disc_in_the_middle():
    disc, length, diameter = 40.0, 0.39, 0.016
    rig = RIG.with_parameters(
        **UNCOUPLED, **GROUND, **STIFF, **SHORT, disc_mass_kg=disc, bearing_stiffness_n_m=1e11, load_position=0.5
    )
    inertia, area = math.pi / 64 * diameter**4, math.pi / 4 * diameter**2
    bending = length**3 / (48 * STEEL.youngs_modulus_pa * inertia)
    shear = length / (4 * 0.886 * STEEL.shear_modulus_pa * area)
    shaft = 17 / 35 * STEEL.density_kg_m3 * area * length
    expected = math.sqrt(1 / ((bending + shear) * (disc + shaft))) / (2 * math.pi)
    # Rayleigh's 17/35 of the shaft's mass is exact to first order in mass over disc, the square of which is 1e-4;
    # housings and bearings yield 1e-5 of the shaft.
    for axis in "xy":
        assert mode_hz(rig, {f"shaft_{DISC}.{axis}": 1.0}) == pytest.approx(expected, rel=3e-4)


def test_rigid_rotor_on_soft_bearings_bounces_and_tilts():
    rig = RIG.with_parameters(**UNCOUPLED, **GROUND, **STIFF, **SHORT, **SOFT_BEARINGS)
    length, radius = 0.41, 0.008
    shaft = STEEL.density_kg_m3 * math.pi * radius**2 * length
    disc_polar = 0.9 * (0.1524**2 + 0.016**2) / 8
    disc_tilt = disc_polar / 2 + 0.9 * 0.016**2 / 12
    hub_tilt = 0.01 * HUB_DIAMETER_M**2 * (1 / 16 + 1 / 12)
    mass = shaft + 0.9 + 0.01
    centre = (shaft * length / 2 + 0.9 * length / 2) / mass
    tilt = shaft * (radius**2 / 4 + length**2 / 12) + disc_tilt + (shaft + 0.9) * (length / 2 - centre) ** 2
    tilt += 0.01 * centre**2 + hub_tilt
    # Two springs k at the bearings, with the mass centre a little towards the hub: a 2 x 2 problem.
    arms = np.array([0.01, 0.4]) - centre
    stiffness = 1e3 * np.array([[2.0, arms.sum()], [arms.sum(), arms @ arms]])
    expected = np.sqrt(eigh(stiffness, np.diag([mass, tilt]), eigvals_only=True)) / (2 * math.pi)
    # The shaft bends by k L^3 / 48 E I = 0.2 % as much as the bearings.
    for axis in "xy":
        found = [mode_hz(rig, shaft_motion(axis)), mode_hz(rig, shaft_motion(axis, slope=1.0, about_m=centre))]
        assert found == pytest.approx(expected, rel=3e-3)


def test_torsion_of_two_discs_on_the_coupling():
    rig = RIG.with_parameters(coupling_torsional_stiffness_n_m_rad=1.0, motor_slope_n_m_s_rad=1e-5)
    names, mass, _ = matrices(rig)
    twists = [name for name in names if name.endswith(".torsion")]
    driven = [names.index(name) for name in twists if name != "motor.torsion"]
    inertia = mass[np.ix_(driven, driven)].sum()
    shaft = STEEL.density_kg_m3 * math.pi / 32 * 0.016**4 * 0.52
    disc = 0.9 * (0.1524**2 + 0.016**2) / 8
    assert inertia == pytest.approx(shaft + disc + 0.08 * HUB_DIAMETER_M**2 / 8, rel=1e-9)
    expected = math.sqrt(1.0 * (1 / 6e-4 + 1 / inertia)) / (2 * math.pi)
    # The shaft is 2000 times stiffer than this coupling.
    assert mode_hz(rig, {"motor.torsion": 1.0, "disc.torsion": -6e-4 / inertia}) == pytest.approx(expected, rel=1e-3)


def settled_deflections(machine):
    """Return the displacement of each coordinate under the constant forces."""
    system = machine.system(speed_rpm=1.0)
    weight = np.zeros(system.force_columns.shape[1])
    index = [force.name for force in system.forces].index("weight")
    weight[system.outputs[index]] = system.forces[index].parameters[2]
    state = np.linalg.lstsq(-system.core, system.force_columns @ weight, rcond=1e-14)[0]
    return dict(zip(system.coordinates, state, strict=False))


def test_static_deflection_of_the_shaft_under_weight():
    disc, length = 0.9, 0.39
    rig = RIG.with_parameters(**UNCOUPLED, **SHORT, **STIFF, bearing_stiffness_n_m=1e9, disc_mass_kg=disc)
    found = settled_deflections(rig)
    sag = (found[f"shaft_{BEARING_A}.y"] + found[f"shaft_{BEARING_B}.y"]) / 2 - found[f"shaft_{DISC}.y"]
    flexural = STEEL.youngs_modulus_pa * math.pi / 64 * 0.016**4
    per_length = STEEL.density_kg_m3 * math.pi / 4 * 0.016**2 * 9.80665
    shear = 0.886 * STEEL.shear_modulus_pa * math.pi / 4 * 0.016**2
    expected = disc * 9.80665 * length**3 / (48 * flexural) + 5 * per_length * length**4 / (384 * flexural)
    expected += disc * 9.80665 * length / (4 * shear) + per_length * length**2 / (8 * shear)
    # What overhangs lifts the middle: end moments of shaft ends and hub, M L^2 / 8 E I each.
    ends = 2 * per_length * 0.01**2 / 2 + 0.01 * 9.80665 * 0.01
    assert sag == pytest.approx(expected - ends * length**2 / (16 * flexural), rel=2e-4)


# -- totals and conservation ---------------------------------------------------------------------------------------


def rigid_motions(machine):
    """Return the six motions of the whole rig as a rigid body, shape (coordinates, 6), about the plate's centre."""
    names, _, _ = matrices(machine)
    values = machine.values
    at_node = np.concatenate([[0.0], np.cumsum(pieces(machine))])
    positions = {f"shaft_{node}": position for node, position in enumerate(at_node)}
    positions |= {"shaft": 0.0, "motor": -values["motor_hub_overhang_m"] - values["motor_bearing_span_m"] / 2}
    for number in (1, 2):
        positions[f"housing_a_{number}"] = values["coupling_overhang_m"]
        positions[f"housing_b_{number}"] = values["coupling_overhang_m"] + values["bearing_span_m"]
    motions = np.zeros((len(names), 6))
    for row, name in enumerate(names):
        part, kind = name.split(".")
        height = 0.0 if part == "base" else values["shaft_height_m"]
        z = 0.0 if part == "base" else positions.get(part, 0.0) - values["base_centre_m"]
        motions[row] = {
            "x": [1, 0, 0, 0, z, -height],
            "y": [0, 1, 0, -z, 0, 0],
            "axial": [0, 0, 1, height, 0, 0],
            "angle_x": [0, 0, 0, 1, 0, 0],
            "angle_y": [0, 0, 0, 0, 1, 0],
            "angle_z": [0, 0, 0, 0, 0, 1],
            "torsion": [0, 0, 0, 0, 0, 0],
        }[kind]
    return motions


def test_moving_as_a_whole_strains_nothing_but_the_mounts():
    rig = RIG.with_parameters(shaft_load_kg=5.0, disc_position=0.4)
    _, _, stiffness = matrices(rig)
    motions = rigid_motions(rig)
    energy = motions.T @ stiffness @ motions
    values = rig.values
    vertical = 4 * values["mount_stiffness_n_m"]
    assert np.diag(energy)[:3] == pytest.approx(
        vertical * np.array([values["mount_shear_ratio"], 1.0, values["mount_shear_ratio"]]), rel=1e-6
    )
    inside = stiffness @ motions
    inside[[i for i, name in enumerate(matrices(rig)[0]) if name.startswith("base.")]] = 0.0
    assert np.abs(inside).max() < 1e-9 * np.abs(stiffness).max()


def test_total_mass_is_the_same_in_all_directions_and_that_of_the_description():
    _, mass, _ = matrices(RIG)
    motions = rigid_motions(RIG)
    total = motions.T @ mass @ motions
    values = RIG.values
    shaft = STEEL.density_kg_m3 * math.pi / 4 * 0.016**2 * 0.52
    parts = sum(values[f"{name}_mass_kg"] for name in ("disc", "hub", "motor_rotor", "base"))
    parts += shaft + 2 * (values["housing_mass_kg"] + values["cap_mass_kg"])
    assert np.diag(total)[:3] == pytest.approx(parts, rel=1e-9)
    # MaFaulDa's rig weighs 22 kg.
    assert parts == pytest.approx(22.0, rel=0.02)


def test_between_mounts_and_resonances_the_rig_accelerates_as_a_rigid_body():
    rig = RIG.with_parameters(mount_stiffness_n_m=10.0, mount_damping_ratio=0.0, disc_position=0.3)
    names, mass, _ = matrices(rig)
    motions = rigid_motions(rig)
    speed_rpm = 300.0
    force = np.zeros(len(names))
    force[names.index(f"shaft_{DISC}.x")] = 4e-5 * (speed_rpm * math.pi / 30) ** 2
    acceleration = dict(
        zip(names, motions @ np.linalg.solve(motions.T @ mass @ motions, motions.T @ force), strict=True)
    )
    motion = harmonic_balance(rig, speed_rpm=speed_rpm, harmonics=1)
    for house in "ab":
        # In x only the cosine part of the turning force acts.
        found = motion.amplitude(f"housing_{house}_x", 1.0)
        # 5 Hz against a first mode of the rotor at 110 Hz: (5/110)^2 = 0.2 %; mounts at 0.25 Hz: another 0.25 %.
        assert found == pytest.approx(acceleration[f"housing_{house}_2.x"], rel=6e-3)


@pytest.mark.parametrize(("values", "exponent"), [({"mount_stiffness_n_m": 10.0}, 2.0), (GROUND, 4.0)])
def test_1x_grows_as_speed_squared_on_mounts_and_to_the_fourth_on_rigid_ground(values, exponent):
    rig = RIG.with_parameters(**values)
    slow, fast = one_x(rig, 300.0), one_x(rig, 600.0)
    for name in ("housing_a_x", "housing_a_y", "housing_b_x", "housing_b_y"):
        # 10 Hz against 110 Hz and, on mounts, 5 Hz against 0.3 Hz: a hundredth in the exponent each.
        assert math.log2(fast[name] / slow[name]) == pytest.approx(exponent, abs=0.03)


@pytest.mark.parametrize("position", [0.2, 0.5, 0.8])
def test_unbalance_splits_to_the_housings_by_leverage(position):
    rig = RIG.with_parameters(**UNCOUPLED, **GROUND, disc_position=position)
    found = one_x(rig, 60.0)
    for axis in "xy":
        ratio = found[f"housing_a_{axis}"] / found[f"housing_b_{axis}"]
        # Statics at 1 Hz: the shaft's own inertia and modes are (1/100)^2.
        assert ratio == pytest.approx((1 - position) / position, rel=1e-3)


def test_symmetric_rig_moves_symmetrically():
    rig = RIG.with_parameters(
        **UNCOUPLED,
        **GROUND,
        coupling_overhang_m=0.05,
        hub_mass_kg=0.01,
        floating_axial_share=1.0,
        residual_angle_rad=0.7,
    )
    found = one_x(rig, 1800.0)
    for axis in "xy":
        # The hub of 10 g at one end is what is left of asymmetry.
        assert found[f"housing_a_{axis}"] == pytest.approx(found[f"housing_b_{axis}"], rel=2e-3)


# -- solvers and effects -------------------------------------------------------------------------------------------


def test_simulation_agrees_with_harmonic_balance():
    # Strongly damped mounts, so that ten seconds of settling is not needed.
    rig = RIG.with_parameters(mount_damping_ratio=0.7, mount_stiffness_n_m=1e5, shaft_damping_ratio=0.02)
    rig = rig.with_effects(CouplingMisalignment(), CouplingStiffnessHarmonics(x_1=0.2, y_1=0.2, x_2=0.1, y_2=0.1))
    run = rig.simulate(speed_rpm=2400.0, duration_s=0.1, rate_hz=10000.0, settle_s=1.5)
    steady = harmonic_balance(rig, speed_rpm=2400.0, harmonics=8).waveform(run.phase_rad)
    steady -= steady.mean(axis=1, keepdims=True)
    error = np.abs(run.signals - steady).max(axis=1)[:6]
    assert np.all(error < 1e-4 * np.abs(steady).max(axis=1)[:6])


def test_response_is_linear_in_the_unbalance_and_adds_as_vectors():
    def amplitudes(*effects, residual=0.0):
        rig = RIG.with_parameters(residual_unbalance_kg_m=residual).with_effects(*effects)
        return harmonic_balance(rig, speed_rpm=2000.0, harmonics=1).amplitudes[:, 1]

    first, second = Unbalance(moment_kg_m=1e-4, angle_rad=0.4), Unbalance(moment_kg_m=3e-4, angle_rad=-2.0, at="motor")
    both = amplitudes(first, second, residual=4e-5)
    apart = amplitudes(first) + amplitudes(second) + amplitudes(residual=4e-5)
    assert both == pytest.approx(apart, rel=1e-9, abs=1e-12 * np.abs(both).max())


@pytest.mark.parametrize(
    ("harmonics", "absent"),
    [({}, (2, 3, 4, 5, 6)), ({"x_2": 0.2, "y_2": 0.2, "angle_x_2": 0.2, "angle_y_2": 0.2}, (2, 4, 6))],
)
def test_misalignment_raises_the_lines_that_the_coupling_declares_and_no_others(harmonics, absent):
    base = RIG.with_effects(CouplingStiffnessHarmonics(**{f"{d}_{n}": 0.0 for d in ("x", "y", "angle_x", "angle_y")
                                                          for n in (1, 2, 3)}).with_values(**harmonics))  # fmt: skip
    effect = CouplingMisalignment(offset_m=2e-4, angle_rad=2e-3)
    before, after = (harmonic_balance(m, speed_rpm=1800.0, harmonics=8) for m in (base, base.with_effects(effect)))
    lateral = [i for i, probe in enumerate(after.probes) if probe.direction in "xy"]
    rise = np.abs(after.amplitudes - before.amplitudes)[lateral].max(axis=0)
    coupling = base.assembly(speed_rpm=1800.0).component("coupling")
    declared = [int(line.order) for line in coupling.misalignment_lines()]
    assert declared == ([1, 3] if harmonics else [1])
    assert all(rise[order] > 1e-3 * rise[1] for order in declared)
    assert all(rise[order] < 1e-9 * rise[1] for order in absent)


def test_axial_motion_comes_from_the_plates_pitching():
    level = RIG.with_parameters(**GROUND)
    assert one_x(RIG, 1800.0)["housing_b_axial"] > 100 * one_x(level, 1800.0)["housing_b_axial"]


# -- variants ------------------------------------------------------------------------------------------------------


def test_presets_have_the_bearings_of_their_benches():
    orders = {
        preset: RIG.preset(preset).bare_assembly().component("bearing", "bearing_b").geometry.defect_orders()
        for preset in RIG.definition.presets
    }
    assert orders["plausible"] == orders["hertz"] == find_bearing("MaFaulDa").defect_orders()
    assert orders["adi"] == orders["adi_hertz"] == find_bearing("ER-12K").defect_orders()
    assert "as_printed" not in orders


def test_places_and_components_that_effects_need():
    assembly = RIG.bare_assembly()
    assert assembly.place("rotor").name == "disc"
    roles = {role for place in assembly.places.values() for role in place.roles}
    assert roles >= {"rotor", "disc", "coupling", "bearing", "housing", "motor", "load"}
    for role, names in (("bearing", ("bearing_a", "bearing_b")), ("support", ("housing_a pedestal",))):
        for name in names:
            assert assembly.component(role, name).name == name
    assert {probe.direction for probe in assembly.probes if probe.quantity == "acceleration"} == {"x", "y", "axial"}
    assert RIG.system(speed_rpm=1800.0).is_linear
    assert not RIG.preset("hertz").system(speed_rpm=1800.0).is_linear


def test_load_is_mass_on_the_shaft():
    assert RIG.definition.load_parameter == "shaft_load_kg"
    empty, loaded = RIG, RIG.with_parameters(shaft_load_kg=5.0)
    _, mass, _ = matrices(empty)
    _, more, _ = matrices(loaded)
    motions = rigid_motions(empty)
    difference = motions.T @ (more - mass) @ motions
    assert np.diag(difference)[:3] == pytest.approx(5.0, rel=1e-9)
    lateral = {f"shaft_{node}.x": 1.0 for node in range(BEARING_A, FREE_END)}
    assert mode_hz(loaded, lateral) < 0.9 * mode_hz(empty, lateral)


def test_hertz_bearings_carry_the_weight_and_pulse_as_balls_pass():
    rig = RIG.preset("adi_hertz").with_parameters(bearing_play_m=0.0, shaft_load_kg=5.0, residual_unbalance_kg_m=0.0)
    run = rig.simulate(speed_rpm=1800.0, duration_s=1.0, rate_hz=4000.0, settle_s=1.0)
    signal = run.probe("housing_b_y")
    window = np.hanning(signal.size)
    spectrum = np.abs(np.fft.rfft((signal - signal.mean()) * window))
    order = rig.bare_assembly().component("bearing").ball_pass_order
    line = round(order * 30.0)
    around = np.r_[spectrum[line - 15 : line - 3], spectrum[line + 4 : line + 16]]
    assert spectrum[line - 1 : line + 2].max() > 30 * np.median(around)


def test_text_keeps_the_rig():
    rig = RIG.preset("adi").with_parameters(disc_mass_kg=1.1).with_effects(Unbalance())
    assert machine_from_toml(rig.to_toml()) == rig
    with pytest.raises(InvalidValueError, match="disc_position = 1"):
        RIG.with_parameters(disc_position=1.0)
    with pytest.raises(InvalidValueError, match="no preset 'as_printed'"):
        RIG.preset("as_printed")


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_any_rig_drawn_from_the_priors_is_stable(seed):
    generator = np.random.default_rng(seed)
    values = {}
    for declared in RIG.definition.parameters:
        if declared.prior is not None:
            values[declared.name] = float(np.clip(declared.prior.sample(generator), *declared.bounds))
    rig = RIG.with_parameters(**values)
    # The shaft turns freely: its angle is a motion that nothing holds.
    assert np.linalg.eigvals(rig.system(speed_rpm=1800.0).core).real.max() < 1e-6
    assert all(np.isfinite(list(one_x(rig, 1800.0).values())))


def test_every_parameter_has_a_source_and_a_prior_that_fits_its_bounds():
    for declared in RIG.definition.parameters:
        assert declared.meaning
        assert declared.source
        if declared.prior is not None:
            draws = [declared.prior.sample(np.random.default_rng(seed)) for seed in range(60)]
            assert np.mean([declared.bounds[0] <= draw <= declared.bounds[1] for draw in draws]) > 0.95
