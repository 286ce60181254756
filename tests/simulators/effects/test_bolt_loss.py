"""Bolt loss: a lost bolt's share, closed form of its 1X force, Lees' Eq (18) put right, its lines, stacking."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.bolt_loss import BoltLoss
from rotorwise.simulators.effects.coupling_misalignment import CouplingMisalignment
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

MACHINE = find_machine("rigid_coupling")
ALIGNED = MACHINE.with_parameters(hole_circle_offset_m=0.0, axis_offset_m=0.0)


def amplitude(machine, order, *, probe="rotor_2.y", speed_rpm=600):
    return abs(harmonic_balance(machine, speed_rpm=speed_rpm).amplitude(probe, order))


def test_eq_18_put_right():
    # R_j exp(i phi_j) = r exp(i alpha_j) + i delta: the sum over the bolts that are left, less that of flange 1.
    machine = MACHINE.with_effects(BoltLoss(loss=1.0, angle_rad=0.0))
    flange = machine.assembly(speed_rpm=600).components["flange"]
    alpha, delta, radius = 2 * np.pi * np.arange(4) / 4, 5e-4, 0.3
    distance = np.sqrt(radius**2 + delta**2 + 2 * radius * delta * np.sin(alpha))
    angle = np.arctan2(delta + radius * np.sin(alpha), radius * np.cos(alpha))
    left = flange.stiffness_shares
    sum_2 = np.sum(left * distance * np.exp(1j * angle))
    sum_1 = np.sum(left * radius * np.exp(1j * alpha))
    total, first = flange.stiffness_moments()
    assert sum_2 - sum_1 == pytest.approx(3j * delta, abs=1e-15)
    assert sum_2 == pytest.approx(radius * first + total * 1j * delta, abs=1e-15)
    assert list(left) == [0.0, 1.0, 1.0, 1.0]


@pytest.mark.parametrize("loss", [0.2, 0.6, 1.0])
def test_load_makes_1x_in_proportion_on_an_aligned_flange(loss, figure):
    # Statics: what is left of the bolts holds the torque, and one without its opposite's share pushes with
    # loss T / (sum of shares r): a weakened bolt in proportion to what it lacks.
    lost = ALIGNED.with_effects(BoltLoss(loss=loss))
    one, two = (amplitude(lost.with_parameters(load_torque_n_m=load), 1.0) for load in (100.0, 200.0))
    assert two == pytest.approx(2 * one, rel=0.02)
    push = loss * 100.0 / ((4 - loss) * 0.3)
    # Both rotors on their supports, pushed apart, at 10 Hz and without damping (errors of 1 % of 1 / 15).
    values, omega2 = MACHINE.values, (20 * math.pi) ** 2
    k1, k2 = (values[f"support_{i}_n_m"] - values[f"mass_{i}_kg"] * omega2 for i in (1, 2))
    coupling = (4 - loss) * values["bolt_stiffness_n_m"]
    expected = push * k1 / (k1 * k2 + coupling * (k1 + k2))
    assert one == pytest.approx(expected, rel=0.03)
    figure("1X of a loaded flange with a lost bolt against closed form", one, expected)


def test_without_load_and_offset_a_lost_bolt_is_silent():
    silent = ALIGNED.with_parameters(load_torque_n_m=0.0).with_effects(BoltLoss(loss=1.0))
    assert np.abs(harmonic_balance(silent, speed_rpm=600).amplitudes).max() < 1e-15


@pytest.mark.parametrize("speed_rpm", [600, 1200, 2100])
def test_its_lines_rise(speed_rpm):
    effect = BoltLoss()
    for line in effect.signature(MACHINE):
        probe = "twist" if line.direction == "torsion" else "rotor_2.x"
        before = amplitude(MACHINE, line.order, probe=probe, speed_rpm=speed_rpm)
        after = amplitude(MACHINE.with_effects(effect), line.order, probe=probe, speed_rpm=speed_rpm)
        assert after > 10 * before


def test_zero_strength_changes_nothing():
    base, same = (m.system(speed_rpm=900) for m in (MACHINE, MACHINE.with_effects(BoltLoss().at_zero())))
    assert np.array_equal(base.core, same.core)
    assert [force.parameters for force in base.forces] == [force.parameters for force in same.forces]


def test_stacks_with_itself_and_others_in_any_order():
    effects = [
        BoltLoss(loss=0.5),
        BoltLoss(loss=0.4),
        BoltLoss(loss=0.7, angle_rad=math.pi),
        CouplingMisalignment(offset_m=2e-4, angle_rad=0.0, offset_phase_rad=1.0, angle_phase_rad=0.0),
        Unbalance(at="rotor_2"),
    ]
    there, back = (
        harmonic_balance(MACHINE.with_effects(*order), speed_rpm=900).amplitudes for order in (effects, effects[::-1])
    )
    assert there == pytest.approx(back, abs=1e-12)
    flange = MACHINE.with_effects(*effects).assembly(speed_rpm=900).components["flange"]
    assert flange.stiffness_shares == pytest.approx([0.5 * 0.6, 1.0, 0.3, 1.0])


def test_machine_without_bolts_is_refused():
    with pytest.raises(MissingPartError, match="bolted_coupling"):
        find_machine("amb_rotor").with_effects(BoltLoss()).system(speed_rpm=1200)
