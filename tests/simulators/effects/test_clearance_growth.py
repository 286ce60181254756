"""Clearance growth: a static shift by the growth, a narrower load zone, a stronger pulse of the stiffness."""

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.clearance_growth import ClearanceGrowth
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine

from .held_bearings import force_over_turns, part_of

LOAD_N = 200.0


def push_under_load(part, phase):
    """Return by how much the inner ring yields under the load at each angle of the shaft, by bisection."""
    result = []
    for angle in phase:
        low, high = 0.0, 1e-3
        for _ in range(60):
            middle = (low + high) / 2
            along = -force_over_turns(part, [angle], push_m=middle)[1, 0] * np.sin(part.load_angle_rad)
            low, high = (middle, high) if along < LOAD_N else (low, middle)
        result.append(low)
    return np.array(result)


def test_the_shaft_yields_by_the_growth_and_pulses_more():
    # One ball spacing of the cage.
    phase = np.linspace(0, 2 * np.pi / 2.575, 40)
    tight, loose = (part_of("gearbox", ClearanceGrowth(growth_m=g), "bearing 1") for g in (0.0, 3e-5))
    one, two = push_under_load(tight, phase), push_under_load(loose, phase)
    assert two.mean() - one.mean() == pytest.approx(3e-5, rel=0.3)
    assert np.ptp(two) > 2 * np.ptp(one)


def test_with_large_clearance_one_or_two_balls_carry_and_statics_is_closed(figure):
    """Load half-way between two balls: the shaft yields by (c + (W / (2 K cos b))^(2/3)) / cos b, b = pi / Z."""
    part = part_of("gearbox", ClearanceGrowth(growth_m=1e-4), "bearing 1")
    half = np.pi / part.geometry.balls
    # The cage angle at which the load points to the middle between balls 0 and 1 or any other two.
    cage = (part.load_angle_rad - half - part.first_ball_rad) % (2 * half)
    phase = cage / part.geometry.defect_orders().cage
    approach = (LOAD_N / (2 * part.contact_stiffness * np.cos(half))) ** (2 / 3)
    expected = (part.clearance_m + approach) / np.cos(half)
    assert push_under_load(part, [phase])[0] == pytest.approx(expected, rel=1e-6)
    figure("Shift of the shaft under load against Hertz", push_under_load(part, [phase])[0], expected)


def test_growths_add_and_senseless_ones_are_refused():
    box = find_machine("gearbox").bare_assembly()
    for growth in (1e-5, 2e-5):
        ClearanceGrowth(growth_m=growth).contribute(box)
    part = box.component("bearing", "bearing 1")
    assert part.clearance_m == pytest.approx(3.5e-5)
    with pytest.raises(InvalidValueError, match="allowed"):
        part.grow_clearance(1.0)


def test_a_bearing_of_springs_has_no_clearance():
    with pytest.raises(MissingPartError):
        ClearanceGrowth().contribute(find_machine("test_rig").bare_assembly())
    ClearanceGrowth().contribute(find_machine("test_rig").preset("hertz").bare_assembly())
