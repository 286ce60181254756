"""Gear mesh: branches and jumps, contact and backlash, errors, energy."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machines.gearbox import tooth_pair
from rotorwise.simulators.rotor_dynamics.gear_mesh import (
    GearMesh,
    mesh_damping_n_s_m,
    misprinted_branches,
)
from rotorwise.simulators.rotor_dynamics.gear_mesh_law import GEAR_MESH
from rotorwise.simulators.rotor_dynamics.gear_mesh_stiffness import StiffnessBranch

TEETH, SPEED = 23, 188.5
PAIR = tooth_pair()


def mesh(**changes):
    values = {
        "name": "mesh",
        "along": {"d": 1.0},
        "branches": PAIR.branches,
        "mesh_order": float(TEETH),
        "damping_n_s_m": 1500.0,
        "backlash_m": 1e-4,
    }
    return GearMesh(**{**values, **changes})


def constant(stiffness):
    """Branches of a stiffness that never changes."""
    return tuple(
        StiffnessBranch(2 - i, start, end, np.array([stiffness]), 0.0)
        for i, (start, end) in enumerate([(0.0, 0.7), (0.7, 1.0)])
    )


def timeline(phase_rad, acceleration=0.0):
    phase = np.atleast_1d(np.asarray(phase_rad, float))[:, None]
    return Timeline(phase / SPEED, phase, np.full_like(phase, SPEED), np.full_like(phase, acceleration))


def signals(part, phase_rad, **options):
    parameters = np.array(part.interface_force().parameters)[:, None]
    return GEAR_MESH.signals(timeline(phase_rad), parameters, **options)[:, :, 0]


def mesh_force(part, approach, rate=0.0, phase_rad=0.0, *, compiled=True):
    """Force along the line of action, positive when the driving flanks press: core and interface together."""
    parameters = np.array(part.interface_force().parameters)[:, None]
    own = np.ascontiguousarray(signals(part, phase_rad))
    x, u = np.array([[approach], [rate]]), np.zeros((1, 1))
    law = GEAR_MESH.force if compiled else GEAR_MESH.force.py_func
    law(own, parameters, x, np.array([0, 1]), np.array([0]), u)
    return part.mean_stiffness_n_m * approach + part.damping_n_s_m * rate - u[0, 0]


def test_constant_stiffness_without_error_leaves_nothing_to_the_interface():
    part = mesh(branches=constant(3e8))
    assert part.mean_stiffness_n_m == pytest.approx(3e8, rel=1e-12)
    parameters = np.array(part.interface_force().parameters)[:, None]
    u = np.zeros((1, 1))
    own = np.ascontiguousarray(signals(part, 0.3))
    GEAR_MESH.force(own, parameters, np.array([[2e-6], [1e-3]]), np.array([0, 1]), np.array([0]), u)
    # Against 600 N in the core.
    assert abs(u[0, 0]) < 1e-9


def test_stiffness_follows_the_pair():
    phase = np.linspace(0.0, 4 * np.pi, 4001) + 1e-6
    stiffness = signals(mesh(), phase)[0]
    assert stiffness == pytest.approx(PAIR.mesh_stiffness_n_m(phase * TEETH / (2 * np.pi)), rel=1e-12)
    assert np.mean(stiffness) == pytest.approx(PAIR.mean_stiffness_n_m, rel=2e-3)


def test_first_contact_shifts_the_mesh():
    pitch = 2 * np.pi / TEETH
    shifted = signals(mesh(first_contact_pitches=0.25), 0.1 * pitch)[0]
    assert shifted == pytest.approx(signals(mesh(), 0.35 * pitch)[0], rel=1e-12)


def test_stiffness_jumps_where_the_law_says_and_nowhere_else():
    part = mesh(first_contact_pitches=0.3)
    parameters = np.array(part.interface_force().parameters)
    angles = GEAR_MESH.jumps(parameters, 0.0, 2 * np.pi)
    assert angles.size == 2 * TEETH
    nudge = 1e-9
    steps = signals(part, angles + nudge)[0] - signals(part, angles - nudge)[0]
    assert np.all(np.abs(steps) > 1e8)
    between = (angles[:-1] + angles[1:]) / 2
    assert np.all(np.abs(signals(part, between + nudge)[0] - signals(part, between - nudge)[0]) < 1e3)


@settings(max_examples=50, deadline=None)
@given(start=st.floats(-50, 50), first=st.floats(0.0, 2.0), second=st.floats(0.0, 2.0), offset=st.floats(-1.0, 1.0))
def test_every_jump_belongs_to_one_interval(start, first, second, offset):
    parameters = np.array(mesh(first_contact_pitches=offset).interface_force().parameters)
    middle, stop = start + first, start + first + second
    parts = [GEAR_MESH.jumps(parameters, start, middle), GEAR_MESH.jumps(parameters, middle, stop)]
    whole = GEAR_MESH.jumps(parameters, start, stop)
    assert np.array_equal(np.concatenate(parts), whole)
    assert abs(whole.size - 2 * TEETH * (stop - start) / (2 * np.pi)) <= 2


def test_a_branch_goes_on_smoothly_beyond_its_jump():
    """The solver runs a branch past its end: no kink there, in value or slope."""
    pitch = 2 * np.pi / TEETH
    change = PAIR.jump_phases[1]
    phase = (change + np.linspace(-0.04, 0.04, 81)) * pitch
    stiffness = signals(mesh(), phase, branch_rad=np.full((81, 1), (change - 0.01) * pitch))[0]
    model = PAIR.branches[0].stiffness_n_m(phase / pitch)
    assert stiffness == pytest.approx(model, rel=1e-12)
    # Second differences of a smooth curve over 0.001 of a pitch.
    assert np.abs(np.diff(stiffness, 2)).max() < 1e-5 * stiffness.mean()


def test_error_rate_is_the_derivative_of_the_error():
    part = mesh(mean_error_m=3e-5)
    part.add_error(order=float(TEETH), amplitude_m=2e-6, angle_rad=0.4)
    part.add_error(order=1.0, amplitude_m=1e-5, angle_rad=-1.0)
    phase, width = np.linspace(0, 7, 50), 1e-6
    _, error, rate = signals(part, phase)
    assert error == pytest.approx(3e-5 + 2e-6 * np.sin(TEETH * phase + 0.4) + 1e-5 * np.sin(phase - 1), rel=1e-12)
    slope = (signals(part, phase + width)[1] - signals(part, phase - width)[1]) / (2 * width) * SPEED
    assert rate == pytest.approx(slope, rel=1e-5, abs=1e-8)


def test_errors_of_one_order_add_as_vectors_and_zero_changes_nothing():
    part, nothing = mesh(), mesh()
    part.add_error(order=1.0, amplitude_m=1e-5, angle_rad=0.2)
    part.add_error(order=1.0, amplitude_m=1e-5, angle_rad=0.2 + math.pi)
    nothing.add_error(order=1.0, amplitude_m=0.0, angle_rad=0.7)
    assert signals(part, 0.6)[1:] == pytest.approx(0.0, abs=1e-18)
    before = nothing.interface_force().parameters
    nothing.add_error(order=1.0, amplitude_m=0.0, angle_rad=-2.0)
    assert nothing.interface_force().parameters == before


def test_contact_on_both_sides_and_none_between():
    part = mesh(branches=constant(3e8))
    assert mesh_force(part, 2e-6) == pytest.approx(600.0, rel=1e-9)
    assert mesh_force(part, 2e-6, 0.1) == pytest.approx(750.0, rel=1e-9)
    assert mesh_force(part, -5e-5, 0.1) == pytest.approx(0.0, abs=1e-9)
    assert mesh_force(part, -1.02e-4) == pytest.approx(-600.0, rel=1e-9)
    glued = dataclasses.replace(part, separates=False)
    assert mesh_force(glued, -5e-5, 0.1) == pytest.approx(-15000.0 + 150.0, rel=1e-9)


@settings(max_examples=60, deadline=None)
@given(approach=st.floats(-3e-4, 3e-4), rate=st.floats(-1, 1), phase=st.floats(0, 7))
def test_compiled_and_plain_python_agree(approach, rate, phase):
    part = mesh(mean_error_m=1e-5)
    compiled = mesh_force(part, approach, rate, phase)
    assert compiled == pytest.approx(mesh_force(part, approach, rate, phase, compiled=False), rel=1e-12, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(approach=st.floats(-2e-4, 2e-4))
def test_elastic_force_has_no_step(approach):
    """A small approach more makes a small force more, also where contact begins and ends."""
    part = mesh()
    rise = mesh_force(part, approach + 1e-10) - mesh_force(part, approach)
    assert -1e-6 <= rise <= 1e-10 * 6e8


def test_misprinted_stiffness_is_what_the_print_says():
    """Two pairs in series are softer than one: the print turns the pulse of the mesh stiffness over."""
    double, single = misprinted_branches(PAIR)
    phase = 0.3
    series = 1 / (1 / PAIR.pair_stiffness_n_m(phase) + 1 / PAIR.pair_stiffness_n_m(phase + 1))
    assert double.stiffness_n_m(phase) == pytest.approx(series, rel=1e-6)
    thrice = 1 / (1 / PAIR.pair_stiffness_n_m(0.8) + 2 * PAIR.contact_compliance_m_n)
    assert single.stiffness_n_m(0.8) == pytest.approx(thrice, rel=1e-6)
    assert double.stiffness_n_m(phase) < single.stiffness_n_m(0.8)


def test_mesh_damping_of_a_known_oscillator():
    # k = 4, m = 1, zeta = 1: critical damping 4.
    assert mesh_damping_n_s_m(stiffness_n_m=4.0, damping_ratio=1.0, effective_mass_kg=1.0) == pytest.approx(4.0)


@pytest.mark.parametrize("changes", [{"damping_n_s_m": -1.0}, {"backlash_m": -1e-6}, {"backlash_m": math.inf}])
def test_bad_values_are_refused(changes):
    with pytest.raises(InvalidValueError, match="allowed"):
        mesh(**changes)
