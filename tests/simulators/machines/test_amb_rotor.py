"""The magnetic-bearing rotor: equations written out again, statics, stability, the printed signs."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import Assembly
from rotorwise.simulators.effects import CouplingMisalignment, Unbalance
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.machines import amb_rotor
from rotorwise.simulators.rotor_dynamics.harmonic_force import harmonic_force
from rotorwise.simulators.rotor_dynamics.magnetic_bearing import MagneticBearing
from rotorwise.simulators.solvers.floquet import floquet_multipliers
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.speed_profile import ramp

MACHINE = find_machine("amb_rotor")
CONSTANT = MACHINE.with_parameters(harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0)


def bare_matrices(values):
    """Return M, C, G, K of the free rotor as dense matrices, from the assembly without bearings and coupling."""
    assembly = Assembly(speed_rad_s=0.0)
    without = {"displacement_stiffness_n_m": 0.0, "coupling_stiffness_n_m": 0.0}
    amb_rotor.build(assembly, {**values, **without, "coupling_rotational_stiffness_n_m_rad": 0.0}, frozenset())
    names = assembly.coordinates
    found = []
    for kind in ("mass", "damping", "gyroscopic", "stiffness"):
        matrix = np.zeros((len(names), len(names)))
        for (first, second), value in getattr(assembly, kind).items():
            matrix[names.index(first), names.index(second)] += value
        found.append(matrix)
    return names, *found


@pytest.mark.parametrize("rpm", [900.0, 2580.0, 4000.0])
def test_unbalance_response_equals_the_dynamic_stiffness_written_out(rpm):
    """[-w^2 M + i w (C + w G) + K + bearings(i w) + coupling] q = m e w^2 (1, -i): no states, no time."""
    values = CONSTANT.values
    names, mass, damping, gyroscopic, stiffness = bare_matrices(values)
    speed = rpm * 2 * math.pi / 60
    bearing = MagneticBearing(**{name: values[name] for name in MagneticBearing.__dataclass_fields__})
    matrix = stiffness + 1j * speed * (damping + speed * gyroscopic) - speed**2 * mass
    for node in amb_rotor.BEARING_NODES:
        for direction in "xy":
            at = names.index(f"node_{node}.{direction}")
            matrix[at, at] += bearing.dynamic_stiffness_n_m(1j * speed)
    for direction in ("x", "y", "angle_x", "angle_y"):
        at = names.index(f"node_0.{direction}")
        matrix[at, at] += 8.14e4 if direction in "xy" else 139.74
    force = np.zeros(len(names), complex)
    force[[names.index("node_6.x"), names.index("node_6.y")]] = 1.25e-4 * speed**2 * np.array([1, -1j])
    response = np.linalg.solve(matrix, force)
    expected = [response[names.index(f"node_{n}.{d}")] for n in amb_rotor.BEARING_NODES for d in "xy"]
    motion = harmonic_balance(CONSTANT, speed_rpm=rpm)
    # Both invert matrices of condition 1e9 and more, so that rounding of 1e-16 grows to 1e-8 at worst.
    np.testing.assert_allclose(motion.amplitudes[:, 1], expected, rtol=1e-8)
    assert np.abs(motion.amplitudes[:, 2:]).max() < 1e-12 * np.abs(expected).max()


def test_mass_is_that_of_shaft_and_disc():
    system = MACHINE.system(speed_rpm=4000.0)
    shaft, disc = 0.035**2 * 0.52, (0.1**2 - 0.035**2) * 0.075
    across = np.array([name.endswith(".x") for name in system.coordinates], float)
    assert across @ system.mass_matrix @ across == pytest.approx(7850 * math.pi / 4 * (shaft + disc), rel=1e-12)
    assert across @ system.mass_matrix @ across == pytest.approx(8.0, rel=0.01)


def test_modes():
    """The paper names 2580 rpm (43 Hz) only; the others are those the parameters were chosen for."""
    values = np.linalg.eigvals(MACHINE.system(speed_rpm=2580.0).core)
    modes = values[(values.imag > 10) & (np.abs(values) < 2 * math.pi * 500)]
    assert modes.size == 6
    frequency = np.sort(np.abs(modes)) / (2 * math.pi)
    assert frequency[0] == pytest.approx(2580 / 60, rel=0.01)
    assert frequency[2] == pytest.approx(56, rel=0.02)
    assert frequency[4] == pytest.approx(446, rel=0.01)


def test_integral_action_returns_the_bearings_to_the_centre():
    """A constant force on the disc ends as current: the sensors read zero, the disc itself hangs on the shaft."""
    inner = MACHINE.definition

    def build(assembly, values, switches):
        inner.build(assembly, values, switches)
        across = (assembly.places["disc"].directions["y"],)
        assembly.forces.append(harmonic_force("push", across, order=0, cos=(-80.0,), sin=(0.0,)))

    pushed = type(inner)(**{**vars(inner), "build": build})
    machine = type(MACHINE)(pushed).with_parameters(unbalance_kg_m=0.0, harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0)
    balance = harmonic_balance(machine, speed_rpm=600.0)
    assert np.abs(balance.amplitudes).max() < 1e-12
    without = harmonic_balance(machine.with_parameters(integral=0.0), speed_rpm=600.0)
    # Each bearing then is a spring k_i k_a k_sensor K_P - k_s of 308 kN/m; the coupling takes a little.
    assert without.amplitudes[[1, 3], 0].real == pytest.approx([-80 / 2 / 3.08e5] * 2, rel=0.3)


@pytest.mark.parametrize("rpm", [60.0, 2580.0, 4000.0, 4500.0])
def test_plausible_machine_is_stable_with_its_periodic_stiffness(rpm):
    assert floquet_multipliers(MACHINE, speed_rpm=rpm, steps=32).growth_rate_1_s < -1.5


def test_printed_coupling_sign_makes_the_loop_unstable_unless_the_magnets_are_printed_too():
    def growth(preset):
        return np.linalg.eigvals(MACHINE.preset(preset).system(speed_rpm=4000.0).core).real.max()

    assert growth("plausible") < 0
    assert growth("as_printed") > 10
    assert growth("as_printed_eq_7") < 0


def test_printed_unbalance_does_not_vibrate():
    motion = harmonic_balance(
        MACHINE.preset("as_printed_eq_7").with_parameters(harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0),
        speed_rpm=4000.0,
    )
    assert np.abs(motion.amplitudes[:, 1:]).max() < 1e-15


def test_printed_static_stiffness_is_not_the_one_its_formula_gives():
    assert 100 / math.atan(0.062515 / 0.072) == pytest.approx(139.86, abs=0.005)
    assert MACHINE.values["coupling_rotational_stiffness_n_m_rad"] == 139.74
    assert MACHINE.values["coupling_stiffness_n_m"] == pytest.approx(100 / 0.0012292, rel=1e-3)


def test_unbalance_of_the_machine_is_the_effect():
    by_effect = MACHINE.with_parameters(unbalance_kg_m=0.0).with_effects(
        Unbalance(at="disc", moment_kg_m=1.25e-4, angle_rad=0.0)
    )
    expected = harmonic_balance(MACHINE, speed_rpm=4000.0).amplitudes
    np.testing.assert_allclose(
        harmonic_balance(by_effect, speed_rpm=4000.0).amplitudes, expected, rtol=1e-9, atol=1e-20
    )


def test_time_stepping_ends_on_the_harmonic_balance():
    machine = MACHINE.with_effects(CouplingMisalignment(offset_m=5e-4, angle_rad=math.radians(1)))
    run = machine.simulate(speed_rpm=4000.0, duration_s=0.3, rate_hz=1000.0, settle_s=8.0)
    expected = harmonic_balance(machine, speed_rpm=4000.0).waveform(run.phase_rad)
    assert np.abs(run.signals - expected).max() < 1e-5 * np.abs(expected).max()
    # Peaks beyond the clearance are contact, which the model does not have: it must say so.
    assert np.abs(run.signals[0]).max() > 125e-6
    assert any("path_1" in note and "retainer" in note for note in run.notes)


def test_a_slow_run_up_passes_through_the_steady_amplitudes():
    """150 rpm a second: the amplitude lags by little, as the modes decay within 0.04 s."""
    run = CONSTANT.simulate(
        speed_rpm=ramp(start_rpm=2000.0, stop_rpm=2300.0, duration_s=2.0), duration_s=2.0, rate_hz=1000.0
    )
    speed_rpm = run.speed_rad_s * 60 / (2 * math.pi)
    for rpm in (2100.0, 2200.0):
        near = np.abs(speed_rpm - rpm) < 15
        steady = np.abs(harmonic_balance(CONSTANT, speed_rpm=rpm).amplitudes[:, 1])
        np.testing.assert_allclose(np.abs(run.signals[:, near]).max(axis=1), steady, rtol=0.03)


def test_every_parameter_has_a_source_and_text_keeps_the_machine():
    from rotorwise.simulators.machine import machine_from_toml

    assert all(p.source and p.meaning for p in MACHINE.definition.parameters)
    changed = MACHINE.preset("as_printed").with_parameters(damping_ratio=0.01)
    assert machine_from_toml(changed.to_toml()) == changed
