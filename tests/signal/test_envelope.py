"""Envelope analysis: known modulations, known impact rates, and the choice of the band."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal.envelope import (
    EnvelopeSpectrum,
    band_envelope,
    demodulation_bands,
    envelope_spectra,
    most_impulsive,
)
from rotorwise.diagnose.signal.spectrum import peak_near
from rotorwise.simulators.errors import InvalidValueError

RATE = 20_000.0
LENGTHS = [40_000, 40_001, 39_989]  # even, odd, prime


def times(samples: int) -> np.ndarray:
    return np.arange(samples) / RATE


def impact_train(samples: int, *, per_second: float, resonance_hz: float, decay_s: float = 1e-3) -> np.ndarray:
    """Ringing at each strike, strikes between samples included."""
    time, signal = times(samples), np.zeros(samples)
    for strike in np.arange(0.003, time[-1], 1 / per_second):
        first = int(np.ceil(strike * RATE))
        after = time[first : first + int(10 * decay_s * RATE)] - strike
        ring = np.exp(-after / decay_s) * np.sin(2 * np.pi * resonance_hz * after)
        signal[first : first + ring.size] += ring
    return signal


def only(signal: np.ndarray, low_hz: float, high_hz: float, *, highest_line_hz: float = 800.0) -> EnvelopeSpectrum:
    (found,) = envelope_spectra(
        signal, rate_hz=RATE, bands=[(low_hz, high_hz)], highest_line_hz=highest_line_hz, floor_width_hz=40
    )
    return found


def line(envelope: EnvelopeSpectrum, frequency_hz: float) -> tuple[float, float]:
    found, height, _ = peak_near(envelope.spectrum, 0, frequency_hz, tolerance_hz=2 * envelope.spectrum.resolution_hz)
    return found, height


# --- known modulations ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("samples", LENGTHS)
@pytest.mark.parametrize("depth", [0.05, 0.5, 0.95])
def test_the_line_of_a_modulated_tone_is_its_depth(samples, depth):
    time = times(samples)
    signal = 2.5 * (1 + depth * np.cos(2 * np.pi * 87.3 * time)) * np.cos(2 * np.pi * 4000 * time)
    found = only(signal, 3000, 5000)
    frequency, height = line(found, 87.3)
    assert frequency == pytest.approx(87.3, rel=1e-4)
    assert height == pytest.approx(depth, rel=5e-3)
    assert found.mean == pytest.approx(2.5, rel=5e-3)


@pytest.mark.parametrize("samples", LENGTHS)
@pytest.mark.parametrize("depth", [0.2, 0.6])
def test_the_line_of_modulated_noise_is_its_depth(samples, depth):
    """Mean over 12 records: the envelope of noise scatters by 52 % of its mean, in each of some 4000 values."""
    time = times(samples)
    rng = np.random.default_rng([1, samples])
    heights = []
    for _ in range(12):
        noise = rng.normal(size=samples) * (1 + depth * np.cos(2 * np.pi * 61 * time))
        heights.append(line(only(noise, 4000, 6000), 61)[1])
    assert np.mean(heights) == pytest.approx(depth, abs=4 * 0.52 * np.sqrt(3 / 4000 / 12))


@pytest.mark.parametrize("samples", LENGTHS)
@pytest.mark.parametrize("per_second", [31.4, 81.13, 162.2])
def test_impacts_give_lines_at_their_rate_within_0_1_percent(samples, per_second):
    signal = impact_train(samples, per_second=per_second, resonance_hz=4200)
    signal = signal + np.random.default_rng(2).normal(0, 0.1, samples)
    found = only(signal, 3000, 5500)
    for harmonic in (1, 2, 3):
        frequency, height = line(found, harmonic * per_second)
        assert frequency == pytest.approx(harmonic * per_second, rel=1e-3)
        assert height > 10 * float(np.median(found.spectrum.floor))
    # Between the harmonics there is nothing.
    assert line(found, 1.5 * per_second)[1] < 0.1 * line(found, per_second)[1]


def test_a_steady_tone_has_no_modulation():
    found = only(np.sin(2 * np.pi * 4000 * times(40_000)), 3000, 5000)
    assert found.spectrum.amplitude[0, 4:].max() < 1e-2
    assert found.kurtosis == pytest.approx(-1.0, abs=0.01)


@given(gain=st.floats(1e-6, 1e6))
@settings(max_examples=15, deadline=None)
def test_depth_and_kurtosis_do_not_depend_on_the_gain(gain):
    signal = impact_train(8000, per_second=81.13, resonance_hz=4200)
    plain, other = only(signal, 3000, 5000), only(gain * signal, 3000, 5000)
    assert other.spectrum.amplitude == pytest.approx(plain.spectrum.amplitude, abs=1e-9)
    assert other.kurtosis == pytest.approx(plain.kurtosis, rel=1e-6)
    assert other.mean == pytest.approx(gain * plain.mean, rel=1e-6)


# --- bands ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("samples", LENGTHS)
@pytest.mark.parametrize(("low", "high"), [(0.0, 10_000.0), (0.0, 2500.0), (7500.0, 10_000.0), (3000.0, 3600.0)])
def test_the_kurtosis_of_gaussian_noise_is_zero_in_any_band(samples, low, high):
    """<|z|^4> / <|z|^2>^2 - 2 scatters by 2 / sqrt(values in the band)."""
    rng = np.random.default_rng([3, samples])
    found = [only(rng.normal(size=samples), low, high).kurtosis for _ in range(10)]
    values = (high - low) / RATE * samples
    assert np.mean(found) == pytest.approx(0.0, abs=4 * 2 / np.sqrt(10 * values) + 2 / values)


@pytest.mark.parametrize("resonance", [1800.0, 4200.0, 7700.0])
def test_the_most_impulsive_band_holds_the_resonance(resonance):
    samples = 60_000
    rng = np.random.default_rng(4)
    signal = impact_train(samples, per_second=33, resonance_hz=resonance) + rng.normal(0, 0.15, samples)
    signal = signal + 2 * np.sin(2 * np.pi * 613 * times(samples))
    bands = demodulation_bands(lowest_hz=500, highest_hz=9800, narrowest_hz=500)
    found = envelope_spectra(signal, rate_hz=RATE, bands=bands, highest_line_hz=800, floor_width_hz=40)
    best = most_impulsive(found, 0)
    assert best.low_hz < resonance < best.high_hz
    assert best.high_hz - best.low_hz < 5000
    assert best.kurtosis > 1.0
    assert line(best, 33.0)[0] == pytest.approx(33.0, rel=1e-3)


def test_each_channel_has_its_own_most_impulsive_band():
    rng = np.random.default_rng(5)
    signals = np.stack([impact_train(40_000, per_second=50, resonance_hz=one) for one in (2000.0, 8000.0)])
    signals = signals + rng.normal(0, 0.1, signals.shape)
    bands = [(500.0, 3500.0), (3500.0, 6500.0), (6500.0, 9500.0)]
    found = envelope_spectra(signals, rate_hz=RATE, bands=bands, highest_line_hz=500, floor_width_hz=40)
    assert len(found) == 6
    assert [most_impulsive(found, channel).low_hz for channel in (0, 1)] == [500.0, 6500.0]
    swapped = envelope_spectra(signals[::-1], rate_hz=RATE, bands=bands, highest_line_hz=500, floor_width_hz=40)
    assert swapped[0].kurtosis == found[3].kurtosis


@pytest.mark.parametrize("frequency", [2000.0, 2900.0, 5100.0, 6000.0])
def test_a_tone_outside_the_band_is_rejected(frequency):
    # A whole number of periods: nothing leaks, what is left is the band's own fault.
    envelope, _ = band_envelope(np.sin(2 * np.pi * frequency * times(40_000)), rate_hz=RATE, low_hz=3000, high_hz=5000)
    assert envelope.max() < 1e-9


@pytest.mark.parametrize("frequency", [3200.0, 4000.0, 4800.0])
def test_a_tone_inside_the_band_keeps_its_amplitude(frequency):
    envelope, rate = band_envelope(
        3 * np.sin(2 * np.pi * frequency * times(40_000)), rate_hz=RATE, low_hz=3000, high_hz=5000
    )
    assert envelope == pytest.approx(np.full(envelope.size, 3.0), rel=1e-9)
    assert rate == pytest.approx(2000, rel=0.03)


@given(samples=st.integers(200, 3000), low=st.floats(0, 0.45), width=st.floats(0.02, 0.5))
@settings(max_examples=60, deadline=None)
def test_any_length_and_band_gives_an_envelope_of_the_records_duration(samples, low, width):
    high = min(low + width, 0.5)
    signal = np.random.default_rng(samples).normal(size=samples)
    envelope, rate = band_envelope(signal, rate_hz=1.0, low_hz=low, high_hz=high)
    assert envelope.size / rate == pytest.approx(samples)
    assert rate >= high - low - 2 / samples
    assert np.isfinite(envelope).all()
    (found,) = envelope_spectra(signal, rate_hz=1.0, bands=[(low, high)], highest_line_hz=0.1, floor_width_hz=0.02)
    assert found.spectrum.amplitude.shape == found.spectrum.floor.shape == (1, found.spectrum.frequency_hz.size)
    assert np.isfinite(found.spectrum.amplitude).all()


@pytest.mark.parametrize(("low", "high"), [(-1.0, 100.0), (200.0, 200.0), (300.0, 200.0), (100.0, 10_001.0)])
def test_bands_that_do_not_fit_are_refused(low, high):
    with pytest.raises(InvalidValueError, match="allowed: 0 <= low < high <= rate/2"):
        band_envelope(np.zeros(1000), rate_hz=RATE, low_hz=low, high_hz=high)


def test_a_dead_channel_gives_zeros():
    found = only(np.full(4000, 1.7), 3000, 5000)
    assert found.mean < 1e-12
    assert only(np.zeros(4000), 3000, 5000).spectrum.amplitude.max() == 0.0


# --- tiling ---------------------------------------------------------------------------------------------------


@given(low=st.floats(0, 1000), span=st.floats(10, 20_000), narrowest=st.floats(1, 3000))
def test_bands_tile_the_range_at_every_width(low, span, narrowest):
    bands = demodulation_bands(lowest_hz=low, highest_hz=low + span, narrowest_hz=narrowest)
    assert bands[0] == (low, pytest.approx(low + span))
    assert all(high - start >= narrowest * (1 - 1e-9) for start, high in bands[1:])
    for parts in (1, 2, 3, 4, 6, 8, 12):
        tiles = [band for band in bands if band[1] - band[0] == pytest.approx(span / parts)]
        if parts == 1 or span / parts >= narrowest:
            assert len(tiles) == parts
            edges = np.array(tiles)
            assert edges[1:, 0] == pytest.approx(edges[:-1, 1])
            assert (edges[0, 0], edges[-1, 1]) == pytest.approx((low, low + span))
        else:
            assert not tiles
