"""Lost samples are put back: lines of a record with gaps, or cut off, are those of the whole record again."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.datasets.recording import Channel, Recording
from rotorwise.diagnose.gap.lost_samples import LEFT, lost_samples, mended
from rotorwise.diagnose.gap.observe import observe_orders

SAMPLES, RATE_HZ, SPEED_HZ, NOISE = 12_000, 2000.0, 23.0, 1e-3
LINES = {1.0: 1.0, 2.0: 0.3j, 3.0: 0.1 - 0.05j, 0.5: 0.05}
TURNS = SPEED_HZ * np.arange(SAMPLES) / RATE_HZ


def _whole(seed: int = 1, deviation: float = NOISE) -> np.ndarray:
    noise = deviation * np.random.default_rng(seed).normal(size=SAMPLES)
    return noise + sum((line * np.exp(2j * np.pi * order * TURNS)).real for order, line in LINES.items())


def _recording(signal: np.ndarray) -> Recording:
    pulses = (TURNS % 1.0 < 0.1).astype(float)
    channels = (Channel("a", "displacement"), Channel("tacho", "tacho"))
    signals = np.stack([signal, pulses])
    return Recording(signals, RATE_HZ, channels)


def _held(signal: np.ndarray, share: float) -> np.ndarray:
    found, length = signal.copy(), 16
    for start in range(50, SAMPLES - length, round(length / share)):
        found[start : start + length] = found[start]
    return found


def _missing(signal: np.ndarray, share: float) -> np.ndarray:
    found = signal.copy()
    found[np.random.default_rng(2).random(SAMPLES) < share] = np.nan
    return found


def _cut(signal: np.ndarray, share: float) -> np.ndarray:
    return np.minimum(signal, np.quantile(signal, 1 - share))


def _lines(recording: Recording) -> np.ndarray:
    (found,) = observe_orders((recording,), orders=tuple(LINES), channels={"a": "a"})
    return found.amplitudes[0, 0]


@pytest.mark.parametrize(
    ("damage", "share"), [(_held, 0.05), (_held, 0.2), (_missing, 0.1), (_cut, 0.05), (_cut, 0.15), (_cut, 0.25)]
)
def test_the_lines_are_those_of_the_whole_record(damage, share):
    whole, damaged = _recording(_whole()), _recording(damage(_whole(), share))
    found = mended([damaged], {"a"})
    assert found is not None
    raw = _lines(_recording(np.nan_to_num(damaged.signals[0])))
    wrong_before, wrong = (np.abs(lines - _lines(whole)).max() for lines in (raw, _lines(found[0])))
    assert wrong < LEFT * wrong_before
    assert wrong < 0.05 * share / 0.25


@pytest.mark.parametrize("share", [0.05, 0.15, 0.25])
@pytest.mark.parametrize(("ends", "left"), [(1, 0.35), (2, 0.15)])
def test_noise_that_decides_what_is_cut_off_does_not_make_the_lines_too_small(share, ends, left):
    sound = _whole(deviation=0.03)
    high, low = np.quantile(sound, [1 - share / ends, share / ends if ends == 2 else 0.0])
    found = mended([_recording(np.clip(sound, low, high))], {"a"})
    assert found is not None
    wrong_before = np.abs(_lines(_recording(np.clip(sound, low, high))) - _lines(_recording(sound))).max()
    # A fit to the samples that are left, the censoring not thought of, leaves 0.4 to 1.0 of it.
    assert np.abs(_lines(found[0]) - _lines(_recording(sound))).max() < left * wrong_before


def test_a_record_without_noise_is_put_back_as_well():
    sound = _whole(deviation=0.0)
    found = mended([_recording(np.minimum(sound, 0.9))], {"a"})
    assert found is not None
    # A sampled tacho tells the angle to 2 % of a radian.
    np.testing.assert_allclose(found[0].signals[0], sound, atol=LEFT * (sound.max() - 0.9))


@pytest.mark.parametrize("share", [0.4, 1.1])
def test_where_too_much_is_lost_nothing_is_put_back(share):
    assert mended([_recording(_whole()), _recording(_missing(_whole(), share))], {"a"}) is None


@settings(max_examples=20, deadline=None)
@given(share=st.floats(0.01, 0.2), seed=st.integers(0, 100))
def test_what_was_recorded_stays_as_it_is(share, seed):
    damaged = _held(_whole(seed), share)
    found = mended([_recording(damaged)], {"a"})
    assert found is not None
    kept = ~lost_samples(damaged)
    np.testing.assert_array_equal(found[0].signals[0][kept], damaged[kept])
    np.testing.assert_array_equal(found[0].signals[1], _recording(damaged).signals[1])


def test_a_sound_record_has_lost_nothing():
    assert not lost_samples(_whole()).any()
