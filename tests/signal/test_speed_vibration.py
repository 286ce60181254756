"""Speed from vibration alone: combs, intruders, hints, honest confidence and intervals. All sets are seeded."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.result import SpeedEstimate
from rotorwise.diagnose.signal.spectrum import spectrum_with_floor
from rotorwise.diagnose.signal.speed import speed_from_vibration
from rotorwise.diagnose.signal.speed_peaks import find_peaks

RATE = 10_000.0
TIME = np.arange(40_000) / RATE
RIGHT = 5e-3  # a speed within 0.5 % is the right line; its neighbours are other orders or other machines


def comb(speed_hz: float, heights, *, noise: float = 0.3, seed: int = 0, time: np.ndarray = TIME) -> np.ndarray:
    """Lines at 1X, 2X, ... of these heights, random phases, and white noise."""
    rng = np.random.default_rng(seed)
    lines = [a * np.sin(2 * np.pi * (n * speed_hz * time + rng.random())) for n, a in enumerate(heights, 1)]
    return np.sum(lines, axis=0) + rng.normal(0, noise, time.size)


def estimated(signals: np.ndarray, **options) -> SpeedEstimate:
    found = speed_from_vibration(signals, rate_hz=RATE, **options)
    assert found is not None
    return found


def random_comb(rng: np.random.Generator, *, low_hz: float = 5.0, high_hz: float = 200.0):
    """Draw a machine: 3 to 10 harmonics, some missing, 1X weak in one of five; mains in half; up to 3 stray lines.

    The strongest line stands 15 to 45 dB over the mean noise power of its bin. Returns signal, rate and speed.
    """
    rate = float(rng.choice([5120.0, 10_240.0, 12_800.0, 20_000.0]))
    time = np.arange(int(rate * rng.uniform(2, 6))) / rate
    speed = math.exp(rng.uniform(math.log(low_hz), math.log(high_hz)))
    count = int(rng.integers(3, 11))
    heights = np.exp(rng.normal(0, 0.8, count)) / np.arange(1, count + 1) ** rng.uniform(0, 1)
    heights[0] *= 0.05 if rng.random() < 0.2 else 1.0
    shown = rng.random(count) < 0.85
    heights *= shown if shown.sum() >= 2 else 1.0
    lines = [(n * speed, a) for n, a in enumerate(heights, 1) if n * speed < 0.45 * rate]
    if rng.random() < 0.5:
        mains = float(rng.choice([50.0, 60.0]))
        lines += [(mains, rng.uniform(0.1, 1)), (2 * mains, rng.uniform(0.1, 1))]
    lines += [(rng.uniform(20, 0.3 * rate), rng.uniform(0.05, 0.6)) for _ in range(rng.integers(0, 4))]
    signal = sum(a * np.sin(2 * np.pi * (f * time + rng.random())) for f, a in lines)
    sigma = max(a for _, a in lines[:count]) / 10 ** (rng.uniform(15, 45) / 20) * math.sqrt(time.size / 6)
    return signal + rng.normal(0, sigma, time.size), rate, speed


# --- single cases ---------------------------------------------------------------------------------------------

COMBS = {
    "falling": [1, 0.5, 0.3, 0.2],
    "weak 1X": [0.02, 1, 0.6, 0.5, 0.4],
    "no 1X": [0, 1, 0.7, 0.5, 0.4, 0.3],
    "no 2X": [1, 0, 0.5, 0.4, 0.3],
    "odd ones": [1, 0, 0.8, 0, 0.6, 0, 0.4],
    "many": [0.3] * 12,
}


@pytest.mark.parametrize("name", COMBS)
@pytest.mark.parametrize("speed", [12.3, 24.71, 48.4])
def test_combs_near_a_hint(name, speed):
    found = estimated(comb(speed, COMBS[name]), hint_hz=0.97 * speed)
    assert found.speed_hz == pytest.approx(speed, rel=2e-4)
    assert found.low_hz <= speed <= found.high_hz
    assert found.confidence > 0.8
    assert found.method == "vibration near the hint"


@pytest.mark.parametrize("name", COMBS)
@pytest.mark.parametrize("speed", [14.3, 24.71, 48.4])
def test_combs_without_a_hint(name, speed):
    found = estimated(comb(speed, COMBS[name]))
    assert found.speed_hz == pytest.approx(speed, rel=2e-4)
    assert found.low_hz <= speed <= found.high_hz
    assert found.method == "vibration"


@pytest.mark.parametrize("error", [-0.07, -0.04, 0.04, 0.07])
def test_a_hint_off_by_up_to_7_percent(error):
    found = estimated(comb(24.71, COMBS["falling"]), hint_hz=24.71 * (1 + error))
    assert found.speed_hz == pytest.approx(24.71, rel=2e-4)


@pytest.mark.parametrize("mains", [50.0, 100.0])
@pytest.mark.parametrize("slip", [0.003, 0.02, -0.02])
def test_strong_mains_beside_an_order(mains, slip):
    """A mains line ten times as strong as any order, beside 2X or 4X of a shaft near 25 Hz."""
    speed = 25 * (1 - slip)
    signal = comb(speed, COMBS["falling"]) + 10 * np.sin(2 * np.pi * mains * TIME)
    found = estimated(signal, hint_hz=25.0)
    assert found.speed_hz == pytest.approx(speed, rel=5e-4)


@pytest.mark.parametrize("order", [3.05, 4.95])
@pytest.mark.parametrize("slip", [0.0, 0.01])
@pytest.mark.parametrize("hint", [None, 24.0])
def test_a_bearing_comb_stronger_than_the_shaft_with_its_orders_known(order, slip, hint):
    speed = 24.71
    bearing = comb(speed * order * (1 - slip), [3, 2.5, 2, 1.5, 1, 0.8], seed=1)
    found = estimated(comb(speed, COMBS["falling"]) + bearing, hint_hz=hint, bearing_orders=(3.05, 4.95))
    assert found.speed_hz == pytest.approx(speed, rel=1e-3)


def test_a_mesh_line_sharpens_the_speed():
    signal = comb(24.71, COMBS["falling"]) + np.sin(2 * np.pi * 23 * 24.71 * TIME)
    plain = estimated(signal, hint_hz=25.0)
    sharp = estimated(signal, hint_hz=25.0, known_orders=(23.0,))
    assert sharp.speed_hz == pytest.approx(24.71, rel=5e-5)
    assert sharp.high_hz - sharp.low_hz < plain.high_hz - plain.low_hz


def test_the_best_channel_counts():
    quiet = np.random.default_rng(2).normal(size=(2, TIME.size))
    signals = np.vstack([quiet, comb(24.71, COMBS["falling"])])
    assert estimated(signals, hint_hz=25.0).speed_hz == pytest.approx(24.71, rel=2e-4)


@given(gain=st.floats(1e-9, 1e9), order=st.permutations(range(3)))
@settings(max_examples=10, deadline=None)
def test_gain_and_channel_order_do_not_matter(gain, order):
    signals = np.stack([comb(24.71, COMBS[name], seed=7) for name in ("falling", "no 1X", "many")])
    plain, other = estimated(signals, hint_hz=25.0), estimated(gain * signals[list(order)], hint_hz=25.0)
    assert other.speed_hz == pytest.approx(plain.speed_hz, rel=1e-9)
    assert other.confidence == pytest.approx(plain.confidence, rel=1e-6)


# --- no shaft -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("hint", [None, 25.0])
def test_pure_noise_gives_none_or_little_confidence(hint):
    confidences = []
    for seed in range(80):
        rng = np.random.default_rng([3, seed])
        signals = rng.normal(size=(int(rng.integers(1, 4)), int(rng.integers(8000, 60_000))))
        found = speed_from_vibration(signals, rate_hz=RATE, hint_hz=hint)
        confidences.append(0.0 if found is None else found.confidence)
    assert max(confidences) <= 0.5
    assert np.mean(np.array(confidences) == 0.0) > 0.5


def test_unrelated_lines_are_rarely_taken_for_a_shaft():
    confidences = []
    for seed in range(80):
        rng = np.random.default_rng([4, seed])
        lines = [(rng.uniform(5, 2000), rng.uniform(0.1, 1)) for _ in range(rng.integers(1, 12))]
        signal = sum(a * np.sin(2 * np.pi * (f * TIME + rng.random())) for f, a in lines)
        found = speed_from_vibration(signal + rng.normal(0, 0.3, TIME.size), rate_hz=RATE)
        confidences.append(0.0 if found is None else found.confidence)
    assert np.mean(np.array(confidences) > 0.7) < 0.05


@pytest.mark.parametrize("signals", [np.zeros((1, 5000)), np.zeros((2, 16))])
def test_silence_gives_none(signals):
    assert speed_from_vibration(signals, rate_hz=RATE) is None


def test_a_hint_beyond_the_band_gives_none():
    assert speed_from_vibration(comb(24.71, [1.0]), rate_hz=RATE, hint_hz=4900.0) is None


# --- honest statements ----------------------------------------------------------------------------------------


def study(cases: int, seed: int, *, hint_error: float | None = None) -> np.ndarray:
    """Return one row a case: confidence, whether the speed is right, whether the interval holds the true speed."""
    rows = []
    for case in range(cases):
        rng = np.random.default_rng([seed, case])
        signal, rate, speed = random_comb(rng)
        hint = None if hint_error is None else speed * (1 + rng.uniform(-hint_error, hint_error))
        found = speed_from_vibration(signal, rate_hz=rate, hint_hz=hint, lowest_hz=4, highest_hz=250)
        if found is not None:
            right = abs(found.speed_hz / speed - 1) < RIGHT
            rows.append((found.confidence, right, found.low_hz <= speed <= found.high_hz))
    assert len(rows) > 0.95 * cases
    return np.array(rows, dtype=float)


def assert_honest(rows: np.ndarray) -> None:
    """In no group of stated confidence may the share right lie below it by more than three binomial deviations."""
    edges = [0.0, 0.3, 0.6, 0.8, 0.9, 0.97, 1.01]
    for low, high in itertools.pairwise(edges):
        group = rows[(rows[:, 0] >= low) & (rows[:, 0] < high)]
        if group.size:
            stated = group[:, 0].mean()
            scatter = math.sqrt((group[:, 0] * (1 - group[:, 0])).sum()) / len(group)
            assert group[:, 1].mean() >= stated - 3 * scatter, f"{low}-{high}: {len(group)} cases, stated {stated:.3f}"


@pytest.fixture(scope="module")
def without_hint() -> np.ndarray:
    return study(200, 21)


@pytest.fixture(scope="module")
def with_hint() -> np.ndarray:
    return study(120, 22, hint_error=0.07)


def test_random_combs_from_5_to_200_hz_without_a_hint(without_hint):
    assert without_hint[:, 1].mean() > 0.8


def test_random_combs_with_a_hint_up_to_7_percent_off(with_hint):
    assert with_hint[:, 1].mean() > 0.95


def test_the_stated_confidence_is_honest(without_hint, with_hint):
    assert_honest(without_hint)
    assert_honest(with_hint)


def test_confidence_tells_right_from_wrong(without_hint):
    right = without_hint[:, 1] == 1
    assert without_hint[right, 0].mean() > without_hint[~right, 0].mean() + 0.15


def test_intervals_hold_the_speed_in_nine_cases_out_of_ten(without_hint, with_hint):
    for rows in (without_hint, with_hint):
        right = rows[rows[:, 1] == 1]
        assert right[:, 2].mean() >= 0.9


def test_stated_deviations_of_peaks_hold():
    """Interpolated tones in noise: at least 90 % within two stated deviations, and these not wide for nothing."""
    rng = np.random.default_rng(23)
    scores = []
    for _ in range(300):
        frequency = rng.uniform(100, 2000)
        signal = comb(frequency, [rng.uniform(0.05, 0.5)], noise=1.0, seed=int(rng.integers(1 << 30)))
        peaks = find_peaks(spectrum_with_floor(signal, rate_hz=RATE, floor_width_hz=20), 0, highest_hz=2500)
        if peaks.frequency_hz.size:
            nearest = int(np.abs(peaks.frequency_hz - frequency).argmin())
            scores.append((peaks.frequency_hz[nearest] - frequency) / peaks.deviation_hz[nearest])
    scores = np.array(scores)[np.abs(scores) < 20]
    assert scores.size > 200
    assert np.mean(np.abs(scores) < 2) > 0.9
    assert scores.std() > 0.4


def test_lines_of_a_bearing_beside_whole_orders_do_not_pull_the_speed():
    """An inner race's lines at 0.9933 of 5X to 8X: 1X is the clearest line, and right to a small part of one."""
    rate, speed = 2000.0, 18.31
    t = np.arange(int(5 * rate)) / rate
    lines = {1.0: 0.1, 4.9665: 0.01, 5.9598: 0.02, 6.9531: 0.01, 7.9464: 0.01}
    signal = sum(size * np.sin(2 * np.pi * order * speed * t + order) for order, size in lines.items())
    noise = np.random.default_rng(3).normal(0.0, 0.05, (2, t.size))
    found = speed_from_vibration(signal + noise, rate_hz=rate, hint_hz=1100 / 60)
    assert found is not None
    assert found.speed_hz == pytest.approx(speed, rel=1e-3)
