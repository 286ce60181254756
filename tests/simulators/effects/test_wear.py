"""Wear: none at the pitch point, harmonics of the mesh from the profile, no sidebands, no growth with load."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects.wear import Wear
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machines.gearbox import PINION_TEETH, tooth_pair
from rotorwise.simulators.rotor_dynamics.gear_mesh_law import GEAR_MESH
from rotorwise.simulators.rotor_dynamics.tooth_damage import wear_harmonics_m

from .test_tooth_crack import mesh_of

PAIR = tooth_pair()


def error(mesh, pitches):
    phase = np.asarray(pitches, float)[:, None] * 2 * math.pi / PINION_TEETH
    timeline = Timeline(phase, phase, np.ones_like(phase), np.zeros_like(phase))
    return GEAR_MESH.signals(timeline, np.array(mesh.interface_force().parameters)[:, None])[1, :, 0]


def sliding(phase):
    """Sliding speed of a pair over the pitch-line speed scale: difference of both roll radii's rates."""
    one, two = PAIR.roll_angles_rad(phase)
    return PAIR.pinion.base_radius_m * one / PAIR.pinion.teeth - PAIR.wheel.base_radius_m * two / PAIR.wheel.teeth


def test_wear_is_in_proportion_to_sliding():
    """Flank radii rho = r_b roll; sliding = w1 rho1 - w2 rho2, zero at the pitch point and linear along the contact."""
    pitch_point = PAIR.pitch_point_phase
    assert sliding(pitch_point) == pytest.approx(0.0, abs=1e-12)
    slope = [sliding(pitch_point + step) / step for step in (-0.5, 0.3, 0.6)]
    assert slope == pytest.approx([slope[0]] * 3)


def test_harmonics_are_those_of_the_shared_profile(figure):
    """In single contact the error is the wear itself; many harmonics give it back between the jumps."""
    harmonics = wear_harmonics_m(PAIR, wear_m=1e-5, count=400)
    phase = np.array([PAIR.contact_ratio - 1 + 0.1, 0.93])
    series = np.real(harmonics @ np.exp(2j * np.pi * np.outer(np.arange(1, 401), phase)))
    reach = max(PAIR.pitch_point_phase, PAIR.contact_ratio - PAIR.pitch_point_phase)
    wear = 1e-5 * np.abs(phase - PAIR.pitch_point_phase) / reach
    assert series[1] - series[0] == pytest.approx(wear[1] - wear[0], abs=2e-8)
    figure("Rise of the mesh error along a worn flank against the wear", series[1] - series[0], wear[1] - wear[0])


def test_the_mesh_repeats_with_every_tooth_and_the_error_is_linear_in_wear():
    pitches = np.linspace(0, 1, 50)
    one, two = (error(mesh_of(Wear(wear_m=w)), pitches) - error(mesh_of(), pitches) for w in (1e-5, 3e-5))
    assert two == pytest.approx(3 * one, abs=1e-15)
    later = error(mesh_of(Wear(wear_m=1e-5)), pitches + 7) - error(mesh_of(), pitches + 7)
    assert later == pytest.approx(one, abs=1e-12)
    assert 1e-6 < np.ptp(one) < 1e-5


def test_first_contact_shifts_the_error_with_the_mesh():
    moved = mesh_of(Wear(wear_m=1e-5))
    moved.first_contact_pitches = 0.25
    still, base = mesh_of(Wear(wear_m=1e-5)), mesh_of()
    pitches = np.linspace(0, 1, 20)
    assert error(moved, pitches) - error(base, pitches) == pytest.approx(
        error(still, pitches + 0.25) - error(base, pitches + 0.25), abs=1e-15
    )


def test_wear_of_two_effects_adds():
    twice, once = mesh_of(Wear(wear_m=1e-5), Wear(wear_m=2e-5)), mesh_of(Wear(wear_m=3e-5))
    assert twice.interface_force().parameters == pytest.approx(once.interface_force().parameters, rel=1e-12)
