"""Spikes of a loose contact are taken out; what a machine makes is not."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, OperatingCondition, Recording
from rotorwise.diagnose.gap.loose_contact import MOST, Spikes, spikes_words, without_spikes
from rotorwise.diagnose.gap.unsteady import unsteady

RATE_HZ, SAMPLES, SPEED_RPM = 8000.0, 32_000, 1500.0
TIME = np.arange(SAMPLES) / RATE_HZ
PLACES = (4_321, 11_000, 11_777, 20_202, 29_000)


def record(seed: int = 0) -> Recording:
    """Return two channels with lines and noise, and a tacho."""
    turns = SPEED_RPM / 60 * TIME
    noise = 0.05 * np.random.default_rng(seed).normal(size=(2, SAMPLES))
    lines = np.stack([np.cos(2 * np.pi * turns), 0.5 * np.cos(4 * np.pi * turns)])
    channels = (Channel("a", "acceleration"), Channel("b", "acceleration"), Channel("tacho", "tacho"))
    signals = np.concatenate([lines + noise, (turns[None] % 1 < 0.1).astype(float)])
    return Recording(signals, RATE_HZ, channels, OperatingCondition(speed_rpm=SPEED_RPM))


def with_added(made: Recording, added: np.ndarray, row: int = 0) -> Recording:
    signals = made.signals.copy()
    signals[row] += added
    return replace(made, signals=signals)


def spiky(places: tuple[int, ...] = PLACES, size: float = 15.0) -> np.ndarray:
    added = np.zeros(SAMPLES)
    for number, place in enumerate(places):
        added[place : place + 1 + number % 4] = size * (-1) ** number
    return added


def test_spikes_are_bridged_and_told() -> None:
    sound = record()
    (mended,), said = without_spikes([with_added(sound, spiky())])
    assert [(one.channel, one.count) for one in said] == [("a", len(PLACES))]
    touched = np.flatnonzero(mended.signals[0] != sound.signals[0])
    assert touched.size < 12 * len(PLACES)
    # A line through ten samples of a rotating sine leaves noise.
    assert np.abs(mended.signals[0] - sound.signals[0]).max() < 0.3
    assert np.array_equal(mended.signals[1:], sound.signals[1:])
    (words,) = spikes_words(said)
    assert "5 of a at 1500 rpm" in words
    # The spectrum between the lines is that of the sound record again.
    assert unsteady([with_added(sound, spiky())], [SPEED_RPM], [record(1)], [SPEED_RPM], ["a", "b"])
    assert not unsteady([mended], [SPEED_RPM], [record(1)], [SPEED_RPM], ["a", "b"])


def ringing(places: tuple[int, ...]) -> np.ndarray:
    added = np.zeros(SAMPLES)
    for place in places:
        after = np.arange(SAMPLES - place) / RATE_HZ
        added[place:] += 15 * np.exp(-400 * after) * np.cos(2 * np.pi * 1900 * after)
    return added


@pytest.mark.parametrize(
    "added",
    [
        np.zeros(SAMPLES),
        ringing(PLACES),
        spiky(tuple(range(200, SAMPLES - 200, SAMPLES // (2 * MOST)))),
        spiky(size=1.0),
    ],
    ids=["nothing", "shocks that ring", "too many", "small"],
)
def test_what_a_machine_may_make_stays(added: np.ndarray) -> None:
    made = with_added(record(), added)
    assert without_spikes([made]) == ((made,), ())


def test_a_shock_that_both_channels_hear_stays_and_a_single_channel_has_no_witness() -> None:
    both = with_added(with_added(record(), spiky()), 0.3 * spiky(), row=1)
    assert without_spikes([both]) == ((both,), ())
    alone = with_added(record(), spiky()).select([0, 2])
    assert without_spikes([alone]) == ((alone,), ())
    assert spikes_words(()) == ()


def test_many_records_of_a_channel_are_one_remark() -> None:
    (words,) = spikes_words([Spikes("a", 100.0 * k, 1) for k in range(1, 10)] + [Spikes("b", None, 2)])
    assert "taken out: 9 of a in 9 records and 2 of b." in words


def test_a_filter_that_settles_is_no_loose_contact() -> None:
    added = np.zeros(SAMPLES)
    added[1:3] = (15.0, -9.0)
    (mended,), said = without_spikes([with_added(record(), added)])
    assert np.abs(mended.signals[0] - record().signals[0]).max() < 1.0
    assert not said
