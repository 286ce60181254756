"""A race or ball is named by the rhythm of the envelope where that is news, lies nowhere else and has no rival."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Recording
from rotorwise.diagnose.gap import explain
from rotorwise.diagnose.gap.envelope_lines import Spectrum, envelopes_of
from rotorwise.diagnose.gap.heard_rhythm import HEARD, Heard, heard_rhythm
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.simulators import test_rig
from rotorwise.simulators.effects.ball_defect import BallDefect
from rotorwise.simulators.effects.cage_defect import CageDefect
from rotorwise.simulators.effects.inner_race_defect import InnerRaceDefect
from rotorwise.simulators.effects.outer_race_defect import OuterRaceDefect
from rotorwise.simulators.effects.unbalance import Unbalance

from .made_strikes import SPEEDS_RPM, a_struck_ball, struck

KINDS = (OuterRaceDefect, InnerRaceDefect, BallDefect, CageDefect)
EVERY = tuple(kind(at=at) for at in ("bearing_a", "bearing_b") for kind in KINDS)


def noise_like(one: Recording, seed: int = 7) -> Recording:
    """Return noise in place of a recording: a healthy machine."""
    return replace(one, signals=0.3 * np.random.default_rng(seed).normal(size=one.signals.shape))


def envelopes(made: Sequence[Recording], speeds: Sequence[float] = SPEEDS_RPM) -> tuple[Spectrum, ...]:
    return envelopes_of(made, speeds, [noise_like(one) for one in made], speeds)


def races(*, inner: bool, slip: float = 0.01) -> list[Recording]:
    return [struck(speed, inner=inner, slip=slip, seed=k) for k, speed in enumerate(SPEEDS_RPM)]


@pytest.mark.parametrize(("inner", "name"), [(True, "inner_race_defect"), (False, "outer_race_defect")])
def test_a_struck_race_is_named_at_both_bearings_that_beat_alike(inner: bool, name: str) -> None:
    heard = heard_rhythm((Unbalance(at="disc"), *EVERY), test_rig, envelopes(races(inner=inner)))
    assert heard is not None
    assert (heard.effect.NAME, heard.places, heard.is_sure) == (name, ("bearing_a", "bearing_b"), True)
    assert heard.slip == pytest.approx(0.01, abs=2e-3)
    assert heard.cause.at == "bearing_a or bearing_b"
    assert "named by its rhythm" in heard.words


@pytest.mark.parametrize(("sizes", "where"), [([1.0, 3.0], "far"), ([2.0, 3.0], ""), ([3.0], "")])
def test_the_probe_is_told_where_the_strongest_line_is_clearly_the_largest(sizes, where) -> None:
    first = OuterRaceDefect(at="bearing_a", slip=0.01).signature(test_rig)[0].order
    # A line beside it is another one's.
    made = np.array([[[size, 9.0 / size] for size in sizes]], dtype=complex)
    kinds = (LineKind(phase=False, envelope=True),) * 2
    probes = ("near", "far")[: len(sizes)]
    lines = OrderLines((Condition(1260.0),), probes, (first, 1.2 * first), made, np.ones(made.shape), kinds)
    heard = heard_rhythm(EVERY, test_rig, envelopes(races(inner=False)), lines)
    assert heard is not None
    assert heard.loudest == where
    assert ("loudest at far" in heard.words) == bool(where)


def test_a_ball_is_named_and_a_cage_never() -> None:
    ball = heard_rhythm(EVERY, test_rig, envelopes([a_struck_ball(0.01)], [1800.0]))
    assert ball is not None
    assert (ball.effect.NAME, ball.is_sure) == ("ball_defect", True)
    cage = heard_rhythm(EVERY, test_rig, envelopes([a_struck_ball(0.01, by_the_cage=True)], [1800.0]))
    assert cage is not None
    assert (cage.effect.NAME, cage.is_sure) == ("cage_defect", False)


def test_without_healthy_records_of_that_speed_nothing_is_named() -> None:
    made = races(inner=True)
    for heard in (
        heard_rhythm(EVERY, test_rig, envelopes_of(made, SPEEDS_RPM)),
        heard_rhythm(EVERY, test_rig, envelopes_of(made, SPEEDS_RPM, [noise_like(made[0])], SPEEDS_RPM[:1])),
    ):
        assert heard is not None
        assert not heard.is_sure
        assert "named" not in heard.words
    # What the healthy machine beats in as well is not even heard.
    assert heard_rhythm(EVERY, test_rig, envelopes_of(made, SPEEDS_RPM, made, SPEEDS_RPM)) is None


def test_a_record_far_in_speed_from_all_healthy_ones_does_not_hide_what_is_news_in_the_others() -> None:
    made, speeds = races(inner=True), list(SPEEDS_RPM)
    near = [noise_like(one) for one in made[1:]]
    heard = heard_rhythm(EVERY, test_rig, envelopes_of(made, speeds, near, speeds[1:]))
    assert heard is not None
    assert (heard.effect.NAME, heard.is_sure) == ("inner_race_defect", True)
    # Nor does what beats in that one only name anything.
    other = [*races(inner=True)[:1], *[noise_like(one, 8) for one in made[1:]]]
    heard = heard_rhythm(EVERY, test_rig, envelopes_of(other, speeds, near, speeds[1:]))
    assert heard is None or not heard.is_sure


def test_few_lines_a_rhythm_of_another_bearing_and_noise_name_nothing() -> None:
    found = envelopes(races(inner=False))
    first = OuterRaceDefect(at="bearing_a", slip=0.01).signature(test_rig)[0].order
    few = [one.taken(np.abs(one.orders - first) > 0.05) for one in found]
    alone = heard_rhythm(EVERY, test_rig, few)
    assert alone is None or not alone.is_sure
    assert heard_rhythm(EVERY, test_rig, envelopes(races(inner=False, slip=0.12))) is None
    quiet = [noise_like(one, 8) for one in races(inner=False)]
    assert heard_rhythm(EVERY, test_rig, envelopes(quiet)) is None
    assert heard_rhythm(EVERY, test_rig, ()) is None


@pytest.mark.parametrize(("louder", "name"), [(1.0, "inner_race_defect"), (1.5, None), (3.0, "outer_race_defect")])
def test_of_two_races_at_once_the_louder_is_named_if_one_is(louder: float, name: str | None) -> None:
    both = [
        replace(one, signals=one.signals + louder * other.signals)
        for one, other in zip(races(inner=True), races(inner=False), strict=True)
    ]
    heard = heard_rhythm(EVERY, test_rig, envelopes(both))
    assert (heard.effect.NAME if heard and heard.is_sure else None) == name


def test_what_is_named_acts_beside_something_unknown() -> None:
    heard = Heard(EVERY[0], ("bearing_a",), 0.9, 0.01, is_sure=True)
    kind, causes, told = heard.added("unknown", (), {("unknown",): 0.6, ("unbalance", "unknown"): 0.4})
    assert (kind, [(one.effect, one.at) for one in causes]) == ("unknown", [("outer_race_defect", "bearing_a")])
    assert sum(told.values()) == pytest.approx(1.0)
    assert told["outer_race_defect", "unknown"] == pytest.approx(0.6 * HEARD)
    assert told["outer_race_defect", "unbalance", "unknown"] == pytest.approx(0.4 * HEARD)
    assert told["unknown",] == pytest.approx(0.6 * (1 - HEARD))
    # It is not nothing then; beside causes that explain all lines, or not sure, it changes nothing.
    assert heard.added("none", (), {(): 0.9, ("unbalance",): 0.1})[0] == "unknown"
    assert heard.added("one cause", (), {("unbalance",): 1.0}) == ("one cause", (), {("unbalance",): 1.0})
    unsure = replace(heard, is_sure=False)
    assert unsure.added("unknown", (), {("unknown",): 1.0}) == ("unknown", (), {("unknown",): 1.0})


def test_rhythms_are_those_of_all_bearings_whatever_the_model_makes_of_them() -> None:
    names = {"outer_race_defect", "inner_race_defect", "ball_defect", "cage_defect"}
    found = {(one.NAME, one.at) for one in explain._striking(test_rig, frozenset())}
    assert found == {(name, at) for name in names for at in ("bearing_a", "bearing_b")}
    left = explain._striking(test_rig, frozenset({"cage_defect"}))
    assert {one.NAME for one in left} == names - {"cage_defect"}
