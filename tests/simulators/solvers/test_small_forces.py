"""Small forces beside a periodic motion, against the balance with a force of that size."""

import numpy as np
import pytest
from rotorwise.simulators.effect import make_effect
from rotorwise.simulators.machine import Machine, find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance_at_speeds
from rotorwise.simulators.solvers.small_forces import small_force_responses

SPEEDS_RPM = (1500.0, 2400.0)


#: A loose support that keeps the motion periodic at these speeds.
LOOSE = {"loss": 0.5}


def _faulty(name: str, effect: str | None) -> Machine:
    machine = find_machine(name)
    return machine.with_effects(make_effect(effect, LOOSE if effect == "looseness" else {})) if effect else machine


@pytest.mark.parametrize(
    ("name", "effect", "place", "force_n"),
    [
        ("amb_rotor", None, "disc", 1.0),
        ("test_rig", "breathing_crack", "disc", 1.0),
        ("rigid_coupling", None, "rotor_1", 1e-2),
        ("rigid_coupling", "looseness", "rotor_2", 1e-3),
    ],
)
@pytest.mark.parametrize(("order", "revolutions"), [(1.0, 1), (1.5, 2), (3.0, 1)])
def test_lines_of_a_small_force_are_those_that_the_balance_adds(name, effect, place, force_n, order, revolutions):
    machine = _faulty(name, effect)
    directions = [machine.bare_assembly().places[place].directions[way] for way in "xy"]
    options = {"harmonics": 6, "revolutions": revolutions}
    found = small_force_responses(machine, directions, speeds_rpm=SPEEDS_RPM, **options)
    plain = harmonic_balance_at_speeds(machine, SPEEDS_RPM, **options)
    for column, direction_rad in enumerate((0.0, np.pi / 2)):
        for part, phase_rad in enumerate((0.0, np.pi / 2)):
            values = {"force_n": force_n, "order": order, "direction_rad": direction_rad, "phase_rad": phase_rad}
            pushed = machine.with_effects(make_effect("empirical_force", values, at=place))
            moved = harmonic_balance_at_speeds(pushed, SPEEDS_RPM, **options)
            at = round(order * revolutions)
            added = np.stack([b.amplitudes[:, at] - a.amplitudes[:, at] for a, b in zip(plain, moved, strict=True)])
            own = found[part, :, at, at, :, column]
            assert np.abs(own - added / force_n).max() < 2e-3 * np.abs(own).max()
            spread = np.stack([b.amplitudes - a.amplitudes for a, b in zip(plain, moved, strict=True)]) / force_n
            everywhere = found[part, :, :, at, :, column].transpose(0, 2, 1)
            # A motion of one turn couples orders that are whole numbers apart.
            order_numbers = np.arange(everywhere.shape[-1])
            coupled = (order_numbers > 0) & ((order_numbers - at) % revolutions == 0)
            assert np.abs(everywhere - spread)[..., 1:].max() < 2e-3 * np.abs(own).max()
            assert np.abs(everywhere[..., ~coupled]).max(initial=0) < 1e-9 * np.abs(own).max()


def test_a_periodic_stiffness_answers_the_conjugate_of_a_force_too():
    machine = find_machine("amb_rotor")
    direction = machine.bare_assembly().places["disc"].directions["x"]
    found = small_force_responses(machine, [direction], speeds_rpm=SPEEDS_RPM, harmonics=6)
    # Of a machine that does not change with the angle the second is i times the first.
    assert np.abs(found[1] - 1j * found[0])[:, 1, 1].max() > 0.01 * np.abs(found[0, :, 1, 1]).max()
    # And with lines at other orders.
    assert np.abs(found[0, :, 2, 1]).max() > 0.01 * np.abs(found[0, :, 1, 1]).max()
    rig = find_machine("test_rig")
    direction = rig.bare_assembly().places["disc"].directions["x"]
    found = small_force_responses(rig, [direction], speeds_rpm=SPEEDS_RPM, harmonics=6)
    np.testing.assert_allclose(found[1], 1j * found[0], rtol=1e-9, atol=1e-12 * np.abs(found).max())
