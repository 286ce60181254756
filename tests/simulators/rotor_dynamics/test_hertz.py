"""Hertz contact: closed forms, Harris's published tables and example, properties."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.rotor_dynamics.hertz import (
    ball_contact_stiffness,
    contact_ellipse,
    point_contact_stiffness,
    raceway_radii_m,
)
from scipy.integrate import quad

STEEL = {"youngs_modulus_pa": 2.07e11, "poisson_ratio": 0.3}
#: Harris's example bearing 209: d 12.7 mm, D 65 mm, f 0.52 on both raceways.
BEARING_209 = {"ball_diameter_m": 12.7e-3, "pitch_diameter_m": 65e-3}


def curvature_difference(radius_ratio):
    return (radius_ratio - 1) / (radius_ratio + 1)


def test_sphere_on_a_plane_is_the_closed_form():
    # F = 4/3 E* sqrt(R) delta^1.5 with E* = E / (2 (1 - nu^2)).
    effective = 2.07e11 / (2 * (1 - 0.09))
    assert point_contact_stiffness(5e-3, 5e-3, **STEEL) == pytest.approx(4 / 3 * effective * math.sqrt(5e-3), rel=1e-12)


@pytest.mark.parametrize("radius_ratio", [1.00001, 1.01, 1.5, 7.0, 30.0, 1e3])
def test_elliptic_integrals_and_ellipticity_satisfy_hertz_by_quadrature(radius_ratio):
    shape = contact_ellipse(radius_ratio)
    parameter = 1 - 1 / shape.ellipticity**2
    first = quad(lambda t: 1 / math.sqrt(1 - parameter * math.sin(t) ** 2), 0, math.pi / 2, epsabs=1e-13)[0]
    second = quad(lambda t: math.sqrt(1 - parameter * math.sin(t) ** 2), 0, math.pi / 2, epsabs=1e-13)[0]
    assert shape.first_integral == pytest.approx(first, rel=1e-10)
    assert shape.second_integral == pytest.approx(second, rel=1e-10)
    # The quotient loses digits near a circle, where both integrals are equal.
    lost = 1e-10 / (radius_ratio - 1)
    assert (shape.ellipticity**2 * second - first) / (first - second) == pytest.approx(radius_ratio, rel=1e-9 + lost)


def test_deflection_of_the_ellipse_solves_hertz_pressure_at_the_centre():
    # Approach from the pressure: both bodies' (1-nu^2)/(pi E) integral of p/r, p = p0 sqrt(1 - x2/a2 - y2/b2).
    small, large, load = 5e-3, 60e-3, 100.0
    stiffness = point_contact_stiffness(small, large, **STEEL)
    approach = (load / stiffness) ** (2 / 3)
    shape = contact_ellipse(large / small)
    radius = small * large / (small + large)
    modulus = STEEL["youngs_modulus_pa"] / (1 - STEEL["poisson_ratio"] ** 2)
    # Hamrock and Dowson: long semi-axis (6 k^2 E F R / (pi E'))^(1/3), a sphere's (1.5 F r / E')^(1/3).
    long_axis = (6 * shape.ellipticity**2 * shape.second_integral * load * radius / (math.pi * modulus)) ** (1 / 3)
    short_axis = long_axis / shape.ellipticity
    peak = 1.5 * load / (math.pi * long_axis * short_axis)
    # Along a ray at angle t the pressure integral over radius is p0 * pi/4 * (edge of the ellipse).
    edge = quad(lambda t: 1 / math.hypot(math.cos(t) / long_axis, math.sin(t) / short_axis), 0, 2 * math.pi)[0]
    assert approach == pytest.approx(2 / (math.pi * modulus) * peak * math.pi / 4 * edge, rel=1e-8)


@pytest.mark.parametrize(
    ("difference", "long_axis", "short_axis", "deflection"),
    [
        (0.1075, 1.0760, 0.9318, 0.9974),
        (0.3204, 1.2623, 0.8114, 0.9761),
        (0.4795, 1.4556, 0.7278, 0.9429),
        (0.5916, 1.6440, 0.6687, 0.9077),
        (0.6716, 1.8258, 0.6245, 0.8733),
        (0.7332, 2.0110, 0.5881, 0.8394),
        (0.7948, 2.2650, 0.5480, 0.7961),
        (0.87366, 2.8000, 0.4863, 0.7169),
        (0.90999, 3.2330, 0.4499, 0.6636),
        (0.93657, 3.7380, 0.4166, 0.6112),
        (0.95738, 4.3950, 0.3830, 0.5551),
    ],
)
def test_harris_table_of_dimensionless_contact_parameters(difference, long_axis, short_axis, deflection):
    """T. A. Harris, Rolling Bearing Analysis: table of a*, b*, delta* against F(rho), printed with four figures."""
    shape = contact_ellipse((1 + difference) / (1 - difference))
    k, first, second = shape.ellipticity, shape.first_integral, shape.second_integral
    assert (2 * k**2 * second / math.pi) ** (1 / 3) == pytest.approx(long_axis, rel=1e-3)
    assert (2 * second / (math.pi * k)) ** (1 / 3) == pytest.approx(short_axis, rel=1e-3)
    assert 2 * first / math.pi * (math.pi / (2 * k**2 * second)) ** (1 / 3) == pytest.approx(deflection, rel=1e-3)


@pytest.mark.parametrize(("inner", "curvature_sum", "difference"), [(True, 0.202, 0.9399), (False, 0.138, 0.9120)])
def test_harris_209_bearing_curvatures(inner, curvature_sum, difference):
    """Harris, example bearing 209: curvature sum in 1/mm and curvature difference."""
    along, across = raceway_radii_m(**BEARING_209, race_conformity=0.52, inner=inner)
    # Harris's sum counts both bodies in both directions: 1/R_1 + 1/R_2.
    assert (1 / along + 1 / across) / 1e3 == pytest.approx(curvature_sum, abs=5e-4)
    assert curvature_difference(across / along) == pytest.approx(difference, abs=2e-4)


@pytest.mark.parametrize("inner", [True, False])
def test_harris_load_deflection_constant_of_steel(inner):
    """Harris: K_p = 2.15e5 (curvature sum)^(-1/2) (delta*)^(-3/2) N/mm^1.5, steel on steel."""
    along, across = raceway_radii_m(**BEARING_209, race_conformity=0.52, inner=inner)
    shape = contact_ellipse(across / along)
    star = 2 * shape.first_integral / math.pi
    star *= (math.pi / (2 * shape.ellipticity**2 * shape.second_integral)) ** (1 / 3)
    published = 2.15e5 * ((1 / along + 1 / across) / 1e3) ** -0.5 * star**-1.5 * 1e3**1.5
    # 2.15e5 has three figures.
    assert point_contact_stiffness(along, across, **STEEL) == pytest.approx(published, rel=5e-3)


def test_hamrock_brewe_approximation_of_the_inner_race():
    """Hamrock and Brewe 1983: k = 1.0339 (R_y/R_x)^0.636, first integral 1.5277 + 0.6023 ln, both within 3 %."""
    along, across = raceway_radii_m(**BEARING_209, race_conformity=0.52, inner=True)
    shape = contact_ellipse(across / along)
    assert shape.ellipticity == pytest.approx(1.0339 * (across / along) ** 0.636, rel=0.03)
    assert shape.first_integral == pytest.approx(1.5277 + 0.6023 * math.log(across / along), rel=0.03)


def test_two_contacts_in_series_add_their_approaches():
    both = ball_contact_stiffness(**BEARING_209, inner_conformity=0.52, outer_conformity=0.53, **STEEL)
    load = 500.0
    approaches = [(load / value) ** (2 / 3) for value in (both.inner, both.outer, both.combined)]
    assert approaches[2] == pytest.approx(approaches[0] + approaches[1], rel=1e-12)
    assert both.combined < min(both.inner, both.outer)


@given(st.floats(1e-4, 1.0), st.floats(1e-4, 1.0), st.floats(0.1, 10.0))
def test_scaling_and_order_of_radii(one, two, scale):
    value = point_contact_stiffness(one, two, **STEEL)
    assert point_contact_stiffness(two, one, **STEEL) == pytest.approx(value, rel=1e-12)
    scaled = point_contact_stiffness(scale * one, scale * two, **STEEL)
    assert scaled == pytest.approx(math.sqrt(scale) * value, rel=1e-9)


@given(st.floats(1.0, 1e6))
def test_ellipticity_is_at_least_one_and_grows(radius_ratio):
    shape = contact_ellipse(radius_ratio)
    assert shape.ellipticity >= 1
    assert contact_ellipse(radius_ratio * 1.1).ellipticity > shape.ellipticity


def test_tighter_grooves_are_stiffer():
    loose, tight = (
        ball_contact_stiffness(**BEARING_209, inner_conformity=f, outer_conformity=f, **STEEL) for f in (0.54, 0.51)
    )
    assert tight.inner > loose.inner
    assert tight.outer > loose.outer


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: contact_ellipse(0.5), "Ratio of the relative radii"),
        (lambda: raceway_radii_m(**BEARING_209, race_conformity=0.5, inner=True), "Race conformity"),
        (
            lambda: raceway_radii_m(ball_diameter_m=0.07, pitch_diameter_m=0.06, race_conformity=0.52, inner=True),
            "Ball diameter",
        ),
        (
            lambda: raceway_radii_m(**BEARING_209, race_conformity=0.52, contact_angle_rad=40, inner=True),
            "Contact angle",
        ),
        (lambda: point_contact_stiffness(-1e-3, 1e-3, **STEEL), "radius_one_m"),
        (lambda: point_contact_stiffness(1e-3, 1e-3, youngs_modulus_pa=2e11, poisson_ratio=0.5), "Poisson"),
    ],
)
def test_wrong_values_are_named(call, match):
    with pytest.raises(InvalidValueError, match=match):
        call()
