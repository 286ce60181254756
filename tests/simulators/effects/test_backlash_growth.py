"""Backlash growth: involute geometry at a larger centre distance, and rattle only where teeth separate."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects.backlash_growth import BacklashGrowth
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machines.gearbox import tooth_pair
from rotorwise.simulators.rotor_dynamics.gear_mesh_stiffness import SpurPair

from .test_tooth_crack import mesh_of

PAIR = tooth_pair()


def apart(growth_m):
    return SpurPair(PAIR.pinion, PAIR.wheel, growth_m)


def test_small_growth_makes_twice_its_sine_of_backlash():
    """d j / d a = 2 sin(alpha) along the line of action."""
    assert apart(1e-6).backlash_growth_m == pytest.approx(2e-6 * math.sin(math.radians(20)), rel=1e-3)
    assert apart(0.0).backlash_growth_m == 0.0


def test_backlash_from_the_thickness_of_the_teeth_on_the_working_circles(figure):
    """Independent: space less tooth on the working pitch circles, measured as arcs, times cos alpha'."""
    pair = apart(3e-4)
    angle = pair.working_angle_rad
    involute = math.tan(angle) - angle
    arcs = []
    for gear in (pair.pinion, pair.wheel):
        radius = gear.base_radius_m / math.cos(angle)
        arcs.append(2 * radius * (gear.base_half_angle_rad - involute))
    pitch = 2 * math.pi * pair.pinion.base_radius_m / math.cos(angle) / pair.pinion.teeth
    assert pair.backlash_growth_m == pytest.approx((pitch - sum(arcs)) * math.cos(angle), rel=1e-9)
    expected = (pitch - sum(arcs)) * math.cos(angle)
    figure("Backlash against space less tooth on the working circles", pair.backlash_growth_m, expected)


def test_contact_ratio_falls_as_the_textbook_formula_says():
    """[sqrt(ra1^2 - rb1^2) + sqrt(ra2^2 - rb2^2) - a' sin alpha'] / p_b."""
    for growth in (0.0, 2e-4, 5e-4):
        pair = apart(growth)
        one, two = pair.pinion, pair.wheel
        distance = one.pitch_radius_m + two.pitch_radius_m + growth
        bases = one.base_radius_m + two.base_radius_m
        path = sum(math.sqrt(g.tip_radius_m**2 - g.base_radius_m**2) for g in (one, two)) - math.sqrt(
            distance**2 - bases**2
        )
        assert pair.contact_ratio == pytest.approx(path / pair.base_pitch_m, rel=1e-9)
    assert apart(5e-4).contact_ratio < apart(0.0).contact_ratio


def test_the_pitch_point_divides_the_centre_line_by_the_teeth():
    pair = apart(4e-4)
    one, two = pair.roll_angles_rad(np.array(pair.pitch_point_phase))
    # Both roll angles are tan alpha' there.
    assert (one, two) == pytest.approx((math.tan(pair.working_angle_rad),) * 2, rel=1e-9)


def test_the_effect_moves_the_mesh_and_growths_add():
    mesh, once = (
        mesh_of(BacklashGrowth(growth_m=1e-4), BacklashGrowth(growth_m=2e-4)),
        mesh_of(BacklashGrowth(growth_m=3e-4)),
    )
    assert mesh.backlash_m == pytest.approx(once.backlash_m, rel=1e-9)
    assert mesh.backlash_m - mesh_of().backlash_m == pytest.approx(apart(3e-4).backlash_growth_m, rel=1e-6)
    assert mesh.branches[0].end_phase == pytest.approx(apart(3e-4).contact_ratio - 1)
    assert mesh.mean_stiffness_n_m < mesh_of().mean_stiffness_n_m


def test_gears_too_far_apart_are_refused():
    with pytest.raises(InvalidValueError, match="Contact ratio"):
        apart(2.2e-3)
