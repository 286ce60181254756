"""Empirical force: closed form of its law, and with the right law it is an unbalance."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.empirical_force import FARTHEST, EmpiricalForce
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

RIGID = find_machine("rigid_coupling")
RIG = find_machine("test_rig")


def force_of(machine, effect):
    assembly = machine.with_effects(effect).assembly(speed_rpm=1000)
    return next(force for force in assembly.forces if force.name.startswith("empirical"))


def values(force, *, speed_rpm, phase_rad):
    phase = np.atleast_1d(phase_rad)[:, None]
    speed = np.full_like(phase, 2 * math.pi * speed_rpm / 60)
    timeline = Timeline(np.zeros_like(phase), phase, speed, np.zeros_like(phase))
    return force.law.signals(timeline, np.array(force.parameters)[:, None])[:, :, 0]


@pytest.mark.parametrize(("power", "speed_rpm"), [(2.0, 2000.0), (-1.5, 700.0), (0.0, 3000.0)])
def test_the_law_is_a_power_of_speed_and_load(power, speed_rpm):
    effect = EmpiricalForce(
        at="rotor_1",
        force_n=3.0,
        direction_rad=0.0,
        phase_rad=0.4,
        order=2.5,
        speed_exponent=power,
        reference_speed_rpm=1000.0,
        load_exponent=0.5,
        reference_load=40.0,
    )
    force = force_of(RIGID.with_parameters(load_torque_n_m=90.0), effect)
    phase = np.linspace(0, 20, 50)
    expected = 3.0 * (speed_rpm / 1000) ** power * 1.5 * np.cos(2.5 * phase + 0.4)
    assert values(force, speed_rpm=speed_rpm, phase_rad=phase)[0] == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_x_and_y_a_quarter_period_apart_are_an_unbalance(figure):
    moment, angle, reference = 8e-3, 0.8, 1000.0
    size = moment * (2 * math.pi * reference / 60) ** 2
    law = {"force_n": size, "speed_exponent": 2.0, "reference_speed_rpm": reference, "at": "rotor_2"}
    pair = (
        EmpiricalForce(direction_rad=0.0, phase_rad=angle, **law),
        EmpiricalForce(direction_rad=math.pi / 2, phase_rad=angle - math.pi / 2, **law),
    )
    for rpm in (600, 1700):
        one = harmonic_balance(RIGID.with_effects(*pair), speed_rpm=rpm).amplitudes
        two = harmonic_balance(
            RIGID.with_effects(Unbalance(at="rotor_2", moment_kg_m=moment, angle_rad=angle)), speed_rpm=rpm
        ).amplitudes
        assert one == pytest.approx(two, rel=1e-9, abs=1e-9 * np.abs(two).max())
        figure("Forces in x and y that grow as speed^2, against unbalance", one, two)


def test_thrust_and_torque_act_where_the_place_moves_so():
    effect = EmpiricalForce(at="disc", force_n=0.0, axial_n=5.0, torque_n_m=-2.0, order=3.0)
    force = force_of(RIG, effect)
    assert values(force, speed_rpm=1000, phase_rad=0.0)[:, 0] == pytest.approx([5.0, -2.0])
    assert [line.direction for line in effect.signature(RIG)] == ["axial", "torsion"]


def test_motions_that_the_place_does_not_have_are_said():
    effect = EmpiricalForce(at="load", force_n=7.0)
    notes = RIGID.with_effects(effect).assembly(speed_rpm=1000).notes
    assert any("torsion only; no force acts" in note for note in notes)
    assert not effect.signature(RIGID)


def test_the_law_ends_where_no_measurement_reached():
    effect = EmpiricalForce(at="rotor_1", force_n=1.0, direction_rad=0.0, speed_exponent=-2.0)
    standing = values(force_of(RIGID, effect), speed_rpm=0.0, phase_rad=0.0)
    assert standing[0, 0] == FARTHEST


def test_a_load_of_nothing_leaves_no_force_that_grows_with_it():
    effect = EmpiricalForce(at="rotor_1", load_exponent=1.0)
    unloaded = RIGID.with_parameters(load_torque_n_m=0.0)
    assert not values(force_of(unloaded, effect), speed_rpm=900.0, phase_rad=0.3).any()


def test_unknown_place():
    with pytest.raises(MissingPartError, match=r"'rotor_9'.*rotor_1"):
        RIGID.with_effects(EmpiricalForce(at="rotor_9")).system(speed_rpm=1000)
