"""Integration against closed forms: theory first, then properties."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal import integrate
from rotorwise.diagnose.signal.integrate import (
    averaged_power,
    band_displacement,
    band_displacement_rms,
    band_gain,
    band_rms,
    band_signal,
    band_velocity,
    band_velocity_rms,
)
from rotorwise.simulators.errors import InvalidValueError

RATE = 8192.0
BAND = {"low_hz": 10.0, "high_hz": 1000.0}


def gain(frequency):
    """ISO 2954 band written out a second way, as the product of two analogue Butterworth magnitudes."""
    low = (frequency / 10.0) ** 3 / math.sqrt(1 + (frequency / 10.0) ** 6)
    return low / math.sqrt(1 + (frequency / 1000.0) ** 6)


def acceleration(frequency, seconds=8.0, velocity=5e-3, rate=RATE, phase=0.4):
    """Acceleration in m/s2 of a sine with this velocity amplitude in m/s."""
    time = np.arange(round(seconds * rate)) / rate
    return velocity * 2 * np.pi * frequency * np.cos(2 * np.pi * frequency * time + phase)


@pytest.mark.parametrize("frequency", [12.0, 24.83, 25.0, 49.71, 99.9, 333.37, 700.0])
def test_velocity_rms_of_a_sine(frequency):
    got = band_velocity_rms(acceleration(frequency), rate_hz=RATE, quantity="acceleration", **BAND)
    assert got == pytest.approx([5e-3 / math.sqrt(2) * gain(frequency)], rel=2e-3)


@pytest.mark.parametrize("frequency", [15.3, 50.0, 120.7])
def test_displacement_rms_of_a_sine(frequency):
    got = band_displacement_rms(acceleration(frequency), rate_hz=RATE, quantity="acceleration", **BAND)
    expected = 5e-3 / (2 * np.pi * frequency) / math.sqrt(2) * gain(frequency)
    assert got == pytest.approx([expected], rel=3e-3)


@pytest.mark.parametrize(("edge", "rate"), [(10.0, 8192.0), (1000.0, 8192.0), (1000.0, 51200.0)])
def test_edges_are_3_db_down(edge, rate):
    got = band_velocity_rms(acceleration(edge, rate=rate), rate_hz=rate, quantity="acceleration", **BAND)
    assert 20 * math.log10(got[0] / (5e-3 / math.sqrt(2))) == pytest.approx(-3.0103, abs=0.02)


def test_third_order_slope_is_18_db_an_octave_below_the_band():
    got = band_gain(np.array([0.5, 1.0]), **BAND)
    assert 20 * math.log10(got[1] / got[0]) == pytest.approx(18.06, abs=0.01)


def test_lower_edge_at_2_hz():
    signal = acceleration(4.0, seconds=32.0)
    slow = band_velocity_rms(signal, rate_hz=RATE, quantity="acceleration", low_hz=2.0, high_hz=1000.0)
    fast = band_velocity_rms(signal, rate_hz=RATE, quantity="acceleration", **BAND)
    assert slow[0] == pytest.approx(5e-3 / math.sqrt(2) / math.sqrt(1 + 0.5**6), rel=2e-3)
    assert fast[0] == pytest.approx(5e-3 / math.sqrt(2) * gain(4.0), rel=0.02)


def test_two_tones_add_in_power():
    signal = acceleration(31.7) + acceleration(210.3, velocity=2e-3, phase=1.0)
    expected = math.hypot(5e-3 * gain(31.7), 2e-3 * gain(210.3)) / math.sqrt(2)
    got = band_velocity_rms(signal, rate_hz=RATE, quantity="acceleration", **BAND)
    assert got == pytest.approx([expected], rel=2e-3)


@pytest.mark.parametrize("quantity", ["acceleration", "velocity"])
def test_offset_and_drift_do_not_count(quantity):
    clean = acceleration(47.3)
    drift = 9.80665 + np.linspace(0, 5, clean.size) + 0.3 * np.sin(2 * np.pi * 0.05 * np.arange(clean.size) / RATE)
    for road in (band_velocity_rms, band_displacement_rms):
        pure = road(clean, rate_hz=RATE, quantity=quantity, **BAND)
        assert road(clean + drift, rate_hz=RATE, quantity=quantity, **BAND) == pytest.approx(pure, rel=2e-3)


def test_offset_alone_gives_next_to_nothing():
    signal = np.full(65536, 9.80665)
    assert band_velocity_rms(signal, rate_hz=RATE, quantity="acceleration", **BAND)[0] < 1e-12


def test_strong_high_frequency_does_not_leak_below():
    # 100 m/s2 at 3.7 kHz is 4.3 mm/s before the upper edge and 0.083 mm/s after it.
    signal = acceleration(3700.3, velocity=100 / (2 * np.pi * 3700.3))
    expected = 100 / (2 * np.pi * 3700.3) / math.sqrt(2) * gain(3700.3)
    assert band_velocity_rms(signal, rate_hz=RATE, quantity="acceleration", **BAND)[0] == pytest.approx(
        expected, rel=5e-3
    )


def test_waveform_follows_the_closed_form_away_from_the_ends():
    frequency, time = 53.17, np.arange(65536) / RATE
    got = band_velocity(acceleration(frequency), rate_hz=RATE, quantity="acceleration", **BAND)
    expected = 5e-3 * gain(frequency) * np.sin(2 * np.pi * frequency * time + 0.4)
    assert got.shape == time.shape
    inside = slice(round(0.3 * RATE), -round(0.3 * RATE))
    assert np.max(np.abs(got - expected)[inside]) < 0.003 * 5e-3


@pytest.mark.parametrize("frequency", [15.0, 53.17, 200.0])
@pytest.mark.parametrize("road", [band_velocity, band_displacement])
def test_ends_never_exceed_the_signal(frequency, road):
    got = road(acceleration(frequency), rate_hz=RATE, quantity="acceleration", **BAND)
    true = 5e-3 / (1 if road is band_velocity else 2 * np.pi * frequency)
    assert np.max(np.abs(got)) < 1.05 * true


def test_displacement_waveform_from_velocity_and_back():
    frequency, time = 41.9, np.arange(65536) / RATE
    displacement = 20e-6 * np.sin(2 * np.pi * frequency * time)
    velocity = 20e-6 * 2 * np.pi * frequency * np.cos(2 * np.pi * frequency * time)
    inside = slice(4000, -4000)
    down = band_displacement(velocity, rate_hz=RATE, quantity="velocity", **BAND)
    up = band_velocity(displacement, rate_hz=RATE, quantity="displacement", **BAND)
    assert np.max(np.abs(down - gain(frequency) * displacement)[inside]) < 0.01 * 20e-6
    assert np.max(np.abs(up - gain(frequency) * velocity)[inside]) < 0.01 * np.max(velocity)


def test_blocks_give_what_one_block_gives(monkeypatch):
    rng = np.random.default_rng(5)
    signal = rng.standard_normal((2, 200_000)) + 0.2 * acceleration(38.3, seconds=200_000 / 2048, rate=2048.0)
    options = {"rate_hz": 2048.0, "quantity": "acceleration", "low_hz": 10.0, "high_hz": 800.0}
    for road in (band_velocity, band_displacement):
        whole = road(signal, **options)
        monkeypatch.setattr(integrate, "_BLOCK_SAMPLES", 4096)
        pieces = road(signal, **options)
        monkeypatch.undo()
        assert np.max(np.abs(pieces - whole)) < 5e-3 * np.std(whole)


def test_rms_of_spectrum_agrees_with_rms_of_waveform():
    rng = np.random.default_rng(11)
    signal = rng.standard_normal((3, 400_000)) * np.array([[1.0], [4.0], [0.1]])
    options = {"rate_hz": 5000.0, "quantity": "acceleration", **BAND}
    wave = band_velocity(signal, **options)[:, 5000:-5000]
    assert band_velocity_rms(signal, **options) == pytest.approx(np.sqrt(np.mean(wave**2, axis=1)), rel=0.02)


def test_gap_costs_its_segment_only():
    signal = acceleration(50.3, seconds=60.0, rate=2560.0)
    signal[[5000, 5001, 5002]] = np.nan, np.inf, -np.inf
    got = band_velocity_rms(signal, rate_hz=2560.0, quantity="acceleration", low_hz=10.0, high_hz=math.inf)
    assert got[0] == pytest.approx(5e-3 / math.sqrt(2), rel=2e-3)
    nothing = band_velocity_rms(signal * np.nan, rate_hz=2560.0, quantity="acceleration", low_hz=10.0, high_hz=1000.0)
    assert np.isnan(nothing[0])


def test_integer_samples_are_taken_as_numbers():
    signal = np.round(1000 * acceleration(50.0)).astype(np.int16)
    got = band_velocity_rms(signal, rate_hz=RATE, quantity="acceleration", **BAND)
    assert got[0] / 1000 == pytest.approx(5e-3 / math.sqrt(2), rel=2e-3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"quantity": "voltage"}, "voltage"),
        ({"target": "jerk"}, "jerk"),
        ({"rate_hz": 0.0}, "Sampling rate 0.0"),
        ({"low_hz": 0.0}, "Band 0.0"),
        ({"low_hz": 2000.0}, "Band 2000.0"),
        ({"rate_hz": 15.0}, "below half the rate"),
    ],
)
def test_refusals_name_the_value(change, said):
    options = {"rate_hz": RATE, "quantity": "acceleration", "target": "velocity", **BAND, **change}
    for road in (band_rms, band_signal):
        with pytest.raises(InvalidValueError, match=said):
            road(np.zeros(4096), **options)


def test_handful_of_samples_is_refused():
    with pytest.raises(InvalidValueError, match="Record of 5 samples"):
        band_velocity_rms(np.zeros(5), rate_hz=RATE, quantity="acceleration", **BAND)


seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=25, deadline=None)
@given(seed=seeds, first=st.floats(-100, 100), second=st.floats(-100, 100))
def test_waveform_is_linear(seed, first, second):
    one, two = np.random.default_rng(seed).standard_normal((2, 3000))
    options = {"rate_hz": 2000.0, "quantity": "acceleration", "low_hz": 10.0, "high_hz": 900.0}
    together = band_velocity(first * one + second * two, **options)
    apart = first * band_velocity(one, **options) + second * band_velocity(two, **options)
    assert np.allclose(together, apart, rtol=0, atol=1e-10 * (1 + abs(first) + abs(second)))


@settings(max_examples=25, deadline=None)
@given(seed=seeds, scale=st.floats(1e-6, 1e6), offset=st.floats(-1e3, 1e3))
def test_rms_scales_and_ignores_the_offset(seed, scale, offset):
    signal = np.random.default_rng(seed).standard_normal(3000)
    options = {"rate_hz": 2000.0, "quantity": "acceleration", "low_hz": 10.0, "high_hz": 900.0}
    plain = band_velocity_rms(signal, **options)
    assert band_velocity_rms(scale * (signal + offset), **options) == pytest.approx(scale * plain, rel=1e-9)


@settings(max_examples=50, deadline=None)
@given(frequency=st.floats(0, 1e5), low=st.floats(0.1, 100), width=st.floats(1.1, 1e4))
def test_gain_is_between_0_and_1(frequency, low, width):
    value = band_gain(np.array([frequency]), low_hz=low, high_hz=low * width)[0]
    assert 0.0 <= value <= 1.0


@settings(max_examples=25, deadline=None)
@given(seed=seeds, samples=st.integers(8, 5000))
def test_bins_of_one_segment_add_up_to_the_windowed_mean_square(seed, samples):
    signal = np.random.default_rng(seed).standard_normal(samples)
    frequency, power = averaged_power(signal, rate_hz=1000.0, low_hz=1.0)
    window = np.sin(np.pi * (np.arange(samples) + 0.5) / samples) ** 2
    line = np.polynomial.Polynomial.fit(np.arange(samples), signal, 1)(np.arange(samples))
    expected = np.sum((window * (signal - line)) ** 2) / np.sum(window**2)
    assert power.shape == (1, frequency.size)
    assert power.sum() == pytest.approx(expected, rel=1e-9)
