"""Torsion against closed forms; damping matrices against the ratios they are made from."""

import math

import numpy as np
import pytest
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.rotor_dynamics.shaft_damping import (
    circulatory_matrix,
    modal_damping,
    stiffness_proportional_damping,
)
from rotorwise.simulators.rotor_dynamics.shaft_elements import assemble_rotor
from rotorwise.simulators.rotor_dynamics.shaft_parts import Disc, Material, ShaftElement
from rotorwise.simulators.rotor_dynamics.shaft_torsion import assemble_torsion
from scipy.linalg import eigh

STEEL = Material(2.1e11, 7850.0, 0.3)


def test_two_discs_on_a_light_shaft():
    light = Material(2.1e11, 1e-6, 0.3)
    discs = [Disc(0, 1, 0.02, 0.03), Disc(3, 1, 0.02, 0.01)]
    torsion = assemble_torsion([ShaftElement(0.1, 0.02)] * 3, material=light, discs=discs)
    stiffness = light.shear_modulus_pa * math.pi * 0.02**4 / 32 / 0.3
    squares = eigh(torsion.stiffness, torsion.inertia, eigvals_only=True)
    assert squares[1] == pytest.approx(stiffness * (1 / 0.03 + 1 / 0.01), rel=1e-6)
    assert abs(squares[0]) < 1e-9 * squares[1]


def free_shaft_frequency(elements, order):
    torsion = assemble_torsion([ShaftElement(0.8 / elements, 0.03, 0.01)] * elements, material=STEEL)
    return math.sqrt(eigh(torsion.stiffness, torsion.inertia, eigvals_only=True)[order])


def test_free_shaft_and_its_order_of_convergence():
    exact = 2 * math.pi / 0.8 * math.sqrt(STEEL.shear_modulus_pa / STEEL.density_kg_m3)
    errors = np.array([free_shaft_frequency(elements, 2) / exact - 1 for elements in (8, 16, 32)])
    assert (errors > 0).all()
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx([2, 2], abs=0.1)
    # A linear element of length h is (n pi h / L)^2 / 24 too fast.
    assert errors[-1] == pytest.approx((2 * math.pi / 32) ** 2 / 24, rel=0.01)


def test_turning_as_a_whole_has_no_energy_and_all_the_inertia():
    elements = [ShaftElement(0.2, 0.03), ShaftElement(0.3, 0.05, 0.02)]
    torsion = assemble_torsion(elements, material=STEEL, discs=[Disc(1, 2, 0.01, 0.015)])
    assert np.abs(torsion.stiffness.sum(axis=1)).max() < 1e-12 * torsion.stiffness.max()
    shaft = sum(STEEL.density_kg_m3 * 2 * part.second_moment_m4 * part.length_m for part in elements)
    assert torsion.inertia.sum() == pytest.approx(shaft + 0.015, rel=1e-12)
    assert torsion.positions_m == pytest.approx([0, 0.2, 0.5])
    with pytest.raises(ValueError, match="read-only"):
        torsion.inertia[0, 0] = 0


def supported_rotor():
    rotor = assemble_rotor([ShaftElement(0.1, 0.03)] * 6, material=STEEL, discs=[Disc(3, 5, 0.02, 0.03)])
    stiffness = rotor.stiffness.copy()
    for node in (0, 6):
        for coordinate in ("x", "y"):
            row = rotor.index(node, coordinate)
            stiffness[row, row] += 1e7
    return rotor, stiffness


def damping_ratios(mass, damping, stiffness):
    size = len(mass)
    state = np.block(
        [
            [np.zeros((size, size)), np.eye(size)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
        ]
    )
    values = np.linalg.eigvals(state)
    values = values[values.imag > 0]
    values = values[np.argsort(np.abs(values))]
    return -values.real / np.abs(values), np.abs(values)


def test_modes_have_the_damping_ratios_asked_for():
    rotor, stiffness = supported_rotor()
    damping = modal_damping(rotor.mass, stiffness, ratios=[0.01, 0.03, 0.002])
    ratios, _ = damping_ratios(rotor.mass, damping, stiffness)
    assert ratios[:8] == pytest.approx([0.01, 0.01, 0.03, 0.03, 0.002, 0.002, 0.002, 0.002], rel=1e-6)
    assert np.array_equal(damping, damping.T)


def test_damping_of_an_isotropic_rotor_does_not_prefer_a_direction():
    rotor, stiffness = supported_rotor()
    damping = modal_damping(rotor.mass, stiffness, ratios=[0.01, 0.03])
    quarter = np.kron(np.eye(len(damping) // 2), np.array([[0.0, 1.0], [-1.0, 0.0]]))
    assert quarter.T @ damping @ quarter == pytest.approx(damping, abs=1e-7 * np.abs(damping).max())


def test_rigid_motions_of_a_free_rotor_stay_undamped():
    rotor = assemble_rotor([ShaftElement(0.1, 0.03)] * 6, material=STEEL)
    damping = modal_damping(rotor.mass, rotor.stiffness, ratios=0.02)
    motion = np.zeros(len(damping))
    motion[0::4] = 1 + 2 * rotor.positions_m
    motion[3::4] = 2
    assert np.abs(damping @ motion).max() < 1e-7 * np.abs(damping).max()
    squares, shapes = eigh(rotor.stiffness, rotor.mass)
    elastic = np.diag(shapes.T @ damping @ shapes)[4:]
    assert elastic == pytest.approx(2 * 0.02 * np.sqrt(squares[4:]), rel=1e-9)


def test_stiffness_proportional_ratio_grows_with_frequency():
    rotor, stiffness = supported_rotor()
    damping = stiffness_proportional_damping(stiffness, ratio=0.001, at_frequency_rad_s=500.0)
    ratios, frequencies = damping_ratios(rotor.mass, damping, stiffness)
    assert ratios[:6] == pytest.approx(0.001 * frequencies[:6] / 500.0, rel=1e-6)


@pytest.mark.parametrize(("factor", "stable"), [(0.99, True), (1.01, False)])
def test_rotating_damping_is_unstable_above_its_threshold(factor, stable):
    """Genta 2005: unstable above the critical speed times (1 + fixed / rotating damping)."""
    critical, rotating, fixed = 100.0, 2.0, 1.0
    speed = factor * critical * (1 + fixed / rotating)
    damper = rotating * np.eye(4)
    stiffness = critical**2 * np.eye(4) + speed * circulatory_matrix(damper)
    state = np.block([[np.zeros((4, 4)), np.eye(4)], [-stiffness, -(damper + fixed * np.eye(4))]])
    assert (np.linalg.eigvals(state).real.max() < 0) == stable


def test_rotating_damping_does_no_work_on_a_shaft_that_whirls_with_it():
    rotor = assemble_rotor([ShaftElement(0.1, 0.03)] * 2, material=STEEL)
    damping = 1e-5 * rotor.stiffness
    # x + iy and its angles turn rigidly at the speed: q' = speed J^T q.
    shape = np.tile([1.0, 0.0], 6) * np.arange(1, 13)
    turned = np.kron(np.eye(6), np.array([[0.0, -1.0], [1.0, 0.0]])) @ shape
    speed = 37.0
    force = damping @ (speed * turned) + speed * circulatory_matrix(damping) @ shape
    assert np.abs(force).max() < 1e-12 * np.abs(damping @ (speed * turned)).max()


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: modal_damping(np.eye(4), np.eye(4), ratios=[-0.1]), "Damping ratios"),
        (lambda: modal_damping(np.eye(4), np.eye(4), ratios=[]), "Damping ratios"),
        (lambda: stiffness_proportional_damping(np.eye(4), ratio=-1, at_frequency_rad_s=1.0), "Damping ratio -1"),
        (lambda: stiffness_proportional_damping(np.eye(4), ratio=0.1, at_frequency_rad_s=0.0), "Frequency"),
        (lambda: circulatory_matrix(np.eye(6)), "multiple of 4"),
        (lambda: assemble_torsion([], material=STEEL), "0 elements"),
    ],
)
def test_wrong_values_are_named(call, match):
    with pytest.raises(InvalidValueError, match=match):
        call()
