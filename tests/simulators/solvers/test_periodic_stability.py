"""Whether a periodic motion lasts: Duffing's three motions, Mathieu's regions, and a rub that whips."""

import numpy as np
import pytest
from rotorwise.simulators.effects import Rub, Unbalance
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers import periodic_stability
from rotorwise.simulators.solvers.floquet import floquet_multipliers
from rotorwise.simulators.solvers.harmonic_balance import NoPeriodicMotionError, harmonic_balances
from rotorwise.simulators.solvers.periodic_forces import periodic_forces
from rotorwise.simulators.solvers.periodic_stability import largest_multipliers

from .small_machines import duffing

RPM = 60.0 / (2 * np.pi)
STIFFNESS, CUBIC, DRIVE, DAMPING = 100.0, 50.0, 10.0, 0.5


def _growth(machine, speeds_rad_s, harmonics):
    """Return the largest multiplier about motions given by their harmonics (speeds, orders, motions)."""
    systems = [machine.system(speed_rpm=w * RPM) for w in speeds_rad_s]
    return largest_multipliers(periodic_forces(systems, speeds_rad_s, 128, 1), harmonics, speeds_rad_s, 1)


def _response(amplitude, w):
    """Return the drive that holds an amplitude, by one-term balance."""
    return np.hypot((STIFFNESS - w**2) * amplitude + 0.75 * CUBIC * amplitude**3, DAMPING * w * amplitude)


def test_of_duffings_three_motions_the_middle_one_does_not_last():
    w = 12.0
    sizes = np.linspace(1e-3, 2.0, 200_001)
    crossing = np.flatnonzero(np.diff(np.sign(_response(sizes, w) - DRIVE)))
    amplitudes = sizes[crossing]
    assert amplitudes.size == 3
    machine = duffing(stiffness=STIFFNESS, cubic=CUBIC, drive=DRIVE, damping=DAMPING)
    harmonics = np.zeros((3, 2, 1), dtype=complex)
    phase = np.angle(STIFFNESS - w**2 + 0.75 * CUBIC * amplitudes**2 + 1j * DAMPING * w)
    harmonics[:, 1, 0] = amplitudes / 2 * np.exp(-1j * phase)
    small, middle, large = _growth(machine, [w] * 3, harmonics)
    assert small < 1
    assert large < 1
    assert middle > 1.1


def test_multipliers_are_those_of_the_linear_machine_about_rest():
    # At rest the cubic spring has no slope: Mathieu's equation, stable or not with the speed.
    machine = duffing(stiffness=STIFFNESS, cubic=CUBIC, parametric=20.0, damping=0.05)
    linear = duffing(stiffness=STIFFNESS, cubic=0.0, parametric=20.0, damping=0.05)
    speeds = [14.0, 19.5, 20.0, 21.0, 30.0]
    found = _growth(machine, speeds, np.zeros((len(speeds), 2, 1), dtype=complex))
    exact = [abs(floquet_multipliers(linear, speed_rpm=w * RPM).multipliers[0]) for w in speeds]
    assert max(exact) > 1.1
    assert min(exact) < 1
    np.testing.assert_allclose(found, exact, rtol=2e-3)


def test_growth_beyond_all_numbers_is_infinite_and_no_error():
    # About x = 1 the spring pushes away; at this rate a step of the rule multiplies by 2e4, 128 of them by 1e550.
    rate = 1.0001 * 128 / np.pi
    machine = duffing(stiffness=1.0, cubic=-(rate**2 + 1.0) / 3.0, damping=0.0)
    away = np.zeros((1, 2, 1), dtype=complex)
    away[0, 0, 0] = 1.0
    assert _growth(machine, [1.0], away)[0] == np.inf


def test_of_a_shaft_that_hardly_turns_all_motions_follow_at_once():
    machine = duffing(stiffness=1.0, cubic=1.0, damping=0.1)
    assert _growth(machine, [1e-3], np.zeros((1, 2, 1), dtype=complex))[0] == 0.0


def test_motions_of_one_frequency_stay_on_one_side_of_the_limit():
    # Two like oscillators exactly at the limit: a cut between their four eigenvalues could not be told apart.
    core = np.kron(np.array([[0.0, 1.0], [-100.0, -0.1]]), np.eye(2))
    parts = periodic_stability._decoupled(core, 10.0)
    assert parts.slow.shape[0] in (0, 4)
    assert np.isfinite(parts.fast).all()


def _whip():
    """Return a rubbing machine that, in the time step, leaves the rub's synchronous motion for a whirl of its own."""
    rub = Rub(at="seal_2", stiffness_n_m=4.7e6, friction=0.28, interference_m=-3e-6, clearance_m=1.2e-4, angle_rad=1.6)
    return find_machine("rigid_coupling").with_effects(Unbalance(at="rotor_2", moment_kg_m=0.02), rub)


def test_a_rub_that_whips_has_a_synchronous_motion_that_does_not_last():
    machine = _whip()
    (any_motion,) = harmonic_balances([(machine, [1900.0])], harmonics=12)
    assert not isinstance(any_motion, Exception)
    (lasting,) = harmonic_balances([(machine, [1900.0])], harmonics=12, only_stable=[True])
    assert isinstance(lasting, NoPeriodicMotionError)
    assert "does not last" in str(lasting)
    run = machine.simulate(speed_rpm=1900.0, duration_s=1.0, rate_hz=2000.0, settle_s=5.0)
    synchronous = np.abs(any_motion[0].waveform(run.phase_rad)).max()
    assert np.abs(run.probe("rotor_2.x")).max() > 3 * synchronous


def test_a_light_rub_keeps_its_motion():
    rub = Rub(at="seal_2", stiffness_n_m=1e5, friction=0.05, interference_m=2e-6, clearance_m=2e-4)
    machine = find_machine("rigid_coupling").with_effects(Unbalance(at="rotor_2", moment_kg_m=0.02), rub)
    one, other = (
        harmonic_balances([(machine, [700.0])], harmonics=12, only_stable=[flag])[0] for flag in (True, False)
    )
    # Not to the last bit: numpy rounds by where its arrays lie in memory.
    np.testing.assert_allclose(one[0].amplitudes, other[0].amplitudes, rtol=1e-9, atol=1e-18)


@pytest.mark.parametrize("name", ["amb_rotor", "test_rig"])
def test_slow_motions_alone_tell_the_growth(name, monkeypatch):
    machine = find_machine(name)
    speeds = [60.0, 150.0]
    systems = [machine.system(speed_rpm=w * RPM) for w in speeds]
    forces = periodic_forces(systems, speeds, 128, 1)
    rest = np.zeros((2, 2, systems[0].motion_rows.shape[0]), dtype=complex)
    few = largest_multipliers(forces, rest, speeds, 1)
    monkeypatch.setattr("rotorwise.simulators.solvers.periodic_stability.SLOW", 1e6)
    every = largest_multipliers(forces, rest, speeds, 1)
    np.testing.assert_allclose(few, every, rtol=1e-3)
