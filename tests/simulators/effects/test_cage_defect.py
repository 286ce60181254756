"""Cage defect: lines at multiples of the cage order, in proportion to the shift; none in a sound bearing."""

import numpy as np
import pytest
from rotorwise.simulators.effects.cage_defect import CageDefect
from rotorwise.simulators.machine import find_machine

from .held_bearings import force_over_turns, lines, part_of


def force(size_m, phase, push_m=5e-6):
    part = part_of("test_rig", CageDefect(size_m=size_m, slip=1e-15, slip_wander=0.0))
    return force_over_turns(part, phase, push_m=push_m)


def cage_turns(count, per_turn):
    cage = part_of("test_rig", CageDefect()).geometry.defect_orders().cage
    return 2 * np.pi * np.arange(count * per_turn) / per_turn / cage


def test_lines_are_whole_multiples_of_the_cage():
    phase = cage_turns(4, 2048)
    found = force(1e-3, phase)
    # Orders over the cage's: whole numbers, the first among them.
    for axis in found:
        orders = lines(axis, 4)
        assert orders == pytest.approx(np.round(orders))
        assert 1.0 in orders


def test_even_balls_make_no_line():
    phase = cage_turns(2, 512)
    assert np.ptp(force(0.0, phase), axis=1) == pytest.approx(0, abs=1e-9 * np.abs(force(0.0, phase)).max())


def test_small_shifts_act_in_proportion_and_as_a_turned_ball(figure):
    """K [a(theta) n(theta) - a(theta - e) n(theta - e)] with e = 2 s / D, for a ball far inside the load zone."""
    phase = cage_turns(1, 512)
    sound = force(0.0, phase)
    one, two = (force(size, phase) - sound for size in (1e-6, 2e-6))
    assert np.abs(two - 2 * one).max() < 0.01 * np.abs(two).max()
    part = part_of("test_rig", CageDefect())
    push, angle = 5e-6, part.load_angle_rad
    stiffness = 4 * part.stiffness_x_n_m / part.geometry.balls
    # The first ball stands in the load at three quarters of a cage turn.
    at = 3 * 512 // 4
    shift = 2e-6 / (part.geometry.pitch_diameter_m / 2)

    def ball(theta):
        return -stiffness * push * np.cos(theta - angle) * np.array([np.cos(theta), np.sin(theta)])

    expected = ball(angle - shift) - ball(angle)
    # The rounding of the contact adds eps^2 / (4 a^2).
    assert two[:, at] == pytest.approx(expected, rel=2e-3, abs=1e-3 * np.abs(expected).max())
    figure("Force of a ball out of its place against closed form", two[:, at], expected)


def test_signature_is_below_half_the_shaft_speed_first():
    orders = [line.order for line in CageDefect(slip=0.0).signature(find_machine("test_rig"))]
    assert orders[0] == pytest.approx(0.375, abs=1e-3)
    assert orders[7] == pytest.approx(2.998, abs=1e-3)
