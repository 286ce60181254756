"""Rigid offset coupling: the housing's inertia force from its path."""

import cmath
import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import Assembly, Place
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.rotor_dynamics.rigid_offset_coupling import RigidOffsetCoupling

MASS, GAP = 1.3, 0.02
PLACE = Place("end", frozenset({"coupling"}), {"x": {"x": 1.0}, "y": {"y": 1.0}})


def coupling(**changes):
    return RigidOffsetCoupling(**{"name": "c", "place": PLACE, "housing_mass_kg": MASS, "gap_m": GAP, **changes})


def forces(part, time_s, speed, acceleration=0.0):
    """Force in x and y, shape (2, instants), for a shaft with phase speed t + acceleration t^2 / 2."""
    assembly = Assembly(speed_rad_s=speed)
    part.finish(assembly)
    (force,) = assembly.forces
    phase = speed * time_s + acceleration * time_s**2 / 2
    line = Timeline(
        time_s[:, None],
        phase[:, None],
        (speed + acceleration * time_s)[:, None],
        np.full((time_s.size, 1), acceleration),
    )
    values = force.law.signals(line, np.array(force.parameters)[:, None])[:, :, 0]
    return np.array([values[[dict(d) for d in force.outputs].index({axis: 1.0})] for axis in "xy"])


def test_force_is_minus_mass_times_acceleration_of_the_housing_centre():
    """The centre is where the line through one hub along theta meets the line through the other at right angles."""
    offset, direction, speed, acceleration = 2e-4, 0.7, 150.0, 400.0
    part = coupling()
    part.misalign(offset_m=offset, angle_rad=0.0, offset_phase_rad=direction)

    def centre(time_s):
        theta = speed * time_s + acceleration * time_s**2 / 2
        along = offset * np.cos(direction - theta)
        return np.array([along * np.cos(theta), along * np.sin(theta)])

    time, width = np.linspace(0.01, 0.08, 40), 1e-5
    second = (centre(time + width) - 2 * centre(time) + centre(time - width)) / width**2
    expected = -MASS * second
    assert forces(part, time, speed, acceleration) == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())


def test_size_is_that_of_equation_13():
    """2 m_c w^2 (offset + gap tan(angle)) when both lie in one direction."""
    part = coupling()
    part.misalign(offset_m=1e-4, angle_rad=math.radians(1))
    values = forces(part, np.linspace(0, 0.1, 500), 188.5)
    size = 2 * MASS * 188.5**2 * (1e-4 + GAP * math.tan(math.radians(1)))
    assert np.hypot(*values) == pytest.approx(size, rel=1e-12)


def test_sense_of_turning():
    time = np.array([0.0, 1e-4])
    for backward, sign in ((False, 1), (True, -1)):
        part = coupling(against_rotation=backward)
        part.misalign(offset_m=1e-4)
        x, y = forces(part, time, 100.0)
        turned = cmath.phase(complex(x[1], y[1]) / complex(x[0], y[0]))
        assert turned == pytest.approx(sign * 2 * 100.0 * 1e-4, rel=1e-9)


def test_opposite_misalignments_cancel():
    part = coupling()
    part.misalign(offset_m=1e-4, offset_phase_rad=0.3)
    part.misalign(offset_m=1e-4, offset_phase_rad=0.3 + math.pi)
    assert forces(part, np.linspace(0, 0.1, 20), 188.5) == pytest.approx(0.0, abs=1e-12)


def test_an_aligned_coupling_adds_nothing():
    assembly = Assembly(speed_rad_s=1.0)
    coupling().finish(assembly)
    assert not assembly.forces
    (line,) = coupling().misalignment_lines()
    assert line.order == 2.0


def test_an_angle_in_degrees_is_refused():
    with pytest.raises(InvalidValueError, match="30 degrees"):
        coupling().misalign(offset_m=0.0, angle_rad=1.0)
