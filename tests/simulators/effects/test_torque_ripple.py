"""Torque ripple: closed form of the twist, side lines through an offset flange, where it acts."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.torque_ripple import TorqueRipple
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

MACHINE = find_machine("rigid_coupling")
REDUCED = MACHINE.preset("paper_reduction")
ALIGNED = REDUCED.with_parameters(hole_circle_offset_m=0.0, axis_offset_m=0.0)


def amplitude(machine, order, *, probe="rotor_2.y", speed_rpm=600):
    return abs(harmonic_balance(machine, speed_rpm=speed_rpm).amplitude(probe, order))


@pytest.mark.parametrize("order", [1.0, 2.0, 3.0])
def test_twist_of_a_single_inertia_has_its_closed_form(order, figure):
    # Aligned, rotor 1 immovable: T / |K r^2 - I w^2 + i w c|.
    machine = ALIGNED.with_effects(TorqueRipple(torque_n_m=1.0, order=order))
    values, omega = machine.values, order * 2 * math.pi * 10
    dynamic = 4 * values["bolt_stiffness_n_m"] * 0.09 - 9.0 * omega**2 + 1j * omega * 2 * 0.001 * 9 * 40 * math.pi
    # The sine of the twist softens the torsion by twist^2 / 8, which shows at resonance (order 2) only.
    assert amplitude(machine, order, probe="twist") == pytest.approx(1.0 / abs(dynamic), rel=2e-3)
    figure("Twist by the ripple against closed form", amplitude(machine, order, probe="twist"), 1.0 / abs(dynamic))
    assert amplitude(machine, 1.0) < 1e-15


@pytest.mark.parametrize("order", [2.0, 3.0])
def test_offset_flange_turns_it_into_side_lines(order):
    # The push K N h exp(i(phi + twist)) has sidebands K N h e / 2 at order - 1 (turning backward) and order + 1.
    effect = TorqueRipple(torque_n_m=5.0, order=order)
    machine = REDUCED.with_effects(effect)
    # The flange's own lines are there already; the ripple's add to them.
    base, rippled = (harmonic_balance(m, speed_rpm=780) for m in (REDUCED, machine))
    twist = abs(rippled.amplitude("twist", order))
    values = machine.values
    for side in (order - 1, order + 1):
        omega = side * 2 * math.pi * 13
        total = values["support_2_n_m"] + 4 * values["bolt_stiffness_n_m"]
        dynamic = total - 100 * omega**2 + 1j * omega * values["support_damping_2_n_s_m"]
        expected = 4 * values["bolt_stiffness_n_m"] * 5e-4 * twist / 2 / abs(dynamic)
        added = rippled.amplitude("rotor_2.y", side) - base.amplitude("rotor_2.y", side)
        assert abs(added) == pytest.approx(expected, rel=2e-3)
    assert {line.order for line in effect.signature(machine)} == {order, order - 1, order + 1}


@pytest.mark.parametrize("speed_rpm", [600, 1320])
def test_its_lines_rise(speed_rpm):
    effect = TorqueRipple(torque_n_m=50.0)
    for line in effect.signature(MACHINE):
        probe = "twist" if line.direction == "torsion" else "rotor_2.x"
        before = amplitude(MACHINE, line.order, probe=probe, speed_rpm=speed_rpm)
        after = amplitude(MACHINE.with_effects(effect), line.order, probe=probe, speed_rpm=speed_rpm)
        assert after > 2 * before


def test_order_counts_on_its_own_shaft():
    gearbox = find_machine("gearbox")
    assembly = gearbox.with_effects(TorqueRipple(order=2.0)).assembly(speed_rpm=1800)
    ratio = assembly.place("load").shaft_ratio
    force = next(force for force in assembly.forces if "ripple" in force.name)
    assert ratio < 1
    assert force.parameters[0] == pytest.approx(2.0 * ratio)
    assert TorqueRipple(order=2.0).signature(gearbox)[0].order == pytest.approx(2.0 * ratio)


def test_acts_where_it_is_told():
    moved = {}
    for place in ("driver", "rotor_2"):
        machine = ALIGNED.with_effects(TorqueRipple(at=place, torque_n_m=10.0))
        moved[place] = amplitude(machine, 1.0, probe="rotor_2.torsion")
    # The immovable driver takes the torque up.
    assert moved["driver"] < 1e-9
    assert moved["rotor_2"] > 1e-5


def test_phase_moves_with_the_angle():
    first, second = (
        harmonic_balance(ALIGNED.with_effects(TorqueRipple(angle_rad=angle)), speed_rpm=600).amplitude("twist", 1.0)
        for angle in (0.0, 0.8)
    )
    assert np.angle(second / first) == pytest.approx(0.8, abs=1e-9)


def test_refuses_a_machine_without_torsion_and_an_unknown_place():
    with pytest.raises(MissingPartError, match="torsion is not modelled"):
        find_machine("amb_rotor").with_effects(TorqueRipple()).system(speed_rpm=1200)
    with pytest.raises(MissingPartError, match="rotor_2"):
        MACHINE.with_effects(TorqueRipple(at="bearing_1")).system(speed_rpm=1200)
