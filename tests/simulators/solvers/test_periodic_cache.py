"""Harmonic balance keeps what it computed: the answers must not depend on what was asked before, or together."""

import itertools

import numpy as np
import pytest
from rotorwise.simulators.effect import make_effect
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers import frequency_response, harmonic_balance

SPEEDS_RPM = (900.0, 1740.0, 2950.0)
# Without forces that read motion, with stiffness harmonics, with a core of its own, not linear, with a static load.
CASES = [
    ("amb_rotor", "unbalance"),
    ("amb_rotor", "rub"),
    ("amb_rotor", "breathing_crack"),
    ("rigid_coupling", "bolt_loss"),
    ("test_rig", "unbalance"),
    ("test_rig", "coupling_misalignment"),
    ("test_rig", "looseness"),
    ("test_rig", "soft_foot"),
]


@pytest.fixture(autouse=True)
def _nothing_known():
    frequency_response.forget()
    harmonic_balance.forget()


def amplitudes(machine):
    """Return the lines over the largest one of a probe of the same quantity, shape (speeds, probes, orders)."""
    found = harmonic_balance.harmonic_balance_at_speeds(machine, SPEEDS_RPM, harmonics=8)
    return np.array([over_largest(motion) for motion in found])


def limit_of(machine):
    # The rig's mounts are so soft beside its shaft that rounding its stiffness matrix alone costs 1e-11; a nonlinear
    # machine's last Newton step moves it by up to 1e-10.
    if not machine.system(speed_rpm=SPEEDS_RPM[0]).is_linear:
        return 1e-10
    return 1e-11 if machine.name == "test_rig" else 1e-12


def over_largest(motion):
    quantities = [probe.quantity for probe in motion.probes]
    largest = {q: np.abs(motion.amplitudes[[own == q for own in quantities]]).max() for q in set(quantities)}
    return motion.amplitudes / np.array([largest[q] or 1.0 for q in quantities])[:, None]


@pytest.mark.parametrize(("name", "effect"), CASES)
def test_kept_and_computed_anew_agree(name, effect):
    machine = find_machine(name).with_effects(make_effect(effect, {}))
    first = amplitudes(machine)
    # Asked for again: of the second time on the core's inverse is kept, and of the first on the system.
    assert harmonic_balance.kept_systems() == 1
    again = [amplitudes(machine) for _ in range(3)]
    limit = limit_of(machine)
    assert frequency_response.kept_inverses() == len(SPEEDS_RPM)
    for other in again:
        assert np.abs(first - other).max() < limit
    assert np.array_equal(again[1], again[2])


@pytest.mark.parametrize(("name", "effect"), CASES)
def test_speeds_together_and_alone_agree(name, effect):
    machine = find_machine(name).with_effects(make_effect(effect, {}))
    together = amplitudes(machine)
    for i, speed in enumerate(SPEEDS_RPM):
        frequency_response.forget()
        harmonic_balance.forget()
        alone = harmonic_balance.harmonic_balance(machine, speed_rpm=speed, harmonics=8)
        assert alone.speed_rad_s == pytest.approx(speed * 2 * np.pi / 60)
        assert np.abs(together[i] - over_largest(alone)).max() < limit_of(machine)


def test_another_machine_is_not_taken_for_a_known_one():
    rig = find_machine("test_rig")
    machines = [rig, rig.with_parameters(mount_stiffness_n_m=3e4), rig.with_effects(make_effect("unbalance", {}))]
    before = [amplitudes(machine) for machine in machines]
    for one, other in itertools.pairwise(before):
        assert np.abs(one - other).max() > 1e-3
    for machine, known in zip(machines, before, strict=True):
        harmonic_balance.forget()
        frequency_response.forget()
        assert np.abs(known - amplitudes(machine)).max() < limit_of(machine)


@pytest.mark.parametrize("name", ["amb_rotor", "rigid_coupling", "test_rig"])
def test_responses_are_those_of_the_first_order_core(name):
    # (i k w - L) y = B u, the states y = [q, i k w q, z] following from the displacements.
    machine, speed = find_machine(name), 2 * np.pi * 35
    system = machine.system(speed_rpm=35 * 60)
    lane = frequency_response.Spinning(speed, speed, 6)
    n = len(system.coordinates)
    found = frequency_response.responses([system], [lane], np.eye(n), system.force_directions)[0]
    for order in range(1, 7):
        rate = 1j * order * speed
        states = np.linalg.solve(rate * np.eye(system.states) - system.core, system.force_columns)
        # The first-order equations of these machines lose seven digits, the second-order ones five.
        assert found[order] == pytest.approx(states[:n], rel=0, abs=1e-8 * np.abs(states[:n]).max())


def test_static_response_is_the_stiffness_and_what_controllers_hold():
    machine = find_machine("rigid_coupling")
    system = machine.system(speed_rpm=1000.0)
    still = [frequency_response.Spinning(100.0, 100.0, 1)]
    columns = system.force_directions
    found = frequency_response.responses([system], still, np.eye(len(system.coordinates)), columns)[0, 0]
    assert system.stiffness_matrix @ found == pytest.approx(columns, abs=1e-12)
    # The integrators of magnetic bearings hold the journals' places against any constant force.
    system = find_machine("amb_rotor").system(speed_rpm=1000.0)
    probes, columns = system.probe_directions, system.force_directions
    found = frequency_response.responses([system], still, probes, columns)[0]
    assert np.abs(found[0]).max() < 1e-9 * np.abs(found[1]).max()


def test_systems_serve_all_speeds_only_where_nothing_follows_the_speed():
    rig = find_machine("test_rig")
    assert not rig.assembly(speed_rpm=1000.0).follows_speed
    assembly = rig.bare_assembly()
    assert assembly.speed_rad_s == 0
    assert assembly.follows_speed
    assert assembly.copy().follows_speed
