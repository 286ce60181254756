"""The flexible coupling against its potential, closed forms of a mass on a coupling, and Mathieu's equation."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators.assembly import Assembly, Probe
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import Machine, MachineDefinition, Preset
from rotorwise.simulators.rotor_dynamics.flexible_coupling import FLEXIBLE_COUPLING, LATERAL, FlexibleCoupling
from rotorwise.simulators.solvers.floquet import floquet_multipliers
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.system import build_system

MASS = {"x": 2.0, "y": 2.0, "angle_x": 0.01, "angle_y": 0.01}
STIFFNESS = {"x": 8e4, "y": 5e4, "angle_x": 140.0, "angle_y": 90.0}
RPM = 1500.0
SPEED = RPM * 2 * math.pi / 60


def hub_machine(change=lambda coupling: None, *, damping=None, stiffness=None, reversed_sign=False):
    """A hub on a coupling to a fixed motor; probes are its four motions."""

    def build(assembly, values, switches):
        for direction, mass in MASS.items():
            assembly.add_coordinate(direction, mass=mass)
            unit = "rad" if direction.startswith("angle") else "m"
            assembly.probes.append(Probe(direction, "displacement", unit, "hub", direction, {direction: 1.0}))
        coupling = FlexibleCoupling(
            "c",
            driven={d: {d: 1.0} for d in LATERAL},
            stiffness=STIFFNESS if stiffness is None else stiffness,
            damping={} if damping is None else damping,
            reversed_sign=reversed_sign,
        )
        change(coupling)
        assembly.add_component(coupling)

    return Machine(MachineDefinition("hub", "", (), {"plausible": Preset("")}, build, 1e-4, 1.0))


def two_ends(coupling_change):
    """Both ends free; return the system."""
    assembly = Assembly(speed_rad_s=SPEED)
    for end in ("rotor", "motor"):
        for direction, mass in MASS.items():
            assembly.add_coordinate(f"{end}.{direction}", mass=mass)
    coupling = FlexibleCoupling(
        "c",
        driven={d: {f"rotor.{d}": 1.0} for d in LATERAL},
        driving={d: {f"motor.{d}": 1.0} for d in LATERAL},
        stiffness=STIFFNESS,
    )
    coupling_change(coupling)
    coupling.finish(assembly)
    return build_system(assembly)


def acceleration(system, position, phase):
    """Return q'' at rest at one shaft angle, from L, B and the laws."""
    state = np.concatenate([position, np.zeros(position.size)])
    instant = np.array([[phase]])
    timeline = Timeline(instant / SPEED, instant, np.full((1, 1), SPEED), np.zeros((1, 1)))
    read = system.motion_rows @ state
    u = np.zeros(system.force_columns.shape[1])
    for force, inputs, outputs in zip(system.forces, system.inputs, system.outputs, strict=True):
        signals = force.law.signals(timeline, np.array(force.parameters)[:, None])[:, 0, 0]
        u[outputs] += signals[: outputs.size] + signals[outputs.size :].reshape(outputs.size, -1) @ read[inputs]
    return (system.core @ state + system.force_columns @ u)[position.size :]


def potential(position, phase, offsets, series):
    """Eq (2) of the source with Eqs (1) and (3), written out again; rotor first, then motor."""
    total = 0.0
    delta, delta_phase, theta, theta_phase = offsets
    shift = [
        delta * math.cos(phase + delta_phase),
        delta * math.sin(phase + delta_phase),
        theta * math.cos(phase + theta_phase),
        theta * math.sin(phase + theta_phase),
    ]
    for i, direction in enumerate(LATERAL):
        factor = 1 + sum(a * math.cos(n * phase) for n, a in enumerate(series[direction], start=1))
        total += 0.5 * STIFFNESS[direction] * factor * (position[i] - position[i + 4] + shift[i]) ** 2
    return total


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.floats(-7, 7))
def test_force_is_minus_the_gradient_of_the_potential_and_acts_equally_on_both_ends(seed, phase):
    generator = np.random.default_rng(seed)
    offsets = (5e-4, generator.uniform(-3, 3), 0.02, generator.uniform(-3, 3))
    series = {direction: generator.uniform(-0.3, 0.3, 3) for direction in LATERAL}

    def change(coupling):
        coupling.misalign(
            offset_m=offsets[0], offset_phase_rad=offsets[1], angle_rad=offsets[2], angle_phase_rad=offsets[3]
        )
        for direction in LATERAL:
            coupling.add_stiffness_harmonics(direction, cos=series[direction])

    system = two_ends(change)
    position = generator.normal(size=8) * 1e-3
    force = acceleration(system, position, phase) * np.array([*MASS.values()] * 2)
    # A central difference of a quadratic is exact to rounding.
    width = 1e-4
    gradient = [
        (potential(position + step, phase, offsets, series) - potential(position - step, phase, offsets, series))
        / (2 * width)
        for step in width * np.eye(8)
    ]
    np.testing.assert_allclose(force, -np.array(gradient), rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(force[:4], -force[4:], rtol=1e-12)


def test_turning_offset_moves_a_mass_as_the_closed_form():
    damping = {"x": 30.0, "y": 30.0, "angle_x": 0.1, "angle_y": 0.1}
    machine = hub_machine(
        lambda c: c.misalign(offset_m=4e-4, offset_phase_rad=0.7, angle_rad=0.01, angle_phase_rad=-0.4), damping=damping
    )
    motion = harmonic_balance(machine, speed_rpm=RPM, harmonics=3)
    for direction, size, phase in (
        ("x", 4e-4, 0.7),
        ("y", -1j * 4e-4, 0.7),
        ("angle_x", 0.01, -0.4),
        ("angle_y", -1j * 0.01, -0.4),
    ):
        # The dashpot sees the offset turn too: m d'' = -(k + c d/dt)(d + s).
        pull = STIFFNESS[direction] + 1j * SPEED * damping[direction]
        expected = -pull / (pull - MASS[direction] * SPEED**2) * size * np.exp(1j * phase)
        assert motion.amplitude(direction, 1) == pytest.approx(expected, rel=1e-10)
        assert abs(motion.amplitude(direction, 2)) < 1e-12 * abs(expected)


def test_offset_fixed_in_space_only_shifts_a_constant_coupling():
    machine = hub_machine(lambda c: c.misalign(offset_m=4e-4, offset_phase_rad=math.pi / 2, turning=False))
    motion = harmonic_balance(machine, speed_rpm=RPM, harmonics=3)
    np.testing.assert_allclose(motion.amplitudes[:, 0].real, [0, -4e-4, 0, 0], atol=1e-12)
    assert np.abs(motion.amplitudes[:, 1:]).max() < 1e-14


def test_offset_fixed_in_space_against_a_motion_that_is_held_gives_n_x():
    """To first order in a_n the force is k0 a_n delta cos(n phi) on the remaining elongation, here all of it."""
    held = 1e9

    def change(coupling):
        coupling.misalign(offset_m=4e-4, turning=False)
        coupling.add_stiffness_harmonics("x", cos=[0.0, 0.1])

    machine = hub_machine(change)
    inner = machine.definition.build

    def build(assembly, values, switches):
        inner(assembly, values, switches)
        assembly.add_spring({"x": 1.0}, stiffness=held)

    machine = Machine(MachineDefinition("held", "", (), {"plausible": Preset("")}, build, 1e-4, 1.0))
    motion = harmonic_balance(machine, speed_rpm=RPM, harmonics=4)
    expected = -STIFFNESS["x"] * 0.1 * 4e-4 / (held + STIFFNESS["x"] - MASS["x"] * (2 * SPEED) ** 2)
    assert motion.amplitude("x", 2) == pytest.approx(expected, rel=1e-3)
    assert abs(motion.amplitude("x", 1)) < 1e-6 * abs(expected)
    assert abs(motion.amplitude("x", 3)) < 1e-6 * abs(expected)


@pytest.mark.parametrize("order", [1, 2, 3, 5])
def test_harmonic_n_of_the_stiffness_makes_n_minus_1_and_n_plus_1_of_a_turning_offset(order):
    """First-order perturbation: x_m = -k0 (a/2) z_1 / (k0 - M (m w)^2), m = n +- 1, z_1 the elongation at 1X."""
    small = 1e-4

    def change(coupling):
        coupling.misalign(offset_m=4e-4)
        coupling.add_stiffness_harmonics("x", cos=[*[0.0] * (order - 1), small])

    motion = harmonic_balance(hub_machine(change), speed_rpm=RPM, harmonics=8)
    k, mass = STIFFNESS["x"], MASS["x"]
    elongation = 4e-4 * (1 - k / (k - mass * SPEED**2))
    for m in (order - 1, order + 1):
        if m == 1:
            continue
        expected = -k * small / 2 * elongation / (k - mass * (m * SPEED) ** 2)
        assert motion.amplitude("x", m) == pytest.approx(expected, rel=1e-3)
    others = [m for m in range(9) if m not in (1, order - 1, order + 1)]
    assert np.abs(motion.amplitudes[0, others]).max() < 10 * small**2 * 4e-4
    assert np.abs(motion.amplitudes[1:, 2:]).max() < 1e-12 * abs(elongation)


def test_misalignment_lines_are_those_that_harmonic_balance_shows():
    def change(coupling):
        coupling.misalign(offset_m=4e-4)
        coupling.add_stiffness_harmonics("x", cos=[0.0, 0.0, 1e-6], sin=[0.0, 1e-5])
        found.append(coupling)

    found = []
    motion = harmonic_balance(hub_machine(change), speed_rpm=RPM, harmonics=8)
    orders = [line.order for line in found[0].misalignment_lines()]
    assert orders == [1, 3, 2, 4]
    shown = {m for m in range(1, 9) if np.abs(motion.amplitudes[:, m]).max() > 1e-9 * 4e-4}
    assert shown == set(orders)


def test_stationary_lines_are_those_that_harmonic_balance_shows():
    def change(coupling):
        coupling.misalign(offset_m=4e-4, turning=False)
        coupling.add_stiffness_harmonics("x", cos=[0.0, 0.0, 1e-6], sin=[0.0, 1e-5])
        found.append(coupling)

    found = []
    motion = harmonic_balance(hub_machine(change), speed_rpm=RPM, harmonics=8)
    # The hub has gone along by the whole offset, so the coupling is not bent and nothing varies.
    assert np.abs(motion.amplitudes[:, 1:]).max() < 1e-15
    assert [line.order for line in found[0].stationary_misalignment_lines()] == [2, 3]


def test_parametric_resonance_grows_as_mathieu_predicts():
    """x'' + w0^2 (1 + e cos 2 phi) x = 0 turning at w0 grows at e w0 / 4 to first order (Nayfeh and Mook, 1979)."""
    natural = math.sqrt(STIFFNESS["x"] / MASS["x"])
    size = 0.02
    machine = hub_machine(lambda c: c.add_stiffness_harmonics("x", cos=[0.0, size]), stiffness={"x": STIFFNESS["x"]})

    def build(assembly, values, switches):
        machine.definition.build(assembly, values, switches)
        for direction in ("y", "angle_x", "angle_y"):
            assembly.add_spring({direction: 1.0}, stiffness=1.0, damping=100.0)

    held = Machine(MachineDefinition("mathieu", "", (), {"plausible": Preset("")}, build, 1e-4, 1.0))
    stability = floquet_multipliers(held, speed_rpm=natural * 60 / (2 * math.pi), steps=128)
    assert not stability.is_stable
    assert stability.growth_rate_1_s == pytest.approx(size * natural / 4, rel=size)


def test_printed_sign_pushes_a_free_hub_away():
    machine = hub_machine(reversed_sign=True)
    growth = np.linalg.eigvals(machine.system(speed_rpm=RPM).core).real.max()
    assert growth == pytest.approx(math.sqrt(STIFFNESS["x"] / MASS["x"]), rel=1e-9)


def test_printed_sign_turns_the_whole_force_round():
    def change(coupling):
        coupling.misalign(offset_m=4e-4, angle_rad=0.01)
        coupling.add_stiffness_harmonics("x", cos=[0.3, 0.1])

    position = np.array([1e-3, -2e-3, 0.01, 0.02])
    right = acceleration(hub_machine(change).system(speed_rpm=RPM), position, 0.6)
    printed = acceleration(hub_machine(change, reversed_sign=True).system(speed_rpm=RPM), position, 0.6)
    np.testing.assert_allclose(printed, -right, rtol=1e-12)


def test_rate_of_the_offset_is_its_derivative_while_the_speed_changes():
    coupling = FlexibleCoupling("c", {"x": {"x": 1.0}}, {"x": 0.0}, damping={"x": 1.0})
    coupling.misalign(offset_m=1.0, offset_phase_rad=0.5)
    assembly = Assembly(speed_rad_s=SPEED)
    assembly.add_coordinate("x", mass=1.0)
    coupling.finish(assembly)
    time = np.linspace(0, 0.1, 2001)[:, None]
    phase, speed = 50 * time + 300 * time**2, 50 + 600 * time
    timeline = Timeline(time, phase, speed, np.full(time.shape, 600.0))
    force = FLEXIBLE_COUPLING.signals(timeline, np.array(assembly.forces[0].parameters)[:, None])[0, :, 0]
    derivative = np.gradient(np.cos(phase[:, 0] + 0.5), time[:, 0])
    np.testing.assert_allclose(force[1:-1], -derivative[1:-1], atol=1e-3 * np.abs(derivative).max())


def test_torsion_and_axial_springs_are_constant():
    assembly = Assembly(speed_rad_s=SPEED)
    assembly.add_coordinate("turn", mass=0.1)
    assembly.add_coordinate("along", mass=2.0)
    ends = {"torsion": {"turn": 1.0}, "axial": {"along": 1.0}}
    FlexibleCoupling("c", ends, {"torsion": 400.0, "axial": 3e4}).finish(assembly)
    assert not assembly.forces
    frequencies = np.linalg.eigvals(build_system(assembly).core).imag
    assert sorted(frequencies[frequencies > 0]) == pytest.approx([math.sqrt(400 / 0.1), math.sqrt(3e4 / 2)])


def test_stiffness_below_zero_is_said_and_only_then():
    # 1 + a (cos + cos 2) is lowest where cos = -1/4: 1 - 9 a / 8.
    sound = hub_machine(lambda c: c.add_stiffness_harmonics("y", cos=[0.88, 0.88])).system(speed_rpm=RPM)
    assert sound.notes == ()
    notes = hub_machine(lambda c: c.add_stiffness_harmonics("y", cos=[0.96, 0.96])).system(speed_rpm=RPM).notes
    assert len(notes) == 1
    assert "in y falls to -0.08 of its mean" in notes[0]


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: FlexibleCoupling("c", {"x": {"x": 1.0}}, {"z": 1.0}), "'z'"),
        (lambda: FlexibleCoupling("c", {"x": {"x": 1.0}}, {"x": -1.0}), "-1.0"),
        (lambda: FlexibleCoupling("c", {"x": {"x": 1.0}}, {"y": 1.0}), "neither end moves"),
        (lambda: FlexibleCoupling("c", {}, {}).add_stiffness_harmonics("x", cos=[0.1] * 7), "at most 6"),
        (lambda: FlexibleCoupling("c", {}, {}).add_stiffness_harmonics("torsion", cos=[0.1]), "'torsion'"),
    ],
)
def test_wrong_values_are_refused(build, words):
    with pytest.raises(InvalidValueError, match=words):
        build()


@settings(max_examples=20, deadline=None)
@given(st.floats(-3, 3), st.floats(0, 1e-3), st.floats(-3, 3), st.floats(0, 1e-3))
def test_misalignments_add_as_vectors(first_phase, first, second_phase, second):
    both = FlexibleCoupling("c", {}, {})
    both.misalign(offset_m=first, offset_phase_rad=first_phase)
    both.misalign(offset_m=second, offset_phase_rad=second_phase)
    total = first * np.exp(1j * first_phase) + second * np.exp(1j * second_phase)
    once = FlexibleCoupling("c", {}, {})
    once.misalign(offset_m=abs(total), offset_phase_rad=float(np.angle(total)))
    for direction in ("x", "y"):
        np.testing.assert_allclose(both._offsets[direction], once._offsets[direction], atol=1e-15)
