"""A sensor that sees the machine by another way than before: its spectrum falls where that of the others does not."""

import math
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, OperatingCondition, Provenance, Recording
from rotorwise.diagnose.gap.changed_transfer import changed_transfers, changed_words, without_changed
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines

RATE_HZ, SECONDS = 4_000.0, 4.0
NAMES = ("a", "b", "c")
SPEEDS_RPM = (1200.0, 1800.0, 2400.0)
#: An octave and a third, where a sensor on another mount hears less.
LOW_HZ, HIGH_HZ = 80.0, 202.0


def record(speed_rpm: float, seed: int, gain_db: dict[str, tuple[float, float, float]] | None = None) -> Recording:
    """Return noise with a line at 1X; ``gain_db`` of a channel: from, to (Hz), dB."""
    generator = np.random.default_rng(seed)
    count = int(RATE_HZ * SECONDS)
    frequency = np.fft.rfftfreq(count, 1 / RATE_HZ)
    line = 3 * np.cos(2 * math.pi * speed_rpm / 60 * np.arange(count) / RATE_HZ)
    rows = []
    for name in NAMES:
        low, high, level = (gain_db or {}).get(name, (0.0, 0.0, 0.0))
        inside = (frequency >= low) & (frequency < high)
        spectrum = np.fft.rfft(generator.normal(size=count)) * np.where(inside, 10 ** (level / 20), 1.0)
        rows.append(line + np.fft.irfft(spectrum, count))
    return Recording(
        signals=np.array(rows),
        rate_hz=RATE_HZ,
        channels=tuple(Channel(name=name, quantity="acceleration") for name in NAMES),
        condition=OperatingCondition(speed_rpm=speed_rpm),
        provenance=Provenance(),
    )


HEALTHY = [record(speed, seed) for seed, speed in enumerate(SPEEDS_RPM)]


def changed(now: list[Recording], names: tuple[str, ...] = NAMES):
    """Return what has changed since the healthy records."""
    speeds = [float(one.condition.speed_rpm or 0.0) for one in now]
    return changed_transfers(now, speeds, HEALTHY, SPEEDS_RPM, names)


def test_an_octave_that_fell_at_one_channel_and_at_every_speed_is_another_transfer() -> None:
    (found,) = changed([record(s, 10 + k, {"b": (LOW_HZ, HIGH_HZ, -14.0)}) for k, s in enumerate(SPEEDS_RPM)])
    assert found.channel == "b"
    low, high, fall = found.fell
    assert low >= LOW_HZ * 0.99
    assert high <= HIGH_HZ * 1.01
    # What the channel was made with, to a few tenths: medians of hundreds of lines.
    assert fall == pytest.approx(-14.0, abs=1.0)
    assert all(a >= LOW_HZ * 0.99 and b <= HIGH_HZ * 1.01 for a, b in found.bands_hz)
    (said,) = changed_words([found])
    assert said.startswith("b: ")
    assert "fell by 14 dB" in said


@pytest.mark.parametrize(
    "gains",
    [
        {},
        {"b": (LOW_HZ, HIGH_HZ, 14.0)},  # a fault that shakes more
        {"b": (0.0, RATE_HZ, -14.0)},  # another gain, or a quieter recorder
        {name: (LOW_HZ, HIGH_HZ, -14.0) for name in NAMES},  # a neighbour that stands still now
        {"b": (LOW_HZ, 1.3 * LOW_HZ, -14.0)},  # a resonance that moved
        {"b": (LOW_HZ, HIGH_HZ, -4.0)},
    ],
)
def test_what_may_have_another_cause_is_not_one(gains: dict[str, tuple[float, float, float]]) -> None:
    assert changed([record(s, 20 + k, gains) for k, s in enumerate(SPEEDS_RPM)]) == ()


def test_every_record_has_to_show_it_and_others_have_to_be_there() -> None:
    gains = {"b": (LOW_HZ, HIGH_HZ, -14.0)}
    some = [record(s, 30 + k, gains if k else None) for k, s in enumerate(SPEEDS_RPM)]
    assert changed(some) == ()
    every = [record(s, 40 + k, gains) for k, s in enumerate(SPEEDS_RPM)]
    assert changed(every, ("b",)) == ()
    assert changed_transfers(every, SPEEDS_RPM, [], [], NAMES) == ()
    far = [2 * speed for speed in SPEEDS_RPM]
    assert changed_transfers(every[:1], [1800.0], HEALTHY[:1], [1200.0], NAMES) == ()
    assert changed_transfers(every, far, HEALTHY[:1], SPEEDS_RPM[:1], NAMES) == ()


def test_lines_where_the_transfer_changed_are_left_out() -> None:
    now = [record(s, 50 + k, {"b": (LOW_HZ, HIGH_HZ, -14.0)}) for k, s in enumerate(SPEEDS_RPM)]
    kinds = (LineKind(), LineKind(), LineKind(phase=False, envelope=True))
    shape = (len(SPEEDS_RPM), len(NAMES), len(kinds))
    lines = OrderLines(
        conditions=tuple(Condition(speed) for speed in SPEEDS_RPM),
        probes=NAMES,
        orders=(1.0, 4.0, 4.0),
        amplitudes=np.ones(shape, dtype=complex),
        deviations=np.full(shape, 0.1),
        kinds=kinds,
        reference=(0, 0, 0),
    )
    left = without_changed(lines, changed(now)).seen
    # 4X lies at 80, 120 and 160 Hz.
    assert not left[:, 1, 1].any()
    assert left[:, 1, 0].all()
    assert left[:, 1, 2].all()
    assert left[:, [0, 2]].all()
    other = replace(lines, probes=("a", "d", "c"))
    assert without_changed(other, changed(now)).seen.all()
