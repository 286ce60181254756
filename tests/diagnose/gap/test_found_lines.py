"""Lines beside those that are looked at anyway: found where they are, and none in noise."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.datasets.recording import Channel, Recording
from rotorwise.diagnose.gap.found_lines import found_lines
from rotorwise.diagnose.gap.lines import LineKind

RATE_HZ, SAMPLES = 1000.0, 6000
SPEEDS_HZ = (14.0, 19.3, 23.1, 31.7)
STATED = ((1.0, 2.0, 3.0, 0.0), (*(LineKind(),) * 3, LineKind(phase=False, frequency_hz=50.0)))
TIME = np.arange(SAMPLES) / RATE_HZ


def _record(speed_hz: float, seed: int, *further: tuple[float, float], wander: float = 0.0) -> Recording:
    """Return shaft lines in noise, with further sines of (frequency, amplitude)."""
    generator = np.random.default_rng(seed)
    turns = speed_hz * (TIME + wander * np.sin(2 * np.pi * 0.4 * TIME) / (2 * np.pi * 0.4))
    vibration = np.cos(2 * np.pi * turns) + 0.2 * np.cos(4 * np.pi * turns) + 0.05 * np.cos(2 * np.pi * 50 * TIME)
    for frequency, amplitude in further:
        vibration += amplitude * np.cos(2 * np.pi * frequency * TIME + generator.uniform(0, 6))
    signals = np.stack([vibration + 0.05 * generator.normal(size=SAMPLES), np.mod(turns, 1) < 0.5])
    channels = (Channel("a", "displacement"), Channel("tacho", "tacho"))
    return Recording(signals, RATE_HZ, channels, pulses_per_revolution=1)


def _found(recordings, healthy=()):
    return [(one.order, one.kind) for one in found_lines(recordings, healthy, ["a"], STATED)]


def test_a_line_that_stays_with_speed_is_a_frequency():
    ((order, kind),) = _found([_record(f, i, (14.93 * 2, 0.02)) for i, f in enumerate(SPEEDS_HZ)])
    assert order == 0
    assert kind.frequency_hz == pytest.approx(29.86, abs=0.1 * RATE_HZ / SAMPLES)
    assert not kind.phase


def test_a_slow_line_is_found_as_well():
    ((_, kind),) = _found([_record(f, i, (1.61, 0.05)) for i, f in enumerate(SPEEDS_HZ)])
    assert kind.frequency_hz == pytest.approx(1.61, abs=0.1 * RATE_HZ / SAMPLES)


def test_a_drift_is_no_line():
    drift = np.linspace(0.0, 2.0, SAMPLES)
    records = [_record(f, i) for i, f in enumerate(SPEEDS_HZ)]
    assert not _found([replace(one, signals=one.signals + drift * [[1.0], [0.0]]) for one in records])


@pytest.mark.parametrize("at", [0.43, 0.465, 4.7, 7.0, 13.2])
def test_a_line_that_follows_the_shaft_is_an_order(at):
    ((order, kind),) = _found([_record(f, i, (at * f, 0.02)) for i, f in enumerate(SPEEDS_HZ)])
    assert order == pytest.approx(at, abs=0.1 * RATE_HZ / SAMPLES / min(SPEEDS_HZ))
    assert (at != 7.0) or order == 7.0
    assert kind == LineKind(phase=False)


def test_the_clearest_come_first_and_one_line_comes_once():
    lines = ((0.43, 0.02), (4.7, 0.04))
    found = _found([_record(f, i, *((o * f, a) for o, a in lines)) for i, f in enumerate(SPEEDS_HZ)])
    assert [order for order, _ in found] == pytest.approx([4.7, 0.43], abs=0.01)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([0.0, 1e-4, 2e-3]))
def test_noise_and_a_wandering_speed_make_none(seed, wander):
    assert not _found([_record(f, seed + i, wander=wander) for i, f in enumerate(SPEEDS_HZ)])


def test_what_the_healthy_machine_shows_is_not_found_until_it_grows():
    usual = [_record(f, 10 + i, (29.86, 0.02)) for i, f in enumerate(SPEEDS_HZ)]
    assert not _found([_record(f, i, (29.86, 0.02)) for i, f in enumerate(SPEEDS_HZ)], usual)
    assert len(_found([_record(f, i, (29.86, 0.08)) for i, f in enumerate(SPEEDS_HZ)], usual)) == 1


def test_a_faint_line_of_a_single_record_among_several_is_none_a_clear_one_is_found():
    faint, clear = (
        [_record(f, i, *(((29.86, size),) if i == 0 else ())) for i, f in enumerate(SPEEDS_HZ)]
        for size in (0.012, 0.02)
    )
    assert not _found(faint)
    assert len(_found(faint[:1])) == 1
    ((order, kind),) = _found(clear)
    assert order == 0
    assert kind.frequency_hz == pytest.approx(29.86, abs=0.1 * RATE_HZ / SAMPLES)


def test_a_faint_line_of_a_single_record_is_found_where_healthy_records_have_no_such_lines():
    faint = [_record(f, i, *(((29.86, 0.015),) if i == 0 else ())) for i, f in enumerate(SPEEDS_HZ)]
    quiet = [_record(f, 10 + i) for i, f in enumerate(SPEEDS_HZ)]
    restless = [_record(f, 10 + i, *(((41.3, 0.015),) if i == 2 else ())) for i, f in enumerate(SPEEDS_HZ)]
    assert len(_found(faint, quiet)) == 1
    assert not _found(faint, restless)
    loud = [replace(one, signals=one.signals * [[5.0], [1.0]]) for one in quiet[1:]]
    # Five times as much noise at other speeds tells nothing of a line at this one.
    assert len(_found(faint, [quiet[0], *loud])) == 1


def test_a_line_of_a_single_record_may_lie_at_an_order_or_at_a_frequency():
    once = [_record(f, i, *(((29.86, 0.03),) if i == 0 else ())) for i, f in enumerate(SPEEDS_HZ)]
    (line,) = found_lines(once, (), ["a"], STATED)
    (at_frequency, at_order) = line.places
    assert at_frequency == (0.0, pytest.approx(29.86, abs=0.02))
    assert at_order == (pytest.approx(29.86 / SPEEDS_HZ[0], abs=0.002), 0.0)


def test_a_line_just_outside_the_band_of_a_stated_one_is_found():
    # 50 Hz is stated; resolution 0.167 Hz: 50.8 Hz lies 4.8 lines of the spectrum beside it.
    ((order, kind),) = _found([_record(f, i, (50.8, 0.05)) for i, f in enumerate(SPEEDS_HZ)])
    assert order == 0
    assert kind.frequency_hz == pytest.approx(50.8, abs=0.1 * RATE_HZ / SAMPLES)


def test_a_stated_line_that_no_record_is_long_enough_for_hides_none():
    # Forty turns do not tell 0.44X from 0.5X, but a line at 0.413X: what an effect states must not keep it out.
    stated = ((*STATED[0], 0.44), (*STATED[1], LineKind(phase=False)))
    whirling = [_record(f, i, (0.413 * f, 0.3)) for i, f in enumerate(SPEEDS_HZ)]
    lengths = [round(40 / f * RATE_HZ) for f in SPEEDS_HZ]
    short = [replace(one, signals=one.signals[:, :n]) for one, n in zip(whirling, lengths, strict=True)]
    (line,) = found_lines(short, (), ["a"], stated)
    assert line.order == pytest.approx(0.413, abs=0.005)
    # Where a record is, a line at that place is looked at anyway.
    assert not found_lines([_record(f, i, (0.44 * f, 0.3)) for i, f in enumerate(SPEEDS_HZ)], (), ["a"], stated)
