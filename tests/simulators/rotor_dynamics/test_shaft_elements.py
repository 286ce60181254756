"""Shaft finite elements against closed forms: beams, rigid bodies, gyroscopic whirl; then properties."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.rotor_dynamics.shaft_elements import assemble_rotor, plane_matrices
from rotorwise.simulators.rotor_dynamics.shaft_parts import Disc, Material, ShaftElement
from scipy.linalg import eigh
from scipy.optimize import brentq

STEEL = Material(2.1e11, 7850.0, 0.3)
WEIGHTLESS = Material(2.1e11, 1e-7, 0.3)


def pinned_frequencies(length_m, diameter_m, elements):
    """Natural frequencies in rad/s of the plane x-z with both ends pinned."""
    rotor = assemble_rotor([ShaftElement(length_m / elements, diameter_m)] * elements, material=STEEL)
    rows = [
        rotor.index(node, coordinate)
        for node in range(elements + 1)
        for coordinate in ("x", "angle_y")
        if not (coordinate == "x" and node in (0, elements))
    ]
    return np.sqrt(eigh(rotor.stiffness[np.ix_(rows, rows)], rotor.mass[np.ix_(rows, rows)], eigvals_only=True))


def timoshenko_pinned(length_m, diameter_m, order):
    """Lower root of the pinned Timoshenko beam, w = sin(n pi z / L): closed form, both terms of rotary inertia."""
    shaft = ShaftElement(length_m, diameter_m)
    wave = order * math.pi / length_m
    shear = shaft.shear_coefficient(STEEL.poisson_ratio) * STEEL.shear_modulus_pa * shaft.area_m2
    mass, inertia = STEEL.density_kg_m3 * shaft.area_m2, STEEL.density_kg_m3 * shaft.second_moment_m4
    bending = STEEL.youngs_modulus_pa * shaft.second_moment_m4
    # (S k^2 - m w2)(B k^2 + S - J w2) = (S k)^2, quadratic in w2.
    first, last = mass * inertia, shear * bending * wave**4
    middle = mass * (bending * wave**2 + shear) + inertia * shear * wave**2
    # The smaller root in the form that does not cancel.
    return math.sqrt(2 * last / (middle + math.sqrt(middle**2 - 4 * first * last)))


def bending_error(length_m, elements, order):
    """Relative error of the cubic beam element, (n pi h / L)^4 / 1440."""
    return (order * math.pi / elements) ** 4 / 1440


def shear_error(diameter_m, frequency_rad_s, element_length_m, order):
    """Relative error w^2 h^2 / 24 (rho/(kappa G) + share rho/E) / (1 + share), share = rotary / translational energy.

    The inertia loads m w^2 and rho I w^2 within an element between fixed ends deform it in shear and bending; the
    element knows end loads only and lacks that energy.
    """
    shaft = ShaftElement(1.0, diameter_m)
    wave = order * math.pi
    square = STEEL.density_kg_m3 * frequency_rad_s**2 / (shaft.shear_coefficient(0.3) * STEEL.shear_modulus_pa)
    share = (diameter_m / 4 * wave * (1 - square / wave**2)) ** 2
    bending = STEEL.density_kg_m3 * frequency_rad_s**2 / STEEL.youngs_modulus_pa
    return (square + share * bending) * element_length_m**2 / 24 / (1 + share)


def test_slender_pinned_shaft_is_euler_bernoulli():
    length, diameter = 1.0, 0.004
    shaft = ShaftElement(length, diameter)
    rigidity = STEEL.youngs_modulus_pa * shaft.second_moment_m4 / (STEEL.density_kg_m3 * shaft.area_m2)
    found = pinned_frequencies(length, diameter, 80)
    softness = 1 + STEEL.youngs_modulus_pa / (shaft.shear_coefficient(0.3) * STEEL.shear_modulus_pa)
    for order in (1, 2, 3):
        slender = (order * math.pi / length) ** 2 * math.sqrt(rigidity)
        # First order in the slenderness n pi r / L, radius of gyration r = d/4: at most 1.8e-4 here.
        lower = (order * math.pi * diameter / 4 / length) ** 2 * softness / 2
        assert found[order - 1] == pytest.approx(slender, rel=2e-4)
        assert found[order - 1] / slender - 1 == pytest.approx(-lower, rel=0.03)


@pytest.mark.parametrize("diameter_m", [0.02, 0.1, 0.25])
def test_thick_pinned_shaft_is_timoshenko(diameter_m):
    found = pinned_frequencies(1.0, diameter_m, 40)
    for order in (1, 2, 3):
        exact = timoshenko_pinned(1.0, diameter_m, order)
        predicted = bending_error(1.0, 40, order) + shear_error(diameter_m, exact, 1 / 40, order)
        assert predicted < 2e-3
        assert found[order - 1] / exact - 1 == pytest.approx(predicted, rel=0.1)


def test_thick_shaft_is_far_from_euler_bernoulli():
    """Otherwise the test above could not tell the two apart."""
    shaft = ShaftElement(1.0, 0.25)
    slender = 4 * math.pi**2 * math.sqrt(2.1e11 * shaft.second_moment_m4 / (7850 * shaft.area_m2))
    assert timoshenko_pinned(1.0, 0.25, 2) < 0.85 * slender


def test_slender_frequencies_converge_with_the_fourth_power_of_the_element_length():
    exact = timoshenko_pinned(1.0, 0.004, 2)
    errors = np.array([pinned_frequencies(1.0, 0.004, elements)[1] / exact - 1 for elements in (4, 8, 16)])
    assert (errors > 0).all(), "consistent matrices approach from above"
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx([4.0, 4.0], abs=0.1)
    assert errors[-1] == pytest.approx(bending_error(1.0, 16, 2), rel=0.05)


def test_thick_frequencies_converge_with_the_second_power_of_the_element_length():
    exact = timoshenko_pinned(1.0, 0.25, 2)
    errors = np.array([pinned_frequencies(1.0, 0.25, elements)[1] / exact - 1 for elements in (20, 40, 80)])
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx([2.0, 2.0], abs=0.1)
    assert errors[-1] == pytest.approx(shear_error(0.25, exact, 1 / 80, 2), rel=0.02)


def test_element_matrices_equal_the_integrals_of_their_shape_functions():
    shaft = ShaftElement(0.3, 0.2, 0.05)
    translation, rotary, bending = plane_matrices(shaft, STEEL)
    length, modulus, moment = 0.3, STEEL.youngs_modulus_pa, shaft.second_moment_m4
    shear = shaft.shear_coefficient(0.3) * STEEL.shear_modulus_pa * shaft.area_m2
    ratio = modulus * moment / shear
    # Static solution: w = c0 + c1 z + c2 z2 + c3 z3, section angle = w' + (EI/S) w'''.
    ends = [
        [1, z, z**2, z**3] if row == 0 else [0, 1, 2 * z, 3 * z**2 + 6 * ratio] for z in (0, length) for row in (0, 1)
    ]
    constants = np.linalg.inv(np.array(ends, dtype=float))
    nodes, weights = np.polynomial.legendre.leggauss(6)
    integrals = np.zeros((3, 4, 4))
    for node, weight in zip(length / 2 * (nodes + 1), length / 2 * weights, strict=True):
        deflection = np.array([1, node, node**2, node**3]) @ constants
        angle = np.array([0, 1, 2 * node, 3 * node**2 + 6 * ratio]) @ constants
        curvature = np.array([0, 0, 2, 6 * node]) @ constants
        sliding = np.array([0, 0, 0, -6 * ratio]) @ constants
        integrals[0] += weight * STEEL.density_kg_m3 * shaft.area_m2 * np.outer(deflection, deflection)
        integrals[1] += weight * STEEL.density_kg_m3 * moment * np.outer(angle, angle)
        integrals[2] += weight * (
            modulus * moment * np.outer(curvature, curvature) + shear * np.outer(sliding, sliding)
        )
    for matrix, integral in zip((translation, rotary, bending), integrals, strict=True):
        assert matrix == pytest.approx(integral, rel=1e-9, abs=1e-12 * np.abs(integral).max())


def rigid_motions(rotor):
    """Translation along x and y, rotation about x and y through the first node, as columns."""
    nodes = len(rotor.positions_m)
    motions = np.zeros((4 * nodes, 4))
    motions[0::4, 0] = 1
    motions[1::4, 1] = 1
    motions[1::4, 2], motions[2::4, 2] = -rotor.positions_m, 1
    motions[0::4, 3], motions[3::4, 3] = rotor.positions_m, 1
    return motions


STEPPED = [ShaftElement(0.2, 0.03), ShaftElement(0.15, 0.06, 0.02), ShaftElement(0.1, 0.04), ShaftElement(0.25, 0.03)]
DISCS = [
    Disc.from_geometry(2, width_m=0.03, outer_diameter_m=0.2, inner_diameter_m=0.04, density_kg_m3=7850),
    Disc(4, 1.5, 2e-3, 3e-3),
]


def test_rigid_motions_have_no_energy_and_the_right_mass_and_inertia():
    rotor = assemble_rotor(STEPPED, material=STEEL, discs=DISCS)
    motions = rigid_motions(rotor)
    # Internal forces cancel to round-off of the largest stiffness.
    assert np.abs(rotor.stiffness @ motions).max() < 1e-12 * np.abs(rotor.stiffness).max()
    assert np.linalg.matrix_rank(rotor.stiffness, tol=1e-9 * np.abs(rotor.stiffness).max()) == len(rotor.stiffness) - 4
    starts = rotor.positions_m[:-1]
    shaft_mass = [STEEL.density_kg_m3 * part.area_m2 * part.length_m for part in STEPPED]
    first = sum(m * (z + part.length_m / 2) for m, z, part in zip(shaft_mass, starts, STEPPED, strict=True))
    second = sum(
        m * ((z + p.length_m / 2) ** 2 + p.length_m**2 / 12 + (p.outer_diameter_m**2 + p.inner_diameter_m**2) / 16)
        for m, z, p in zip(shaft_mass, starts, STEPPED, strict=True)
    )
    for disc in DISCS:
        z = rotor.positions_m[disc.node]
        first += disc.mass_kg * z
        second += disc.mass_kg * z**2 + disc.diametral_inertia_kg_m2
    total = sum(shaft_mass) + sum(disc.mass_kg for disc in DISCS)
    expected = np.array([[total, 0, 0, first], [0, total, -first, 0], [0, -first, second, 0], [first, 0, 0, second]])
    assert motions.T @ rotor.mass @ motions == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_gyroscopic_moment_of_a_turning_rigid_rotor_is_its_polar_inertia():
    rotor = assemble_rotor(STEPPED, material=STEEL, discs=DISCS)
    motions = rigid_motions(rotor)
    polar = sum(2 * STEEL.density_kg_m3 * part.second_moment_m4 * part.length_m for part in STEPPED)
    polar += sum(disc.polar_inertia_kg_m2 for disc in DISCS)
    expected = np.zeros((4, 4))
    # Angular momentum I_p (angle_y, -angle_x) of the tilted spin: moments +I_p angle_y' about x, -I_p angle_x' about y.
    expected[2, 3], expected[3, 2] = polar, -polar
    assert motions.T @ rotor.gyroscopic @ motions == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("load", ["force", "moment"])
def test_cantilever_deflection_is_exact_with_one_element(load):
    length = 0.3
    shaft = ShaftElement(length, 0.1)
    rotor = assemble_rotor([shaft], material=STEEL)
    rigidity = STEEL.youngs_modulus_pa * shaft.second_moment_m4
    shear = shaft.shear_coefficient(0.3) * STEEL.shear_modulus_pa * shaft.area_m2
    push = np.array([1.0, 0, 0, 0]) if load == "force" else np.array([0, 0, 0, 1.0])
    found = np.linalg.solve(rotor.stiffness[4:, 4:], push)
    if load == "force":
        expected = [length**3 / (3 * rigidity) + length / shear, 0, 0, length**2 / (2 * rigidity)]
    else:
        expected = [length**2 / (2 * rigidity), 0, 0, length / rigidity]
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-20)


def stodola_green_frequencies(length_m, diameter_m, disc, speed_rad_s):
    """Signed whirl frequencies of a rigid disc on an overhung massless shaft.

    (k11 - m w^2)(k22 - I_d w^2 + I_p W w) = k12^2 with z = x + iy ~ exp(i w t); positive w whirls forward.
    """
    shaft = ShaftElement(length_m, diameter_m)
    rigidity = STEEL.youngs_modulus_pa * shaft.second_moment_m4
    shear = shaft.shear_coefficient(0.3) * STEEL.shear_modulus_pa * shaft.area_m2
    flexibility = np.array(
        [[length_m**3 / (3 * rigidity) + length_m / shear, length_m**2 / (2 * rigidity)], [0.0, length_m / rigidity]]
    )
    flexibility[1, 0] = flexibility[0, 1]
    stiffness = np.linalg.inv(flexibility)
    first = np.polynomial.Polynomial([stiffness[0, 0], 0, -disc.mass_kg])
    second = np.polynomial.Polynomial(
        [stiffness[1, 1], disc.polar_inertia_kg_m2 * speed_rad_s, -disc.diametral_inertia_kg_m2]
    )
    return np.sort((first * second - stiffness[0, 1] ** 2).roots())


@pytest.mark.parametrize("speed_rad_s", [0.0, 300.0, 3000.0])
def test_overhung_disc_whirls_as_stodola_and_green_say(speed_rad_s):
    disc = Disc(5, 8.0, 0.04, 0.078)
    rotor = assemble_rotor([ShaftElement(0.05, 0.025)] * 5, material=WEIGHTLESS, discs=[disc])
    free = slice(4, None)
    # Motions that the weightless shaft makes of its own lie at infinity: condense it out by statics.
    stiffness = np.linalg.inv(np.linalg.inv(rotor.stiffness[free, free])[-4:, -4:])
    mass, gyroscopic = rotor.mass[-4:, -4:], rotor.gyroscopic[-4:, -4:]
    state = np.block(
        [
            [np.zeros((4, 4)), np.eye(4)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, speed_rad_s * gyroscopic)],
        ]
    )
    values, vectors = np.linalg.eig(state)
    expected = stodola_green_frequencies(0.25, 0.025, disc, speed_rad_s)
    assert np.sort(values.imag[values.imag > 0]) == pytest.approx(np.sort(np.abs(expected)), rel=1e-6)
    assert np.abs(values.real).max() < 1e-6 * np.abs(values).max()
    if speed_rad_s:
        # At positive frequency y lags x by a quarter when the whirl goes from x to y: forward.
        for value, vector in zip(values, vectors.T, strict=True):
            if value.imag > 0:
                forward = (vector[1] / vector[0]).imag < 0
                nearest = expected[np.argmin(np.abs(np.abs(expected) - value.imag))]
                assert forward == (nearest > 0)


def test_gyroscopic_stiffening_of_a_thin_disc_removes_the_second_forward_critical_speed():
    # Forward whirl at W = w: I_p > I_d leaves one critical speed only, the classic result for a thin disc.
    disc = Disc(1, 8.0, 0.04, 0.078)

    def gap(speed):
        return stodola_green_frequencies(0.25, 0.025, disc, speed)[3] - speed

    assert all(gap(speed) > 0 for speed in np.linspace(1, 5e4, 200))
    first = brentq(lambda speed: stodola_green_frequencies(0.25, 0.025, disc, speed)[2] - speed, 1, 5e4)
    assert first > 0


def test_matrices_are_symmetric_skew_and_read_only():
    rotor = assemble_rotor(STEPPED, material=STEEL, discs=DISCS)
    assert np.array_equal(rotor.gyroscopic, -rotor.gyroscopic.T)
    for matrix in (rotor.mass, rotor.stiffness):
        assert matrix == pytest.approx(matrix.T, rel=1e-13)
        with pytest.raises(ValueError, match="read-only"):
            matrix[0, 0] = 0.0
    assert np.linalg.eigvalsh(rotor.mass).min() > 0


def test_cowper_shear_coefficient_limits():
    """Cowper 1966: solid circle 6 (1+nu) / (7+6nu); thin tube 2 (1+nu) / (4+3nu)."""
    assert ShaftElement(1, 0.1).shear_coefficient(0.3) == pytest.approx(6 * 1.3 / 8.8)
    assert ShaftElement(1, 0.1, 0.1 * (1 - 1e-7)).shear_coefficient(0.3) == pytest.approx(2 * 1.3 / 4.9, rel=1e-6)


@settings(max_examples=25)
@given(st.floats(0.01, 2.0), st.floats(0.005, 0.5), st.floats(0.0, 0.95), st.floats(0.0, 0.49))
def test_any_element_is_positive_and_splits_exactly(length, diameter, hollow, poisson):
    material = Material(2e11, 8000.0, poisson)
    whole = assemble_rotor([ShaftElement(length, diameter, hollow * diameter)], material=material)
    halves = assemble_rotor([ShaftElement(length / 2, diameter, hollow * diameter)] * 2, material=material)
    condensed = np.linalg.inv(np.linalg.inv(halves.stiffness[4:, 4:])[-4:, -4:])
    scale = np.abs(condensed).max()
    assert whole.stiffness[4:, 4:] == pytest.approx(condensed, rel=1e-6, abs=1e-8 * scale)
    assert np.linalg.eigvalsh(whole.mass).min() > 0
    assert np.array_equal(whole.gyroscopic, -whole.gyroscopic.T)


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: Material(-1, 7850, 0.3), "Young"),
        (lambda: Material(2e11, 7850, 0.5), "Poisson"),
        (lambda: ShaftElement(0.1, 0.02, 0.02), "Inner diameter"),
        (lambda: ShaftElement(math.nan, 0.02), "Length"),
        (lambda: Disc(0, 1, 1e-3, 3e-3), "twice"),
        (lambda: Disc(0, -1, 1e-3, 1e-3), "at least 0"),
        (lambda: assemble_rotor([], material=STEEL), "0 elements"),
        (lambda: assemble_rotor([ShaftElement(1, 0.1)], material=STEEL, discs=[Disc(2, 1, 1, 1)]), "Node 2"),
        (lambda: assemble_rotor([ShaftElement(1, 0.1)], material=STEEL).index(-1, "x"), "Node -1"),
        (lambda: assemble_rotor([ShaftElement(1, 0.1)], material=STEEL).index(0, "z"), "Coordinate"),
    ],
)
def test_wrong_values_are_named(call, match):
    with pytest.raises(InvalidValueError, match=match):
        call()
