"""Spectra, noise floors and peaks against closed forms."""

from __future__ import annotations

import bisect
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal.spectrum import (
    Spectrum,
    amplitude_spectrum,
    averaged_power_density,
    chance_of_noise,
    fast_length,
    fast_length_within,
    hann,
    noise_floor,
    peak_near,
    peak_offsets,
    spectrum_with_floor,
)
from rotorwise.simulators.errors import InvalidValueError

RATE = 1000.0


def tone(frequency: float, samples: int, *, amplitude: float = 1.0, phase: float = 0.3) -> np.ndarray:
    return amplitude * np.cos(2 * np.pi * frequency * np.arange(samples) / RATE + phase)


def hann_line(offset: float) -> float:
    """Height of a tone's Hann line at a distance in bins (Harris 1978, equation 26, continuous limit)."""
    if abs(offset) < 1e-9:
        return 1.0
    return math.sin(math.pi * offset) / (math.pi * offset * (1 - offset**2))


# --- amplitudes -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("frequency", [3.0, 50.0, 250.0, 496.0])
def test_a_tone_on_a_bin_gives_its_amplitude_half_of_it_beside_and_nothing_further_off(frequency):
    _, amplitude = amplitude_spectrum(tone(frequency, 1000, amplitude=3.0), rate_hz=RATE)
    bin_ = round(frequency)
    expected = np.zeros(501)
    expected[bin_ - 1 : bin_ + 2] = [1.5, 3.0, 1.5]
    assert amplitude[0] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("offset", [-0.5, -0.31, 0.1, 0.25, 0.5])
def test_a_tone_off_a_bin_follows_the_main_lobe(offset):
    _, amplitude = amplitude_spectrum(tone(200 + offset, 1000), rate_hz=RATE)
    # The image at negative frequency adds less than 1e-6 here.
    expected = [hann_line(bin_ - offset) for bin_ in (-1, 0, 1)]
    assert amplitude[0, 199:202] == pytest.approx(expected, abs=2e-6)


def test_scalloping_loss_is_1_42_db():
    _, amplitude = amplitude_spectrum(tone(200.5, 1000), rate_hz=RATE)
    assert 20 * math.log10(amplitude.max()) == pytest.approx(-1.4236, abs=1e-3)


@pytest.mark.parametrize("samples", [1000, 1001, 1031, 2701, 4099, 20011])
@pytest.mark.parametrize("offset", [-0.45, -0.2, 0.0, 0.13, 0.37, 0.5])
def test_peaks_are_interpolated_to_1e_4_with_and_without_padding(samples, offset):
    """2701 samples are the worst case, padded by 7 %."""
    frequency = (round(0.2 * samples) + offset) * RATE / samples
    spectrum = spectrum_with_floor(tone(frequency, samples), rate_hz=RATE, floor_width_hz=20)
    found, amplitude, _ = peak_near(spectrum, 0, frequency, tolerance_hz=2 * spectrum.resolution_hz)
    assert found == pytest.approx(frequency, abs=1.2e-4 * RATE / samples)
    assert amplitude == pytest.approx(1.0, abs=1e-4)


@given(bins=st.floats(20, 480), padded=st.booleans())
@settings(max_examples=40, deadline=None)
def test_peak_offsets_agree_with_the_scalar_peak(bins, padded):
    samples = 1031 if padded else 1000
    spectrum = spectrum_with_floor(tone(bins * RATE / samples, samples), rate_hz=RATE, floor_width_hz=20)
    peak = int(spectrum.amplitude[0].argmax())
    offset = peak_offsets(spectrum.amplitude[0], np.array([peak]), padding=spectrum.padding)[0]
    resolution = spectrum.resolution_hz
    found, _, _ = peak_near(spectrum, 0, peak * resolution, tolerance_hz=0.3 * resolution)
    assert (peak + offset) * spectrum.resolution_hz == pytest.approx(found, abs=1e-9)


def test_a_slope_is_no_peak_and_is_left_where_it_is():
    spectrum = Spectrum(np.arange(32.0), np.arange(32.0)[None], np.ones((1, 32)))
    assert peak_near(spectrum, 0, 10.2, tolerance_hz=0.0) == (11.0, 11.0, 1.0)


@pytest.mark.parametrize("frequency", [-5.0, 0.0, 500.0, 1e6])
def test_peaks_asked_for_outside_the_band_come_from_its_ends(frequency):
    spectrum = spectrum_with_floor(np.random.default_rng(1).normal(size=1000), rate_hz=RATE, floor_width_hz=20)
    found, amplitude, floor = peak_near(spectrum, 0, frequency, tolerance_hz=1.0)
    assert 0 < found < 500
    assert amplitude > 0
    assert floor > 0


@given(gain=st.floats(1e-9, 1e9), offset=st.floats(-1e3, 1e3))
@settings(max_examples=30, deadline=None)
def test_amplitudes_and_floors_scale_with_the_signal_and_ignore_an_offset(gain, offset):
    signal = np.random.default_rng(2).normal(size=500)
    plain = spectrum_with_floor(signal, rate_hz=RATE, floor_width_hz=50)
    other = spectrum_with_floor(gain * (signal + offset), rate_hz=RATE, floor_width_hz=50)
    assert other.amplitude == pytest.approx(gain * plain.amplitude, rel=1e-6, abs=1e-9 * gain)
    assert other.floor == pytest.approx(gain * plain.floor, rel=1e-6)


@given(order=st.permutations(range(4)))
@settings(max_examples=10, deadline=None)
def test_channels_do_not_mix(order):
    signals = np.random.default_rng(3).normal(size=(4, 400))
    plain = spectrum_with_floor(signals, rate_hz=RATE, floor_width_hz=50)
    other = spectrum_with_floor(signals[list(order)], rate_hz=RATE, floor_width_hz=50)
    assert np.array_equal(other.amplitude, plain.amplitude[list(order)])
    assert np.array_equal(other.floor, plain.floor[list(order)])


@given(shift=st.integers(0, 999))
@settings(max_examples=20, deadline=None)
def test_the_amplitude_does_not_depend_on_when_the_record_starts(shift):
    signal = tone(123.0, 2000)
    _, plain = amplitude_spectrum(signal[:1000], rate_hz=RATE)
    _, later = amplitude_spectrum(signal[shift : shift + 1000], rate_hz=RATE)
    assert later == pytest.approx(plain, abs=1e-9)


def test_fewer_than_16_samples_are_refused_with_their_number():
    with pytest.raises(InvalidValueError, match=r"15 samples; allowed: 16 or more"):
        amplitude_spectrum(np.zeros(15), rate_hz=RATE)
    assert amplitude_spectrum(np.zeros(16), rate_hz=RATE)[1].max() == 0.0


def test_silence_has_no_lines():
    spectrum = spectrum_with_floor(np.full((2, 300), 4.2), rate_hz=RATE, floor_width_hz=20)
    # What rounding of the mean leaves must not pass for lines.
    assert spectrum.amplitude.max() < 1e-14


# --- noise floor ----------------------------------------------------------------------------------------------


def test_the_floor_of_white_noise_is_unbiased():
    """E amplitude^2 = 4 sigma^2 sum w^2 / (sum w)^2 = 6 sigma^2 / n; a median of m bins is 1/(2 m ln 2) too high."""
    samples, sigma = 20_000, 0.7
    rng = np.random.default_rng(4)
    ratios = []
    for _ in range(20):
        spectrum = spectrum_with_floor(rng.normal(0, sigma, samples), rate_hz=RATE, floor_width_hz=50)
        ratios.append((spectrum.floor[0, 20:-20] ** 2).mean() / (6 * sigma**2 / samples))
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.01)


def test_the_floor_follows_coloured_noise_in_every_tenth_of_the_band():
    """First-order autoregressive noise: density sigma^2 / |1 - a exp(-i w)|^2, here over 34 dB."""
    from scipy.signal import lfilter

    samples, pole = 40_000, 0.96
    rng = np.random.default_rng(5)
    total = 0.0
    for _ in range(20):
        noise = lfilter([1.0], [1.0, -pole], rng.normal(size=samples + 2000))[2000:]
        spectrum = spectrum_with_floor(noise, rate_hz=RATE, floor_width_hz=5)
        total = total + spectrum.floor[0] ** 2 / 20
    angle = 2 * np.pi * spectrum.frequency_hz / RATE
    truth = 6 / samples / np.abs(1 - pole * np.exp(-1j * angle)) ** 2
    ratio = total / truth
    for part in np.array_split(ratio[100:-100], 10):
        assert part.mean() == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("amplitude", [0.3, 3.0, 3000.0])
@pytest.mark.parametrize("every_bins", [30, 9])
def test_lines_lift_the_floor_by_no_more_than_a_median_must_however_strong(amplitude, every_bins):
    """A tone on a bin fills three bins. A share s of lines lifts the median power by -log2(1 - 0.5 / (1 - s))."""
    samples = 20_000
    rng = np.random.default_rng(6)
    share = 3 / every_bins
    ratios = []
    for _ in range(6):
        transform = np.zeros(samples // 2 + 1, dtype=complex)
        # Phases at random: lines this dense in phase would be a pulse train.
        bins = np.arange(100, samples // 2 - 100, every_bins)
        transform[bins] = samples / 2 * amplitude * np.exp(2j * np.pi * rng.random(bins.size))
        signal = rng.normal(size=samples) + np.fft.irfft(transform)
        spectrum = spectrum_with_floor(signal, rate_hz=RATE, floor_width_hz=50)
        ratios.append((spectrum.floor[0, 1500:-1500] ** 2).mean() / (6 / samples))
    assert np.mean(ratios) == pytest.approx(-math.log2(1 - 0.5 / (1 - share)), rel=0.03)


def test_one_strong_line_does_not_show_in_the_floor():
    noise = np.random.default_rng(7).normal(size=10_000)
    quiet = spectrum_with_floor(noise, rate_hz=RATE, floor_width_hz=30).floor[0]
    loud = spectrum_with_floor(noise + tone(200.03, 10_000, amplitude=30), rate_hz=RATE, floor_width_hz=30).floor[0]
    # Its foot, -18 dB an octave, lies over the noise for some 60 of the 300 bins around it.
    assert np.max(loud / quiet) < 1.2


@pytest.mark.parametrize("bins", [9, 10, 17, 40, 41])
def test_the_floor_of_a_very_short_spectrum_has_its_shape(bins):
    amplitude = np.random.default_rng(8).rayleigh(size=(3, bins))
    floor = noise_floor(amplitude, half_width_bins=500)
    assert floor.shape == (3, bins)
    assert np.isfinite(floor).all()
    assert (floor > 0).all()


# --- chance of noise ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("searched", [1, 3, 20])
def test_chance_of_noise_against_monte_carlo(searched):
    draws = 40_000
    highest = np.random.default_rng(9).exponential(size=(draws, searched)).max(axis=1)
    for ratio in (0.5, 2.0, 4.0, 6.0):
        expected = float(chance_of_noise(ratio, bins_searched=searched))
        scatter = math.sqrt(expected * (1 - expected) / draws)
        assert (highest > ratio).mean() == pytest.approx(expected, abs=4 * scatter)


def test_bins_of_real_spectra_exceed_a_ratio_as_often_as_stated():
    signals = np.random.default_rng(10).normal(size=(30, 20_000))
    spectrum = spectrum_with_floor(signals, rate_hz=RATE, floor_width_hz=200)
    ratios = spectrum.power_ratio[:, 10:-10]
    for ratio in (1.0, 3.0, 5.0):
        expected = float(chance_of_noise(ratio))
        # Under a Hann window a spectrum holds two independent values for every three bins.
        scatter = math.sqrt(expected / (ratios.size / 1.5))
        assert (ratios > ratio).mean() == pytest.approx(expected, abs=4 * scatter)


def test_chance_of_noise_at_its_ends():
    assert float(chance_of_noise(0.0)) == pytest.approx(1.0)
    assert float(chance_of_noise(700.0, bins_searched=100)) == pytest.approx(100 * math.exp(-700), rel=1e-9)
    assert float(chance_of_noise(1e6)) == 0.0
    assert chance_of_noise(np.array([1.0, 2.0]), bins_searched=np.array([1, 2])).shape == (2,)


@given(ratio=st.floats(0, 50), more=st.floats(0.01, 10), searched=st.integers(1, 1000))
def test_a_higher_line_is_less_likely_noise_and_a_wider_search_more(ratio, more, searched):
    one = float(chance_of_noise(ratio, bins_searched=searched))
    assert 0 <= float(chance_of_noise(ratio + more, bins_searched=searched)) <= one <= 1
    assert float(chance_of_noise(ratio, bins_searched=searched + 1)) >= one


# --- frequency against Cramer and Rao -------------------------------------------------------------------------


@pytest.mark.parametrize("power_ratio", [50.0, 500.0, 5000.0])
@pytest.mark.parametrize("samples", [2000, 2701])
def test_frequency_scatter_against_the_cramer_rao_bound(power_ratio, samples):
    """Rife and Boorstyn 1974: var f >= 6 sigma^2 / (pi^2 A^2 n T^2), 0.318 bins / sqrt(R) with R = A^2 n / 6 sigma^2.

    The Hann window with two-bin interpolation loses a factor of 1.4 to 1.9 against it, never more.
    """
    rng = np.random.default_rng([11, samples])
    sigma = math.sqrt(samples / 6 / power_ratio)
    errors = []
    for _ in range(600):
        frequency = rng.uniform(0.1, 0.4) * RATE
        signal = tone(frequency, samples, phase=rng.uniform(0, 6)) + rng.normal(0, sigma, samples)
        spectrum = spectrum_with_floor(signal, rate_hz=RATE, floor_width_hz=100)
        found, _, _ = peak_near(spectrum, 0, frequency, tolerance_hz=2 * RATE / samples)
        errors.append((found - frequency) * samples / RATE)
    bound = 1 / (math.pi * math.sqrt(power_ratio))
    assert abs(np.mean(errors)) < 4 * np.std(errors) / math.sqrt(600)
    # 600 draws scatter the deviation by 3 %.
    assert 1.0 < np.std(errors) / bound < 1.9


# --- lengths, window, density ---------------------------------------------------------------------------------


def smooth_numbers(highest: int) -> list[int]:
    found = {1}
    for prime in (2, 3, 5):
        for number in list(found):
            while number * prime <= highest:
                number *= prime
                found.add(number)
    return sorted(found)


SMOOTH = smooth_numbers(1 << 24)


def test_fast_length_against_brute_force():
    assert [fast_length(n) for n in range(1, 3001)] == [SMOOTH[bisect.bisect_left(SMOOTH, n)] for n in range(1, 3001)]


@given(st.integers(1, 1 << 24))
def test_fast_length_against_the_list_of_smooth_numbers(samples):
    assert fast_length(samples) == SMOOTH[bisect.bisect_left(SMOOTH, samples)]


@given(st.integers(1, 1 << 24))
def test_the_largest_fast_length_within_against_the_list_of_smooth_numbers(samples):
    assert fast_length_within(samples) == SMOOTH[bisect.bisect_right(SMOOTH, samples) - 1]


@pytest.mark.parametrize("samples", [7, 8])
def test_the_window_is_a_periodic_hann(samples):
    window = hann(samples)
    assert window[0] == 0
    assert window.sum() == pytest.approx(samples / 2)
    assert (window**2).sum() == pytest.approx(3 * samples / 8)
    assert window[1:] == pytest.approx(window[1:][::-1])


@pytest.mark.parametrize("segment", [512, 513])
def test_density_of_white_noise_and_its_integral(segment):
    signals = np.random.default_rng(12).normal(0, [[2.0], [0.1]], (2, 200_000))
    frequency, density = averaged_power_density(signals, rate_hz=RATE, segment_samples=segment)
    inner = density[:, 5:-5]
    assert inner.mean(axis=1) == pytest.approx(np.array([4.0, 0.01]) * 2 / RATE, rel=0.01)
    assert inner.sum(axis=1) * frequency[1] == pytest.approx(
        signals.var(axis=1) * inner.shape[1] / (segment / 2), rel=0.02
    )


def test_density_of_a_tone_integrates_to_its_mean_square():
    frequency, density = averaged_power_density(tone(100, 5000, amplitude=3.0), rate_hz=RATE, segment_samples=500)
    assert density.sum() * frequency[1] == pytest.approx(4.5, rel=1e-6)


def test_density_of_a_record_shorter_than_a_segment():
    frequency, density = averaged_power_density(tone(100, 100), rate_hz=RATE, segment_samples=500)
    assert frequency.size == density.shape[1] == 51
