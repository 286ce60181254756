"""Twice-line force: frequency fixed by the supply, balance between rotor and stator, closed form in torsion."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.twice_line_force import TwiceLineForce
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

RIG = find_machine("test_rig")


def test_torsion_has_its_closed_form(figure):
    # The driver alone turns when the flange is cut: T / (K - I w^2 + i w c).
    machine = find_machine("rigid_coupling").with_parameters(bolt_stiffness_n_m=1.0, torsional_damping_n_m_s_rad=0.0)
    values, omega = machine.values, 2 * math.pi * 100
    inertia = values["mass_1_kg"] * values["gyration_radius_1_m"] ** 2
    effect = TwiceLineForce(torque_n_m=50.0)
    system = machine.with_effects(effect).system(speed_rpm=3000)
    force = next(f for f in system.forces if "twice-line" in f.name)
    assert force.parameters[0] == 100.0
    response = np.linalg.solve(1j * omega * np.eye(system.states) - system.core, system.force_columns)
    column = system.outputs[system.forces.index(force)][0]
    expected = 1 / (
        values["drive_stiffness_n_m_rad"] - inertia * omega**2 + 1j * omega * values["drive_damping_n_m_s_rad"]
    )
    turn = system.row({"rotor_1.torsion": 1.0}) @ response[:, column]
    assert turn == pytest.approx(expected, rel=1e-4)
    figure("Torsion at twice the supply's frequency against closed form", turn, expected)


@pytest.mark.parametrize(("supply_hz", "speed_rpm", "order"), [(50.0, 3000, 2.0), (50.0, 1500, 4.0), (60.0, 1800, 4.0)])
def test_frequency_is_twice_the_supply(supply_hz, speed_rpm, order):
    effect = TwiceLineForce(supply_hz=supply_hz, force_n=20.0)
    base, changed = (harmonic_balance(m, speed_rpm=speed_rpm) for m in (RIG, RIG.with_effects(effect)))
    added = np.abs(changed.amplitudes - base.amplitudes).max(axis=0)
    assert changed.orders[np.argmax(added)] == order
    assert np.delete(added, int(order)).max() < 1e-6 * added.max()
    assert all(line.order_at(speed_rpm) == pytest.approx(order) for line in effect.signature(RIG))


def test_pull_and_counter_pull_leave_the_whole_machine_in_place():
    # An inner force: it does no work when rotor and frame move together.
    system = RIG.with_effects(TwiceLineForce(force_n=1.0, torque_n_m=0.0, direction_rad=0.3)).system(speed_rpm=1500)
    places = RIG.bare_assembly().places
    force = next(f for f in system.forces if "twice-line" in f.name)
    pull = force.outputs[-1]
    for axis, share in (("x", math.cos(0.3)), ("y", math.sin(0.3))):
        rotor, frame = (places[name].directions[axis] for name in ("motor", "motor_frame"))
        assert sum(pull.get(key, 0.0) * value for key, value in rotor.items()) == pytest.approx(share, rel=0.2)
        # Translation of everything: one along the plate's own axis and the rotor's.
        together = [f"motor.{axis}", next(key for key in frame if key.endswith(f".{axis}"))]
        assert sum(pull.get(key, 0.0) for key in together) == pytest.approx(0.0, abs=1e-12)


def test_grows_in_proportion():
    one, two, base = (
        harmonic_balance(m, speed_rpm=1500).amplitudes
        for m in (
            RIG.with_effects(TwiceLineForce(force_n=5.0, torque_n_m=0.0)),
            RIG.with_effects(TwiceLineForce(force_n=10.0, torque_n_m=0.0)),
            RIG,
        )
    )
    assert two - base == pytest.approx(2 * (one - base), rel=1e-6, abs=1e-12)


def test_machine_without_a_motor():
    with pytest.raises(MissingPartError, match="motor"):
        find_machine("amb_rotor").with_effects(TwiceLineForce()).system(speed_rpm=1500)
