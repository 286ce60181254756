"""Shaft bow: Jeffcott rotor with bow and unbalance in closed form, beam deflections, slow roll, its line."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rotorwise.simulators.effects.shaft_bow import ShaftBow
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.rotor_dynamics.bending_shaft import BendingShaft
from rotorwise.simulators.rotor_dynamics.shaft_elements import assemble_rotor
from rotorwise.simulators.rotor_dynamics.shaft_parts import ShaftElement
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

from .jeffcott import CRITICAL, CRITICAL_RPM, MASS, STEEL, STIFFNESS, jeffcott, orbit


def forward(machine, speed_rpm):
    return orbit(harmonic_balance(machine, speed_rpm=speed_rpm, harmonics=2), 1.0)[0]


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    ratio=st.floats(0.05, 3.0),
    bow=st.floats(1e-6, 1e-3),
    angle=st.floats(-3.1, 3.1),
    eccentricity=st.floats(0.0, 1e-4),
)
def test_nicholas_gunter_allaire(figure, ratio, bow, angle, eccentricity):
    zeta, speed = 0.03, ratio * CRITICAL
    machine = jeffcott(eccentricity_m=eccentricity, damping_ratio=zeta).with_effects(
        ShaftBow(bow_m=bow, angle_rad=angle, position=0.5)
    )
    force = STIFFNESS * bow * np.exp(1j * angle) + MASS * eccentricity * speed**2
    expected = force / (STIFFNESS - MASS * speed**2 + 2j * zeta * MASS * CRITICAL * speed)
    assert forward(machine, ratio * CRITICAL_RPM) == pytest.approx(expected, rel=1e-9)
    figure("1X of bow and unbalance (Nicholas, Gunter, Allaire)", forward(machine, ratio * CRITICAL_RPM), expected)


def test_a_bow_opposite_to_the_unbalance_cancels_it_at_one_speed():
    bow, eccentricity = 2e-5, 5e-5
    machine = jeffcott(eccentricity_m=eccentricity).with_effects(ShaftBow(bow_m=bow, angle_rad=math.pi, position=0.5))
    balanced = math.sqrt(bow / eccentricity)
    assert abs(forward(machine, balanced * CRITICAL_RPM)) < 1e-12
    # The phase turns by 180 degrees there although no resonance is passed.
    below, above = (forward(machine, balanced * CRITICAL_RPM * f) for f in (0.95, 1.05))
    assert below.real < 0 < above.real


def test_slow_roll_vector_of_the_sprung_shaft():
    machine = jeffcott(damping_ratio=0.05).with_effects(ShaftBow(bow_m=7e-5, angle_rad=0.8, position=0.5))
    assert forward(machine, 1e-3) == pytest.approx(7e-5 * np.exp(0.8j), rel=1e-6)


SPAN, DIAMETER = 0.4, 0.02


def shaft(overhang=2):
    elements = [ShaftElement(SPAN / 8, DIAMETER)] * (8 + 2 * overhang)
    return BendingShaft(
        "s", prefix="s", elements=elements, material=STEEL, bearing_nodes=(overhang, overhang + 8)
    ), elements


@pytest.mark.parametrize("position", [0.5, 0.25, 0.33])
def test_stiffness_of_a_simply_supported_beam(position):
    made, elements = shaft()
    part = elements[0]
    a, b = position * SPAN, (1 - position) * SPAN
    shear = STEEL.shear_modulus_pa * part.area_m2 * part.shear_coefficient(STEEL.poisson_ratio)
    bending = STEEL.youngs_modulus_pa * part.second_moment_m4
    yields = a**2 * b**2 / (3 * bending * SPAN) + a * b / (shear * SPAN)
    on_node = abs(position * 8 - round(position * 8)) < 1e-9
    # Between nodes the element's own shape under the load is missing: h^3 / (192 E I) of a held element at most.
    missing = 0 if on_node else (SPAN / 8) ** 3 / (192 * bending) + SPAN / 8 / (4 * shear)
    found = 1 / made.deflection(position).stiffness_n_m
    assert yields - missing - 1e-9 * yields <= found <= yields * (1 + 1e-9)


def test_the_free_shaft_takes_the_bent_shape_without_loading_its_bearings():
    made, elements = shaft()
    place = made.deflection(0.3)
    matrices = assemble_rotor(elements, material=STEEL)
    names = [f"s_{n}.{c}" for n in range(len(elements) + 1) for c in ("x", "y", "angle_x", "angle_y")]
    for row in (place.x, place.y):
        force = np.array([row.get(name, 0.0) for name in names])
        shape = np.linalg.lstsq(matrices.stiffness, place.stiffness_n_m * force, rcond=None)[0]
        # Self-balanced: the free shaft can take it.
        assert matrices.stiffness @ shape == pytest.approx(place.stiffness_n_m * force, abs=1e-6 * place.stiffness_n_m)
        assert force @ shape == pytest.approx(1.0, rel=1e-8)


def even_shape(made, elements, rows):
    """Return displacement and slope of a shaft evenly curved between its bearings, 1 m deep in the middle."""
    z = made._nodes - made._nodes[made._bearings[0]]
    inside = np.clip(z, 0.0, SPAN)
    slope = 4 / SPAN - 8 * inside / SPAN**2
    deflection = 4 * inside / SPAN - 4 * inside**2 / SPAN**2 + slope * (z - inside)
    values = {}
    for n in range(len(elements) + 1):
        values |= {f"s_{n}.{rows[0]}": deflection[n], f"s_{n}.{rows[1]}": rows[2] * slope[n]}
    return values


@pytest.mark.parametrize(("axis", "rows"), [(0, ("x", "angle_y", 1.0)), (1, ("y", "angle_x", -1.0))])
def test_the_force_of_an_even_bow_is_that_of_the_arc(axis, rows):
    made, elements = shaft()
    names = [f"s_{n}.{c}" for n in range(len(elements) + 1) for c in ("x", "y", "angle_x", "angle_y")]
    arc = even_shape(made, elements, rows)
    expected = assemble_rotor(elements, material=STEEL).stiffness @ np.array([arc.get(name, 0.0) for name in names])
    found = np.array([made.bend(0.3, 1.0)[axis].get(name, 0.0) for name in names])
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("position", [0.25, 0.3, 0.5])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_kinked_shaft_is_straight_to_both_sides(axis, position):
    made, elements = shaft()
    names = [f"s_{n}.{c}" for n in range(len(elements) + 1) for c in ("x", "y", "angle_x", "angle_y")]
    force = np.array([made.bend(position, -1.0)[axis].get(name, 0.0) for name in names])
    stiffness = assemble_rotor(elements, material=STEEL).stiffness
    shape = np.linalg.lstsq(stiffness, force, rcond=None)[0]
    # The free shaft takes it: no bearing is loaded.
    assert stiffness @ shape == pytest.approx(force, abs=1e-6 * np.abs(force).max())
    deflection = np.array([shape[names.index(f"s_{n}.{'xy'[axis]}")] for n in range(len(elements) + 1)])
    share = (made._nodes - made._nodes[made._bearings[0]]) / SPAN
    deflection -= np.interp(share, (0.0, 1.0), deflection[list(made._bearings)], left=0.0, right=0.0)
    inside = (share >= 0) & (share <= 1)
    roof = np.minimum(share / position, (1 - share) / (1 - position))
    assert deflection[inside] == pytest.approx(roof[inside], abs=1e-6)


def test_between_load_and_arc_the_forces_mix():
    made, _ = shaft()
    load, arc, mixed = (made.bend(0.3, share)[0] for share in (0.0, 1.0, 0.4))
    for name in mixed:
        assert mixed[name] == pytest.approx(0.6 * load.get(name, 0.0) + 0.4 * arc.get(name, 0.0), rel=1e-12, abs=1e-9)
    place = made.deflection(0.3)
    for name in load:
        assert load[name] == pytest.approx(place.stiffness_n_m * place.x.get(name, 0.0), rel=1e-12)


def test_a_sprung_shaft_has_one_shape():
    one, other = (
        forward(jeffcott().with_effects(ShaftBow(bow_m=5e-5, evenness=share)), 0.5 * CRITICAL_RPM)
        for share in (0.0, 1.0)
    )
    assert one == other


def test_the_test_rig_feels_the_same_force_at_every_speed():
    machine = find_machine("test_rig").with_parameters(residual_unbalance_kg_m=0.0)
    for line in ShaftBow().signature(machine):
        assert line.order == 1.0
    forces = [
        [f for f in machine.with_effects(ShaftBow()).assembly(speed_rpm=speed).forces if "bow" in f.name]
        for speed in (600, 2400)
    ]
    assert forces[0] == forces[1]
    assert len(forces[0]) == 1
