"""Spur gear teeth and mesh stiffness: beam closed forms, symmetry, ISO 6336, the gear pair of the source."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.rotor_dynamics import spur_gear
from rotorwise.simulators.rotor_dynamics.gear_mesh_stiffness import OVERLAP, SpurPair
from rotorwise.simulators.rotor_dynamics.shaft_parts import Material
from rotorwise.simulators.rotor_dynamics.spur_gear import SpurGear, beam_energy_density
from scipy.integrate import quad

STEEL = Material(216e9, 7850.0, 0.3)
ALPHA = math.radians(20)


def gear(teeth, *, bore_ratio=2.0, width_m=0.024, **changes):
    root = 0.002 * (teeth / 2 - changes.get("dedendum", 1.25))
    return SpurGear(teeth, 0.002, width_m, ALPHA, root / bore_ratio, STEEL, **changes)


PAIR = SpurPair(gear(23), gear(81))


def test_stubby_cantilever_of_constant_section_is_the_closed_form():
    length, half, width = 0.003, 0.0015, 0.02
    nodes, weights = np.polynomial.legendre.leggauss(4)
    x, steps = length / 2 * (nodes + 1), length / 2 * weights
    for lean in (0.0, 0.3):
        density = beam_energy_density(
            lever_m=(length - x) * math.cos(lean), lean_rad=lean, half_width_m=half, face_width_m=width, material=STEEL
        )
        area, moment = 2 * half * width, width * (2 * half) ** 3 / 12
        modulus, shear = STEEL.youngs_modulus_pa, STEEL.shear_modulus_pa
        across = length**3 / (3 * modulus * moment) + 1.2 * length / (shear * area)
        expected = across * math.cos(lean) ** 2 + length / (modulus * area) * math.sin(lean) ** 2
        assert (steps * density).sum() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("teeth", [23, 81])
def test_tooth_compliance_is_the_integral_over_its_drawn_profile(teeth):
    """Profile and load direction from the involute's polar form, integrated over height: another way to the number."""
    wheel = gear(teeth)
    base, half = wheel.base_radius_m, wheel.base_half_angle_rad
    contact_pressure_angle = 0.4

    def polar(radius):
        pressure = math.acos(base / radius)
        return half - (math.tan(pressure) - pressure)

    def width_at(height):
        if height <= base * math.cos(half):
            return base * math.sin(half)
        low, high = base, wheel.tip_radius_m
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if middle * math.cos(polar(middle)) < height else (low, middle)
        return low * math.sin(polar(low))

    radius = base / math.cos(contact_pressure_angle)
    top, side = radius * math.cos(polar(radius)), radius * math.sin(polar(radius))
    # The force is normal to the radius to the tangent point: pressure angle minus polar angle from the normal.
    lean = contact_pressure_angle - polar(radius)

    def density(height):
        lever = (top - height) * math.cos(lean) - side * math.sin(lean)
        return beam_energy_density(
            lever_m=lever, lean_rad=lean, half_width_m=width_at(height), face_width_m=0.024, material=STEEL
        )

    if wheel.root_radius_m > base:
        low = wheel.root_radius_m * math.cos(polar(wheel.root_radius_m))
    else:
        low = math.sqrt(wheel.root_radius_m**2 - (base * math.sin(half)) ** 2)
    kink = max(low, base * math.cos(half))
    expected = quad(density, low, kink, epsrel=1e-9)[0] + quad(density, kink, top, epsrel=1e-9)[0]
    assert wheel.beam_compliance_m_n(math.tan(contact_pressure_angle)) == pytest.approx(expected, rel=1e-7)


def test_compliance_is_continuous_where_the_root_circle_passes_the_base_circle():
    critical = 50 * (1 - math.cos(ALPHA)) / 2
    below, above = (gear(50, dedendum=critical + change) for change in (1e-7, -1e-7))
    assert below.root_radius_m < below.base_radius_m
    assert above.root_radius_m > above.base_radius_m
    roll = np.linspace(0.2, 0.45, 7)
    # The angle of the tooth at the base circle goes with the square root of the distance.
    assert below.tooth_compliance_m_n(roll) == pytest.approx(above.tooth_compliance_m_n(roll), rel=1e-3)


def test_contact_ratio_is_the_closed_form():
    # For equal gears twice the arc of recess: z / pi (tan(tip pressure angle) - tan(alpha)).
    pair = SpurPair(gear(30), gear(30))
    tip = math.acos(30 * math.cos(ALPHA) / 32)
    assert pair.contact_ratio == pytest.approx(30 / math.pi * (math.tan(tip) - math.tan(ALPHA)), rel=1e-12)
    assert pair.pitch_point_phase == pytest.approx(pair.contact_ratio / 2, rel=1e-12)


def test_contact_begins_at_the_tip_of_the_wheel_and_ends_at_the_tip_of_the_pinion():
    first, last = (PAIR.roll_angles_rad(phase) for phase in (0.0, PAIR.contact_ratio))
    assert first[1] == pytest.approx(PAIR.wheel.tip_roll_angle_rad, rel=1e-12)
    assert last[0] == pytest.approx(PAIR.pinion.tip_roll_angle_rad, rel=1e-12)
    assert PAIR.roll_angles_rad(PAIR.pitch_point_phase) == pytest.approx((math.tan(ALPHA),) * 2, rel=1e-12)


def test_every_part_of_the_stiffness_is_proportional_to_the_face_width():
    wide = SpurPair(gear(23, width_m=0.072), gear(81, width_m=0.072))
    phase = np.linspace(0, PAIR.contact_ratio, 9)
    assert wide.pair_stiffness_n_m(phase) == pytest.approx(3 * PAIR.pair_stiffness_n_m(phase), rel=1e-12)
    assert wide.contact_compliance_m_n == pytest.approx(PAIR.contact_compliance_m_n / 3, rel=1e-12)
    assert PAIR.contact_compliance_m_n == pytest.approx(4 * 0.91 / (math.pi * 216e9 * 0.024), rel=1e-12)


def test_equal_gears_are_symmetric_about_the_pitch_point():
    pair = SpurPair(gear(30), gear(30))
    away = np.linspace(0, pair.contact_ratio / 2, 12)
    left, right = (pair.pair_stiffness_n_m(pair.pitch_point_phase + sign * away) for sign in (-1, 1))
    assert left == pytest.approx(right, rel=1e-12)


def test_one_pair_is_a_series_and_two_pairs_are_parallel():
    phase = 0.3
    on_pinion, on_wheel = PAIR.roll_angles_rad(phase)
    parts = [
        PAIR.pinion.beam_compliance_m_n(on_pinion),
        PAIR.pinion.body_compliance_m_n(on_pinion),
        PAIR.wheel.beam_compliance_m_n(on_wheel),
        PAIR.wheel.body_compliance_m_n(on_wheel),
        PAIR.contact_compliance_m_n,
    ]
    assert 1 / PAIR.pair_stiffness_n_m(phase) == pytest.approx(sum(parts), rel=1e-12)
    both = PAIR.pair_stiffness_n_m(phase) + PAIR.pair_stiffness_n_m(phase + 1)
    assert PAIR.mesh_stiffness_n_m(phase) == pytest.approx(both, rel=1e-6)
    alone = (1 + PAIR.contact_ratio - 1) / 2
    assert PAIR.mesh_stiffness_n_m(alone) == pytest.approx(PAIR.pair_stiffness_n_m(alone), rel=1e-6)


def test_branches_follow_the_model_beyond_their_ends_and_jump_by_one_pair():
    double, single = PAIR.branches
    assert (double.pairs, single.pairs) == (2, 1)
    assert max(double.fit_error, single.fit_error) < 1e-6
    for phase in np.linspace(single.start_phase - OVERLAP, 1 + OVERLAP, 33):
        assert single.stiffness_n_m(phase) == pytest.approx(PAIR.pair_stiffness_n_m(phase), rel=1e-6)
    rise = double.stiffness_n_m(0.0) - single.stiffness_n_m(1.0)
    fall = double.stiffness_n_m(double.end_phase) - single.stiffness_n_m(single.start_phase)
    assert rise == pytest.approx(PAIR.pair_stiffness_n_m(0.0), rel=1e-5)
    assert fall == pytest.approx(PAIR.pair_stiffness_n_m(PAIR.contact_ratio), rel=1e-5)
    assert PAIR.jump_phases == (0.0, double.end_phase)


def test_mean_is_the_integral_of_one_pair_over_its_contact():
    # Over a pitch the pairs in contact together pass through the whole contact of one pair.
    expected = quad(PAIR.pair_stiffness_n_m, 0, PAIR.contact_ratio, epsrel=1e-10)[0]
    assert PAIR.mean_stiffness_n_m == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("one", "two"), [(23, 81), (30, 30), (20, 60), (40, 120)])
def test_iso_6336_stiffness_of_solid_gears(one, two):
    """ISO 6336-1 method B: q' = 0.04723 + 0.15551/z1 + 0.25791/z2 mm um/N, c' = 0.8/q', mean c' (0.75 eps + 0.25).

    Steel of 206 GPa. Bodies as stiff as the formula of the body allows, root over bore radius 1.4, are nearest to a
    solid disc. Two methods that share nothing: 10 %.
    """
    steel = Material(206e9, 7850.0, 0.3)
    pair = SpurPair(*(dataclasses.replace(gear(teeth, bore_ratio=1.4), material=steel) for teeth in (one, two)))
    single = 0.8 / (0.04723 + 0.15551 / one + 0.25791 / two) * 1e9 * 0.024
    assert pair.pair_stiffness_n_m(pair.pitch_point_phase) == pytest.approx(single, rel=0.1)
    assert pair.mean_stiffness_n_m == pytest.approx(single * (0.75 * pair.contact_ratio + 0.25), rel=0.1)


def test_gear_pair_of_the_bearing_rotor_gear_study():
    """Wang, Dai, Wang, Niu, table 2: 23/81 teeth, module 2 mm, 24 mm wide, 216 GPa; bores are not printed.

    With bore radii of 10 and 15 mm an independent computation gave contact ratio 1.71, mean 3.76e8 N/m.
    """
    pair = SpurPair(
        SpurGear(23, 0.002, 0.024, ALPHA, 0.010, STEEL),
        SpurGear(81, 0.002, 0.024, ALPHA, 0.015, STEEL),
    )
    assert pair.contact_ratio == pytest.approx(1.71, abs=0.005)
    assert pair.mean_stiffness_n_m == pytest.approx(3.76e8, rel=2e-3)
    double, single = (
        branch.stiffness_n_m(np.linspace(branch.start_phase, branch.end_phase, 99)) for branch in pair.branches
    )
    assert single.min() > 2.36e8
    assert single.max() < 2.47e8
    assert double.min() > 4.08e8
    assert double.max() < 4.38e8


def test_body_factors_reach_the_published_extremes():
    """Sainsot 2004, table 1, prints the ranges of the factors: L* to 6.94, P* to 13.47, Q* from 0.141."""
    angle, ratio = np.meshgrid(np.linspace(0.015, 0.12, 106), np.linspace(*spur_gear.BODY_RATIO, 57))
    terms = np.array([1 / angle**2, ratio**2, ratio / angle, 1 / angle, ratio, np.ones_like(angle)])
    factors = np.einsum("ij,jkl->ikl", spur_gear._BODY, terms)
    assert factors[0].max() == pytest.approx(6.94, rel=2e-3)
    assert factors[2].max() == pytest.approx(13.47, rel=5e-3)
    assert factors[3].min() == pytest.approx(0.141, rel=1e-2)


@settings(max_examples=20, deadline=None)
@given(st.integers(20, 60), st.integers(20, 150), st.floats(1.5, 6.5), st.floats(0.0, 3.0))
def test_any_pair_is_periodic_positive_and_well_fitted(one, two, bore_ratio, phase):
    pair = SpurPair(gear(one, bore_ratio=bore_ratio), gear(two, bore_ratio=bore_ratio))
    assert max(branch.fit_error for branch in pair.branches) < 1e-6
    # Rounding may carry a phase across a jump; there the fraction decides.
    fraction = phase % 1.0
    assert pair.mesh_stiffness_n_m(phase) == pytest.approx(pair.mesh_stiffness_n_m(fraction), rel=1e-12)
    weakest = pair.pair_stiffness_n_m(np.linspace(0, pair.contact_ratio, 50)).min()
    assert pair.mesh_stiffness_n_m(phase) > 0.999 * weakest
    assert pair.mean_stiffness_n_m > pair.contact_ratio * 0.999 * weakest


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: gear(3), "3 teeth"),
        (lambda: gear(23, bore_ratio=8.0), "Bore radius"),
        (lambda: gear(23, width_m=0.0), "face_width_m"),
        (lambda: dataclasses.replace(gear(23), pressure_angle_rad=20.0), "Pressure angle"),
        (lambda: gear(23, addendum=2.5), "end in a point"),
        (lambda: SpurPair(gear(23), dataclasses.replace(gear(81), module_m=0.0021)), "module_m"),
        (lambda: SpurPair(gear(10), gear(81)), "inside a base circle"),
        (lambda: SpurPair(gear(60, addendum=1.4), gear(80, addendum=1.4)), "Contact ratio"),
    ],
)
def test_wrong_values_are_named(call, match):
    with pytest.raises(InvalidValueError, match=match):
        call()
