"""Sinusoidal forces on linear machines: the simulated and the balanced motion, and where the sum does not hold."""

import numpy as np
import pytest
from rotorwise.simulators.effect import Effect, make_effect
from rotorwise.simulators.machine import Machine, find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.solvers.simulate import simulate_motion
from rotorwise.simulators.solvers.superposed_waves import superposed_waves

TWICE_LINE = make_effect("twice_line_force", {"force_n": 20.0, "torque_n_m": 1.0, "phase_rad": 0.7})
SPEED_RPM, RATE_HZ = 1390.0, 4000.0
NO_HARMONICS = {"harmonic_1": 0.0, "harmonic_2": 0.0, "harmonic_3": 0.0}


@pytest.mark.parametrize(
    "effect",
    [
        TWICE_LINE,
        make_effect("pole_pass", {"force_n": 10.0, "torque_n_m": 0.5, "slip": 0.03}),
        make_effect("load_fluctuation", {"radial_n": 8.0, "frequency_hz": 7.3, "direction_rad": 0.4}),
    ],
    ids=lambda one: one.NAME,
)
def test_the_sum_is_the_simulated_motion(effect: Effect):
    machine = find_machine("test_rig")
    waves = superposed_waves(machine.with_effects(effect), machine, speed_rpm=SPEED_RPM)
    assert waves
    cases = [(machine.with_effects(effect), SPEED_RPM), (machine, SPEED_RPM)]
    with_, without = simulate_motion(cases, duration_s=0.5, rate_hz=RATE_HZ, settle_s=3.0)
    time_s = np.arange(with_.signals.shape[1]) / RATE_HZ
    found = sum((wave.waveform(with_.phase_rad, time_s) for wave in waves), np.zeros(with_.signals.shape))
    wanted = with_.signals - without.signals
    # What stands still is no wave.
    error = (found - wanted) - (found - wanted).mean(axis=1, keepdims=True)
    assert np.abs(error).max() < 2e-3 * np.abs(wanted).max()


def test_at_an_order_it_is_the_balanced_motion():
    machine = find_machine("amb_rotor").with_parameters(**NO_HARMONICS)
    turning = machine.with_effects(make_effect("rotating_coupling_force", {"force_n": 5.0, "angle_rad": 0.3}))
    waves = superposed_waves(turning, machine, speed_rpm=SPEED_RPM)
    assert waves
    both = [harmonic_balance(one, speed_rpm=SPEED_RPM).amplitudes[:, 1] for one in (turning, machine)]
    assert np.abs(waves[0].amplitudes).max() > 1e-9
    np.testing.assert_allclose(waves[0].amplitudes, both[0] - both[1], rtol=1e-7)


@pytest.mark.parametrize(
    ("machine", "effect"),
    [
        (find_machine("gearbox"), make_effect("load_fluctuation", {"torque_n_m": 8.0, "frequency_hz": 7.3})),
        (find_machine("test_rig").with_effects(make_effect("coupling_stiffness_harmonics", {"x_2": 0.2})), TWICE_LINE),
        (find_machine("test_rig"), make_effect("support_anisotropy", {"fraction": 0.2})),
        (find_machine("test_rig"), make_effect("unbalance", {"moment_kg_m": 1e-4})),
    ],
    ids=["contacts", "stiffness that turns", "another core", "no sinusoid"],
)
def test_where_the_sum_does_not_hold_there_is_none(machine: Machine, effect: Effect):
    assert superposed_waves(machine.with_effects(effect), machine, speed_rpm=SPEED_RPM) is None
