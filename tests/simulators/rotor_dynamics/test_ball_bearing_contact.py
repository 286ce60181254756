"""Hertz contacts of a ball bearing: closed forms, potential, symmetry."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators.assembly import Assembly
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machines.gearbox import BEARING_6304
from rotorwise.simulators.rotor_dynamics.ball_bearing_contact import BallBearingContact
from rotorwise.simulators.rotor_dynamics.rolling_bearing import BearingGeometry
from rotorwise.simulators.system import build_system

STIFFNESS, CLEARANCE = 1e10, 5e-6


def bearing(**changes):
    values = {
        "name": "bearing",
        "geometry": BEARING_6304,
        "contact_stiffness": STIFFNESS,
        "clearance_m": CLEARANCE,
        "x": {"x": 1.0},
        "y": {"y": 1.0},
    }
    return BallBearingContact(**{**values, **changes})


def law_force(part, motion, phase_rad=0.0, *, compiled=True):
    """Force on the inner ring from the interface force and the spring of the core, shape (2, lanes)."""
    motion = np.ascontiguousarray(np.array(motion, dtype=float).reshape(2, -1))
    lanes = motion.shape[1]
    force = part.interface_force()
    parameters = np.repeat(np.array(force.parameters)[:, None], lanes, axis=1)
    instant = np.zeros((1, lanes))
    timeline = Timeline(instant, np.full((1, lanes), phase_rad), instant + 1.0, instant)
    signals = np.ascontiguousarray(force.law.signals(timeline, parameters)[:, 0])
    rows, u = np.arange(2), np.zeros((2, lanes))
    law = force.law.force if compiled else force.law.force.py_func
    law(signals, parameters, motion, rows, rows, u)
    return u - part.core_stiffness_n_m * motion


def potential(part, x, y):
    angles = part.first_ball_rad + 2 * np.pi * np.arange(part.geometry.balls) / part.geometry.balls
    approach = np.maximum(x * np.cos(angles) + y * np.sin(angles) - part.clearance_m, 0)
    return 0.4 * part.contact_stiffness * np.sum(approach**2.5)


def test_one_loaded_ball_follows_the_hertz_law():
    # Towards a ball, by little more than the clearance: the neighbours at 51 degrees stay free.
    force = law_force(bearing(), [7e-6, 0.0])
    assert force[0, 0] == pytest.approx(-STIFFNESS * (2e-6) ** 1.5, rel=1e-9)
    assert force[1, 0] == pytest.approx(0.0, abs=1e-12)


def test_within_the_clearance_there_is_no_force():
    assert law_force(bearing(), [3e-6, -3e-6]) == pytest.approx(0.0, abs=1e-12)


def test_highest_ball_load_follows_stribeck():
    """Without clearance the most loaded of many balls carries 4.37 / Z of the load (Harris 2001, section 7.3)."""
    balls = 96
    part = bearing(geometry=BearingGeometry(balls, 1e-3, 60e-3), clearance_m=0.0)
    push = 1e-5
    load = -law_force(part, [push, 0.0])[0, 0]
    assert STIFFNESS * push**1.5 * balls / load == pytest.approx(4.37, rel=0.005)


def test_force_is_the_slope_of_the_hertz_energy():
    part, x, y, width = bearing(first_ball_rad=0.3), 9e-6, -7e-6, 1e-10
    slope_x = (potential(part, x + width, y) - potential(part, x - width, y)) / (2 * width)
    slope_y = (potential(part, x, y + width) - potential(part, x, y - width)) / (2 * width)
    assert law_force(part, [x, y])[:, 0] == pytest.approx([-slope_x, -slope_y], rel=1e-5)


def test_balls_turn_with_the_cage():
    """At the shaft angle at which the cage has moved by one ball the bearing looks the same; half-way it does not."""
    part = bearing()
    motion = [8e-6, 3e-6]
    turn = 2 * np.pi / BEARING_6304.defect_orders().outer_race
    assert law_force(part, motion, turn) == pytest.approx(law_force(part, motion), rel=1e-9)
    assert law_force(part, motion, turn / 2) != pytest.approx(law_force(part, motion), rel=1e-2)
    assert part.ball_pass_order == pytest.approx(2.574, abs=1e-3)


def test_answer_does_not_depend_on_the_spring_in_the_core():
    soft, stiff = bearing(core_load_n=1.0), bearing(core_load_n=1e4)
    assert law_force(soft, [9e-6, 4e-6]) == pytest.approx(law_force(stiff, [9e-6, 4e-6]), rel=1e-9)


def test_core_and_interface_add_up_in_a_system():
    """A mass in the bearing: L y + B u is the acceleration of the Hertz force alone."""
    part, mass = bearing(), 0.5
    assembly = Assembly(speed_rad_s=100.0)
    for name in "xy":
        assembly.add_coordinate(name, mass=mass)
    assembly.add_component(part)
    part.finish(assembly)
    system = build_system(assembly)
    state = np.array([9e-6, 4e-6, 0.0, 0.0])
    u = law_force(part, state[:2])[:, 0] + part.core_stiffness_n_m * state[:2]
    acceleration = (system.core @ state + system.force_columns @ u)[2:]
    assert acceleration == pytest.approx(law_force(part, state[:2])[:, 0] / mass, rel=1e-9)


@settings(max_examples=50, deadline=None)
@given(
    radius=st.floats(0.0, 5e-5),
    angle=st.floats(0.0, 2 * math.pi),
    turn=st.floats(0.0, 6.0),
    clearance=st.floats(-1e-5, 2e-5),
)
def test_bearing_pushes_back_and_turns_with_its_frame(radius, angle, turn, clearance):
    part = bearing(clearance_m=clearance)
    motion = radius * np.array([math.cos(angle), math.sin(angle)])
    force = law_force(part, motion)[:, 0]
    assert force == pytest.approx(law_force(part, motion, compiled=False)[:, 0], rel=1e-12, abs=1e-9)
    # A preloaded ring of contacts has a potential with its minimum in the middle.
    assert force @ motion <= 1e-12 + 1e-9 * np.abs(force).max() * radius
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    turned = law_force(dataclasses.replace(part, first_ball_rad=turn), rotation @ motion)[:, 0]
    assert turned == pytest.approx(rotation @ force, rel=1e-6, abs=1e-6)


def test_lanes_do_not_mix():
    part = bearing()
    motions = np.array([[9e-6, 0.0, -2e-5], [0.0, 8e-6, 1e-5]])
    together = law_force(part, motions)
    alone = np.concatenate([law_force(part, motions[:, [lane]]) for lane in range(3)], axis=1)
    assert np.array_equal(together, alone)


@pytest.mark.parametrize("stiffness", [0.0, -1.0, math.inf, math.nan])
def test_bad_stiffness_is_refused(stiffness):
    with pytest.raises(InvalidValueError, match=r"N/m\^1.5"):
        bearing(contact_stiffness=stiffness)
