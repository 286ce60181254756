"""Re-mounted sensor: rotation keeps lengths, gain scales, the angle comes back out of the record."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators.effects.remounted_sensor import RemountedSensor
from rotorwise.simulators.machine import find_machine

from .sensor_records import record, run

GENERATOR = np.random.default_rng(1)
XYZ = GENERATOR.normal(size=(3, 200))
ANGLE = st.floats(-math.pi, math.pi)


@settings(max_examples=30, deadline=None)
@given(turn=ANGLE, tilt=ANGLE, gain=st.floats(-0.9, 2.0))
def test_rotation_keeps_the_length_of_the_vector(turn, tilt, gain):
    made = RemountedSensor(gain_change=gain, rotation_rad=turn, tilt_rad=tilt)
    turned = run(made, record(*XYZ)).signals
    assert np.linalg.norm(turned, axis=0) == pytest.approx((1 + gain) * np.linalg.norm(XYZ, axis=0))


def test_vertical_motion_seen_by_a_turned_sensor(figure):
    # A sensor turned by a from x to y reads vertical motion v as v sin a on its x axis and v cos a on its y axis.
    v = XYZ[0]
    made = RemountedSensor(gain_change=0.0, rotation_rad=0.3, tilt_rad=0.0)
    turned = run(made, record(0 * v, v)).signals
    assert turned == pytest.approx(np.stack([v * math.sin(0.3), v * math.cos(0.3)]))
    expected = np.stack([v * math.sin(0.3), v * math.cos(0.3)])
    figure("Both axes of a turned sensor against sine and cosine", turned, expected)


def test_single_axis_sensor_keeps_the_cosine():
    made = RemountedSensor(gain_change=0.0, rotation_rad=0.3, tilt_rad=0.2)
    assert run(made, record(XYZ[0], directions="y")).signals[0] == pytest.approx(XYZ[0] * math.cos(0.3) * math.cos(0.2))


def test_all_lines_change_by_one_factor():
    made = run(RemountedSensor(gain_change=0.2, rotation_rad=0.0, tilt_rad=0.0), record(*XYZ))
    ratio = np.fft.rfft(made.signals, axis=1) / np.fft.rfft(XYZ, axis=1)
    assert ratio == pytest.approx(np.full(ratio.shape, 1.2))


def test_one_sensor_only():
    rig = find_machine("test_rig")
    options = {"speed_rpm": 1800, "duration_s": 0.05, "rate_hz": 2000.0, "settle_s": 0.05}
    plain = rig.simulate(**options)
    for at, where in (("", "housing_a"), ("housing_b", "housing_b")):
        changed = rig.with_effects(RemountedSensor(at=at)).simulate(**options)
        moved = {
            p.location for p, a, b in zip(plain.probes, plain.signals, changed.signals, strict=True) if (a != b).any()
        }
        assert moved == {where}
