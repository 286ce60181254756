"""Sidebands against the closed forms of amplitude and phase modulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal.sidebands import Sideband, SidebandFamily, find_sidebands
from rotorwise.diagnose.signal.spectrum import spectrum_with_floor
from scipy.special import jv

RATE = 5000.0
TIME = np.arange(40_000) / RATE
CARRIER, MODULATOR = 612.34, 24.71


def family(signal: np.ndarray, **options) -> SidebandFamily:
    noise = np.random.default_rng(0).normal(0, 1e-3, signal.size)
    spectrum = spectrum_with_floor(signal + noise, rate_hz=RATE, floor_width_hz=30)
    wanted = {"channel": 0, "carrier_hz": CARRIER, "modulator_hz": MODULATOR, **options}
    return find_sidebands(spectrum, **wanted)


def amplitude_modulated(depth: float) -> np.ndarray:
    return (1 + depth * np.cos(2 * np.pi * MODULATOR * TIME)) * np.cos(2 * np.pi * CARRIER * TIME + 0.4)


def phase_modulated(index: float) -> np.ndarray:
    return np.cos(2 * np.pi * CARRIER * TIME + index * np.sin(2 * np.pi * MODULATOR * TIME))


@pytest.mark.parametrize("depth", [0.02, 0.3, 0.9])
def test_amplitude_modulation_gives_one_pair_of_half_the_depth(depth):
    found = family(amplitude_modulated(depth))
    heights = {side.number: side.amplitude for side in found.sidebands}
    assert found.carrier.amplitude == pytest.approx(1.0, rel=1e-3)
    assert heights[-1] == pytest.approx(depth / 2, rel=5e-3)
    assert heights[1] == pytest.approx(depth / 2, rel=5e-3)
    assert max(heights[number] for number in (-3, -2, 2, 3)) < 1e-4
    assert found.modulation_index == pytest.approx(depth, rel=5e-3)


@pytest.mark.parametrize("index", [0.05, 0.5, 1.5])
def test_phase_modulation_gives_bessel_functions(index):
    found = family(phase_modulated(index))
    assert found.carrier.amplitude == pytest.approx(jv(0, index), rel=1e-3)
    for side in found.sidebands:
        expected = abs(jv(side.number, index))
        # Weak ones are known to the noise only: 5e-5 is three times its amplitude in a bin.
        assert side.amplitude == pytest.approx(expected, rel=2e-3, abs=5e-5)
    assert found.modulation_index == pytest.approx(2 * jv(1, index) / jv(0, index), rel=2e-3)


def test_frequencies_lie_at_whole_multiples_of_the_modulator():
    found = family(phase_modulated(1.5))
    assert [side.number for side in found.sidebands] == [-3, -2, -1, 1, 2, 3]
    for side in found.sidebands:
        assert side.frequency_hz == pytest.approx(CARRIER + side.number * MODULATOR, abs=2e-3)


@pytest.mark.parametrize("error_bins", [-1.5, 1.5])
def test_the_carrier_is_found_within_two_bins(error_bins):
    found = family(amplitude_modulated(0.3), carrier_hz=CARRIER + error_bins * RATE / TIME.size)
    assert found.carrier.frequency_hz == pytest.approx(CARRIER, abs=1e-3)
    assert found.modulation_index == pytest.approx(0.3, rel=5e-3)


def test_without_modulation_the_index_is_zero():
    assert family(np.cos(2 * np.pi * CARRIER * TIME)).modulation_index == 0.0


@pytest.mark.parametrize(("carrier", "expected"), [(40.0, [-1, 1, 2, 3]), (2460.0, [-3, -2, -1, 1])])
def test_sidebands_beyond_the_band_are_left_out(carrier, expected):
    found = family(np.cos(2 * np.pi * carrier * TIME), carrier_hz=carrier)
    assert [side.number for side in found.sidebands] == expected


@given(gain=st.floats(1e-6, 1e6), depth=st.floats(0.05, 0.95), pairs=st.integers(1, 6))
@settings(max_examples=20, deadline=None)
def test_the_index_does_not_depend_on_the_gain(gain, depth, pairs):
    signal = amplitude_modulated(depth) + np.random.default_rng(1).normal(0, 1e-3, TIME.size)
    spectrum = spectrum_with_floor(gain * signal, rate_hz=RATE, floor_width_hz=30)
    found = find_sidebands(spectrum, channel=0, carrier_hz=CARRIER, modulator_hz=MODULATOR, pairs=pairs)
    assert len(found.sidebands) == 2 * pairs
    assert found.modulation_index == pytest.approx(depth, rel=0.01)


def test_power_ratio_without_noise_is_infinite():
    assert Sideband(1, 10.0, 1.0, 0.0).power_ratio == math.inf
    assert Sideband(1, 10.0, 3.0, 0.5).power_ratio == pytest.approx(36.0)
