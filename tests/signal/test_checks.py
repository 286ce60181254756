"""Data checks: every defect made on purpose is found, and sound signals raise nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal.checks import UNUSABLE, check_channel, repair

RATE = 10_000.0
SAMPLES = 20_000
TIME = np.arange(SAMPLES) / RATE


def codes(signal: np.ndarray) -> list[str]:
    return [check.code for check in check_channel(signal, rate_hz=RATE, name="drive end")]


def noise(seed: int = 0, samples: int = SAMPLES) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=samples)


def vibration(seed: int = 0) -> np.ndarray:
    """Shaft lines and noise."""
    return np.sin(2 * np.pi * 24.7 * TIME) + 0.4 * np.sin(2 * np.pi * 49.4 * TIME + 1) + 0.2 * noise(seed)


def bearing(seed: int = 0, *, resonance_hz: float = 2900.0) -> np.ndarray:
    """Impacts that ring a resonance, with slip and a kurtosis above 10."""
    rng = np.random.default_rng(seed)
    signal = 0.05 * rng.normal(size=SAMPLES)
    strikes = np.cumsum(rng.normal(1 / 40, 0.01 / 40, 75))
    for strike in strikes[strikes < TIME[-1] - 0.01]:
        first = int(strike * RATE) + 1
        after = TIME[first : first + 100] - strike
        signal[first : first + after.size] += np.exp(-after / 1e-3) * np.sin(2 * np.pi * resonance_hz * after)
    return signal


# --- defects made on purpose ----------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.01, 0.05, 0.4])
@pytest.mark.parametrize("sides", ["both", "upper", "lower"])
@pytest.mark.parametrize("offset", [0.0, -3.0])
def test_clipping_is_found(share, sides, offset):
    signal = vibration()
    low = np.quantile(signal, share) if sides != "upper" else -np.inf
    high = np.quantile(signal, 1 - share) if sides != "lower" else np.inf
    assert codes(np.clip(signal, low, high) + offset) == ["clipping"]


def test_clipping_of_a_clean_sine_and_of_impacts_is_found():
    assert codes(np.clip(np.sin(2 * np.pi * 24.7 * TIME), -0.9, 0.9)) == ["clipping"]
    assert "clipping" in codes(np.clip(bearing(), -0.3, 0.3))


def test_clipping_of_quantised_data_is_found():
    assert "clipping" in codes(np.clip(np.round(vibration() * 2000), -1800, 1800))


def test_the_clipped_share_is_stated():
    (found,) = check_channel(np.clip(np.sin(2 * np.pi * 24.7 * TIME), -2, 0.5), rate_hz=RATE, name="x")
    share = float(found.message.split("(")[1].split("%")[0])
    # A sine is above half its height for a third of the time; the last thousandth of the range counts as well.
    assert share == pytest.approx(100 / 3, abs=0.5)
    assert found.severity == 1.0


@pytest.mark.parametrize("level", [0.0, 0.123])
@pytest.mark.parametrize("stretches", [1, 5])
def test_dropouts_are_found(level, stretches):
    signal = vibration()
    for index in range(stretches):
        signal[3000 + 2500 * index : 3100 + 2500 * index] = level
    found = check_channel(signal, rate_hz=RATE, name="x")
    assert [check.code for check in found] == ["dropouts"]
    assert f"{stretches} dropouts, {stretches * 0.5:.1f}%" in found[0].message


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_missing_samples_are_found_and_counted(bad):
    signal = vibration()
    signal[::100] = bad
    found = check_channel(signal, rate_hz=RATE, name="x")
    assert [check.code for check in found] == ["missing samples"]
    assert "1.00%" in found[0].message


def test_a_channel_mostly_missing_is_unusable():
    signal = vibration()
    signal[::4] = np.nan
    assert codes(signal) == ["mostly missing"]
    assert "mostly missing" in UNUSABLE
    assert codes(np.full(1000, np.nan)) == ["mostly missing"]


@pytest.mark.parametrize("signal", [np.zeros(5000), np.full(5000, -2.5), np.array([]), np.array([1.0])])
def test_a_dead_channel_is_unusable(signal):
    assert codes(signal) == ["dead"]
    assert "dead" in UNUSABLE


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_large_offset_is_noted_and_harms_nothing(sign):
    (found,) = check_channel(vibration() + sign * 30, rate_hz=RATE, name="x")
    assert (found.code, found.severity) == ("offset", 0.0)


@pytest.mark.parametrize("kind", ["ramp", "step", "slow swing"])
def test_a_drifting_mean_is_found(kind):
    drift = {"ramp": TIME / TIME[-1], "step": TIME > 1.0, "slow swing": np.sin(2 * np.pi * 0.3 * TIME)}[kind]
    assert codes(vibration() + 12 * drift) == ["drift"]


@pytest.mark.parametrize("step", [1.0, 2.0])
def test_coarse_steps_are_found(step):
    assert "coarse" in codes(np.round(noise() / step) * step)


def test_folded_content_is_found():
    """Twice the rate, resonance at 1.1 of the new band's end, every other sample taken: it folds to 0.9 to 1.0."""
    from scipy.signal import butter, sosfilt

    fast = noise(1, 2 * SAMPLES)
    band = butter(4, [4600, 6200], "bandpass", fs=2 * RATE, output="sos")
    folded = (0.1 * fast + sosfilt(band, fast))[::2]
    assert codes(folded) == ["aliasing"]


@pytest.mark.parametrize("level", [1e-6, 1e3])
def test_defects_are_found_in_any_unit(level):
    assert codes(level * np.clip(vibration(), -0.9, 0.9)) == ["clipping"]
    signal = vibration()
    signal[5000:5200] = 0.1
    assert codes(level * signal) == ["dropouts"]


def test_the_message_names_the_channel():
    assert check_channel(np.zeros(100), rate_hz=RATE, name="drive end")[0].message.startswith("drive end: ")


# --- sound signals raise nothing ------------------------------------------------------------------------------


@given(
    amplitude=st.floats(1e-9, 1e9),
    offset=st.floats(-10, 10),
    samples_per_period=st.one_of(
        st.floats(2.05, 1000), st.sampled_from([2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 16.0, 20.0, 25.0, 100.0])
    ),
    turn=st.one_of(st.floats(0, 1), st.sampled_from([0.0, 0.125, 0.25])),
)
@settings(max_examples=150, deadline=None)
def test_clean_sines_raise_nothing(amplitude, offset, samples_per_period, turn):
    wave = np.sin(2 * np.pi * (np.arange(SAMPLES) / samples_per_period + turn))
    assert codes(amplitude * (wave + offset)) == []


@given(
    steps=st.sampled_from([50, 500, 10_000, 1 << 22]),
    samples_per_period=st.one_of(st.floats(2.05, 400), st.sampled_from([3.0, 4.0, 5.0, 8.0, 10.0, 20.0])),
    turn=st.sampled_from([0.0, 0.125, 0.3]),
    seed=st.integers(0, 100),
)
@settings(max_examples=60, deadline=None)
@example(steps=500, samples_per_period=50.0, turn=0.0, seed=3)
@example(steps=1 << 22, samples_per_period=3.578125, turn=0.0, seed=0)
def test_sines_from_a_converter_raise_nothing(steps, samples_per_period, turn, seed):
    """Rounded to whole steps, with half a step of noise as every converter has."""
    wave = steps * np.sin(2 * np.pi * (np.arange(SAMPLES) / samples_per_period + turn)) + 0.5 * noise(seed)
    assert codes(np.round(wave)) == []


@given(
    samples_per_period=st.sampled_from([2.5, 3.0, 4.0, 5.0, 8.0, 10.0, 20.0]), turn=st.sampled_from([0.0, 0.125, 0.3])
)
@settings(max_examples=21, deadline=None)
def test_a_rounded_tone_locked_to_the_rate_raises_nothing(samples_per_period, turn):
    assert codes(np.round(1000 * np.sin(2 * np.pi * (np.arange(SAMPLES) / samples_per_period + turn)))) == []


@given(seed=st.integers(0, 10_000), samples=st.sampled_from([200, 1000, 4096, 20_000]), scale=st.floats(1e-6, 1e6))
@settings(max_examples=40, deadline=None)
def test_noise_raises_nothing(seed, samples, scale):
    assert codes(scale * noise(seed, samples)) == []
    assert codes(scale * np.random.default_rng(seed).uniform(-1, 1, samples)) == []


@given(seed=st.integers(0, 10_000), resonance=st.floats(500, 4000))
@settings(max_examples=30, deadline=None)
def test_impulsive_bearing_signals_raise_nothing(seed, resonance):
    assert codes(bearing(seed, resonance_hz=resonance)) == []
    assert codes(vibration(seed) + bearing(seed, resonance_hz=resonance)) == []


@pytest.mark.parametrize("steps", [300, 3000, 30_000])
def test_a_slow_sine_in_steps_rests_at_its_turning_points_and_has_no_dropouts(steps):
    assert codes(np.round(steps * np.sin(2 * np.pi * np.arange(400_000) / 20_000))) == []


def test_sixteen_bit_noise_of_a_few_steps_raises_nothing():
    assert codes(np.round(5 * noise(3, 200_000))) == []


# --- repair ---------------------------------------------------------------------------------------------------


def test_repair_joins_by_straight_lines_and_holds_the_ends():
    signal = np.array([np.nan, 1.0, np.nan, np.nan, 4.0, np.inf])
    assert repair(signal).tolist() == [1.0, 1.0, 2.0, 3.0, 4.0, 4.0]


def test_repair_of_a_channel_without_any_sample_is_a_dead_one():
    assert repair(np.full(3, np.nan)).tolist() == [0.0, 0.0, 0.0]


def test_repair_leaves_a_whole_signal_alone():
    signal = vibration()
    assert repair(signal) is signal
