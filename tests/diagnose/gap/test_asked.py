"""What is asked of the engine: names of effects, the machine, channels that show something, sizes that can be."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign, Channel, Recording
from rotorwise.diagnose.gap.asked import dead_words, shared_probes
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.fitness import in_few_words
from rotorwise.diagnose.gap.plausible_sizes import unlike_words
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine

from .made_campaigns import recorded

ROTOR = find_machine("amb_rotor")
NAMES = ("path_1", "path_2", "path_3", "path_4")


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    made = recorded(ROTOR, (1500.0, 2400.0, 2000.0), rate_hz=2000.0, duration_s=1.0, seed=5)
    return Campaign(made[:2], made[2:])


def _times(recordings, factor: float):
    return tuple(
        replace(one, signals=np.where([[c.quantity != "tacho"] for c in one.channels], factor, 1.0) * one.signals)
        for one in recordings
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"only": frozenset({"rubb"})}, "only 'rubb': no such effect.*Did you mean rub"),
        ({"without": frozenset({"rubb"})}, "without 'rubb'"),
        ({"without": "rub"}, "allowed: a set of names"),
    ],
)
def test_names_of_effects_are_checked_before_the_work(campaign: Campaign, options, words: str) -> None:
    with pytest.raises(InvalidValueError, match=words):
        explain_gap(campaign, ROTOR, **options)


def test_a_name_is_no_machine(campaign: Campaign) -> None:
    with pytest.raises(InvalidValueError, match="find_machine"):
        explain_gap(campaign, "amb_rotor")  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("value", [0.0, 3.0, np.nan])
def test_a_channel_that_shows_nothing_is_not_compared(campaign: Campaign, value: float) -> None:
    first = campaign.recordings[0]
    assert first.channels[0].name == "path_1"

    def with_dead(count: int) -> Campaign:
        dead = np.arange(len(first.channels))[:, None] < count
        one = replace(first, signals=np.where(dead, value, first.signals))
        return replace(campaign, recordings=(one, *campaign.recordings[1:]))

    assert list(shared_probes(campaign, ROTOR)) == list(NAMES)
    assert not dead_words(campaign, ROTOR)
    assert list(shared_probes(with_dead(1), ROTOR)) == list(NAMES[1:])
    assert "path_1 has one value" in dead_words(with_dead(1), ROTOR)[0]
    with pytest.raises(InvalidValueError, match="the same value in all samples"):
        explain_gap(with_dead(4), ROTOR)


def test_healthy_recordings_of_other_probes_are_told_apart_from_wrong_names(campaign: Campaign) -> None:
    some = tuple(one.select([0, 1]) for one in campaign.recordings)
    others = tuple(one.select([2, 3]) for one in campaign.baseline)
    with pytest.raises(InvalidValueError, match=r"these have path_1, path_2, the healthy ones path_3, path_4"):
        explain_gap(Campaign(some, others), ROTOR)


@pytest.mark.parametrize(("factor", "words"), [(1e3, "1000 times larger"), (1e-3, "1000 times smaller")])
def test_healthy_recordings_in_another_unit_are_refused(campaign: Campaign, factor: float, words: str) -> None:
    made = recorded(ROTOR, (1500.0, 2400.0), rate_hz=2000.0, duration_s=1.0, seed=8)
    alike = Campaign(made, made)
    assert not unlike_words(alike, NAMES)
    with pytest.raises(InvalidValueError, match=words):
        explain_gap(Campaign(_times(made, factor), made), ROTOR)
    # One channel alone may be dead, or another amplifier's.
    one = tuple(
        replace(r, signals=np.where(np.arange(len(r.channels))[:, None] < 1, factor, 1.0) * r.signals) for r in made
    )
    assert not unlike_words(Campaign(one, made), NAMES)


def test_a_shaft_that_turned_evenly_may_swing_by_any_factor_more() -> None:
    noise = np.random.default_rng(1).normal(size=(1, 500))
    before = Recording(noise, 1e3, (Channel("speed", "rotational_speed"),))
    now = replace(before, signals=1e4 * before.signals)
    assert not unlike_words(Campaign((now,), (before,)), ["speed"])
    # Less than before it does not: that is another unit.
    assert "10000 times smaller" in unlike_words(Campaign((before,), (now,)), ["speed"])


def test_recordings_a_thousand_times_smaller_than_the_machine_makes_them_are_refused(campaign: Campaign) -> None:
    small = Campaign(_times(campaign.recordings, 1e-3), _times(campaign.baseline, 1e-3))
    with pytest.raises(InvalidValueError, match=r"1\d\d\d times smaller|9\d\d times smaller"):
        explain_gap(small, ROTOR)


def test_a_defect_of_many_files_is_told_once() -> None:
    told = in_few_words(["a.csv: A: 3 of 100 samples missing.", "b.csv: A: 14 of 200 samples missing.", "c.csv: hum."])
    assert told == ["a.csv: A: 3 of 100 samples missing. Alike in b.csv.", "c.csv: hum."]
    assert "Alike in 7 more" in in_few_words([f"{i}.csv: constant." for i in range(8)])[0]
