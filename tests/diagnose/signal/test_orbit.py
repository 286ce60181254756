"""Orbits and full spectra against the ellipse's closed form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal.orbit import ellipse, filtered_orbit, full_spectrum
from rotorwise.simulators.errors import InvalidValueError

RATE = 5_000.0
TIME = np.arange(10_000) / RATE
angles = st.floats(-1.5, 1.5)


@given(forward=st.floats(0.1, 10), backward=st.floats(0.1, 10), tilt=angles, start=angles)
@settings(max_examples=40, deadline=None)
def test_two_circles_make_the_ellipse(forward, backward, tilt, start):
    """z = f exp(i (w t + tilt + start)) + b exp(-i (w t - tilt + start))."""
    plus, minus = forward * np.exp(1j * (tilt + start)), backward * np.exp(1j * (tilt - start))
    # x = Re z and y = Im z as amplitudes of exp(i w t).
    x, y = plus + np.conj(minus), -1j * (plus - np.conj(minus))
    found = ellipse(x, y)
    assert found.forward == pytest.approx(forward)
    assert found.backward == pytest.approx(backward)
    assert found.major == pytest.approx(forward + backward)
    assert found.minor == pytest.approx(forward - backward, abs=1e-9)
    assert np.sin(found.inclination_rad - tilt) == pytest.approx(0.0, abs=1e-9)
    points = filtered_orbit(x, y, points=3600)
    radius = np.hypot(*points)
    assert radius.max() == pytest.approx(found.major, rel=1e-4)
    assert radius.min() == pytest.approx(abs(found.minor), abs=1e-3 * found.major)
    # The sense of rotation: the sign of the area swept.
    area = float((points[0] * np.gradient(points[1]) - points[1] * np.gradient(points[0])).sum())
    if abs(found.direction) > 0.01:
        assert np.sign(area) == np.sign(found.direction)


def test_a_straight_line_has_no_direction_and_nothing_no_axes():
    line = ellipse(2.0, 2.0)
    assert line.direction == pytest.approx(0.0, abs=1e-12)
    assert line.inclination_rad == pytest.approx(np.pi / 4)
    assert line.major == pytest.approx(2 * np.sqrt(2))
    assert ellipse(0.0, 0.0).direction == 0.0


def test_full_spectrum_of_forward_and_backward_whirl():
    x = 3 * np.cos(2 * np.pi * 50 * TIME) + np.cos(2 * np.pi * 24 * TIME)
    y = 1 * np.sin(2 * np.pi * 50 * TIME) - np.sin(2 * np.pi * 24 * TIME)
    found = full_spectrum(x, y, rate_hz=RATE)
    at = {f: int(np.argmin(np.abs(found.frequency_hz - f))) for f in (24, 50)}
    assert found.forward[at[50]] == pytest.approx(2.0, abs=1e-6)
    assert found.backward[at[50]] == pytest.approx(1.0, abs=1e-6)
    assert found.forward[at[24]] == pytest.approx(0.0, abs=1e-6)
    assert found.backward[at[24]] == pytest.approx(1.0, abs=1e-6)


@given(turn=st.floats(0, 6))
@settings(max_examples=10, deadline=None)
def test_turning_the_probes_changes_nothing(turn):
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(2, 2000))
    plain = full_spectrum(x, y, rate_hz=RATE)
    other = full_spectrum(np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, rate_hz=RATE)
    assert other.forward == pytest.approx(plain.forward, abs=1e-12)
    assert other.backward == pytest.approx(plain.backward, abs=1e-12)


@pytest.mark.parametrize("samples", [997, 1000, 1001])
def test_any_length_has_both_halves(samples):
    signal = np.cos(2 * np.pi * 100 * TIME[:samples])
    found = full_spectrum(signal, 0 * signal, rate_hz=RATE)
    assert found.forward == pytest.approx(found.backward, abs=1e-12)
    assert found.frequency_hz[-1] == pytest.approx(RATE / 2)


def test_unequal_probes_are_refused():
    with pytest.raises(InvalidValueError, match="equally long"):
        full_spectrum(TIME, TIME[:-1], rate_hz=RATE)
