"""Zoom spectra against the direct sum and the plain spectrum."""

from __future__ import annotations

import numpy as np
import pytest
from rotorwise.diagnose.signal.spectrum import amplitude_spectrum
from rotorwise.diagnose.signal.zoom import zoom_spectrum
from rotorwise.simulators.errors import InvalidValueError

SIGNALS = np.random.default_rng(0).normal(size=(2, 1000))


def test_the_direct_sum():
    frequency, amplitude = zoom_spectrum(SIGNALS, rate_hz=500.0, low_hz=20.0, high_hz=30.0, lines=37)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(1000) / 1000)
    waves = np.exp(-2j * np.pi * np.outer(np.arange(1000) / 500.0, frequency))
    centred = SIGNALS - SIGNALS.mean(axis=1, keepdims=True)
    assert amplitude == pytest.approx(2 * np.abs((centred * window) @ waves) / window.sum(), rel=1e-9)


def test_the_bins_of_the_plain_spectrum():
    plain_frequency, plain = amplitude_spectrum(SIGNALS, rate_hz=500.0)
    frequency, amplitude = zoom_spectrum(SIGNALS, rate_hz=500.0, low_hz=20.0, high_hz=30.0, lines=21)
    assert frequency == pytest.approx(plain_frequency[40:61])
    assert amplitude == pytest.approx(plain[:, 40:61], rel=1e-9)


@pytest.mark.parametrize("band", [(30.0, 20.0), (-1.0, 10.0), (10.0, 300.0)])
def test_bands_outside_the_spectrum_are_refused(band):
    with pytest.raises(InvalidValueError, match="allowed"):
        zoom_spectrum(SIGNALS, rate_hz=500.0, low_hz=band[0], high_hz=band[1])
