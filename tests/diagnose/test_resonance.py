"""Humps of the noise floor, and the suspicion that rests on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose import analyse_recording
from rotorwise.diagnose.faults.resonance import prominent_peaks
from scipy.signal import find_peaks

from .conftest import HEALTHY, RATE_HZ, Make


@settings(deadline=None)
@given(st.integers(0, 10_000), st.integers(3, 200), st.floats(0.1, 3.0))
def test_prominent_peaks_are_those_of_scipy(seed: int, size: int, least: float) -> None:
    level = np.cumsum(np.random.default_rng(seed).normal(size=size))
    peaks, properties = find_peaks(level, prominence=least)
    ours = prominent_peaks(level, least=least)
    assert [index for index, _ in ours] == list(peaks)
    assert np.allclose([high for _, high in ours], properties["prominences"])


def test_a_line_on_a_hump_of_the_noise_is_suspected(make: Make) -> None:
    """The hump must be wider than the shaft speed, over which the floor is taken."""
    recording = make(lines={**HEALTHY, 6: 8.0}, seconds=20.0, noise_rms=0.02)
    noise = np.random.default_rng(4).normal(size=recording.signals.shape)
    frequency = np.fft.rfftfreq(recording.samples, 1 / RATE_HZ)
    gain = 1 / np.sqrt((1 - (frequency / 150.0) ** 2) ** 2 + (2 * 0.15 * frequency / 150.0) ** 2)
    hump = np.fft.irfft(np.fft.rfft(noise, axis=1) * gain, n=recording.samples, axis=1)
    found = analyse_recording(replace(recording, signals=recording.signals + 0.1 * hump)).findings
    flat = analyse_recording(recording).findings
    assert any(one.fault == "resonance" for one in found)
    assert not any(one.fault == "resonance" for one in flat)
