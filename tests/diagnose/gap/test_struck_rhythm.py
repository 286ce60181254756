"""Which race is struck is told by the places of the envelope's lines, whatever the slip, sizes or angle of thrust."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, Recording
from rotorwise.diagnose.gap.envelope_lines import envelopes_of
from rotorwise.diagnose.gap.struck_rhythm import not_heard, of_a_rhythm, rhythm
from rotorwise.simulators import test_rig
from rotorwise.simulators.effects.ball_defect import BallDefect
from rotorwise.simulators.effects.cage_defect import CageDefect
from rotorwise.simulators.effects.inner_race_defect import InnerRaceDefect
from rotorwise.simulators.effects.outer_race_defect import OuterRaceDefect

from .made_strikes import BALLS, RATE_HZ, RATIO, SPEEDS_RPM, a_struck_ball, struck

RACES = (OuterRaceDefect(at="bearing_a"), InnerRaceDefect(at="bearing_a"), BallDefect(at="bearing_a"))
EVERY = (*RACES, CageDefect(at="bearing_a"))


@pytest.mark.parametrize("inner", [True, False])
@pytest.mark.parametrize("slip", [-0.02, 0.0075, 0.02])
def test_the_race_that_is_struck_excludes_the_others(inner: bool, slip: float) -> None:
    made = [struck(speed, inner=inner, slip=slip, seed=k) for k, speed in enumerate(SPEEDS_RPM)]
    envelopes = envelopes_of(made, SPEEDS_RPM)
    true, other = (RACES[1], RACES[0]) if inner else (RACES[0], RACES[1])
    found = rhythm(true, test_rig, envelopes)
    assert found.slip == pytest.approx(slip, abs=2e-3)
    gone = not_heard(RACES, test_rig, envelopes)
    assert other in gone
    assert true not in gone


def test_a_rhythm_that_no_effect_has_excludes_them_all() -> None:
    # The outer race of another bearing, 2.64 times a turn for 3.0.
    slip = 0.12
    made = [struck(speed, inner=False, slip=slip, seed=k) for k, speed in enumerate(SPEEDS_RPM)]
    envelopes = envelopes_of(made, SPEEDS_RPM)
    assert not_heard(EVERY, test_rig, envelopes) == frozenset(EVERY)
    # Few lines may be anything.
    few = [replace(one, orders=one.orders[:5], power=one.power[:5]) for one in envelopes]
    assert not_heard(EVERY, test_rig, few) == frozenset()


def test_without_the_race_that_is_struck_the_others_are_not_it() -> None:
    made = [struck(speed, inner=False, slip=0.01, seed=k) for k, speed in enumerate(SPEEDS_RPM)]
    assert not_heard(RACES[1:], test_rig, envelopes_of(made, SPEEDS_RPM)) == frozenset(RACES[1:])


def test_what_the_healthy_machine_beats_in_hides_no_race() -> None:
    # Balls pass a sound outer race, twice as loud as what strikes the inner one.
    passed = [struck(speed, inner=False, slip=0.02, seed=k + 9) for k, speed in enumerate(SPEEDS_RPM)]
    made = [struck(speed, inner=True, slip=0.01, seed=k) for k, speed in enumerate(SPEEDS_RPM)]
    both = [replace(one, signals=one.signals + 2 * of.signals) for one, of in zip(made, passed, strict=True)]
    healthy = [replace(one, signals=2 * one.signals) for one in passed[:2]]
    assert RACES[1] in not_heard(RACES, test_rig, envelopes_of(both, SPEEDS_RPM))
    envelopes = envelopes_of(both[:2], SPEEDS_RPM[:2], healthy, SPEEDS_RPM[:2])
    assert rhythm(RACES[0], test_rig, envelopes).share < 0.05
    assert RACES[1] not in not_heard(RACES, test_rig, envelopes)
    # What is there only now is heard as before, whatever else the healthy records hold.
    assert RACES[0] in not_heard(RACES, test_rig, envelopes_of(made, SPEEDS_RPM, passed[:1], SPEEDS_RPM[:1]))
    # The same race, ten times as loud as it was, is news.
    louder = [replace(one, signals=10 * one.signals) for one in made]
    same = rhythm(RACES[1], test_rig, envelopes_of(louder, SPEEDS_RPM, made, SPEEDS_RPM))
    assert same == rhythm(RACES[1], test_rig, envelopes_of(louder, SPEEDS_RPM))
    assert all(one.orders.size == 0 for one in envelopes_of(made, SPEEDS_RPM, made, SPEEDS_RPM))
    # Nor does a healthy record with samples missing.
    lost = [replace(one, signals=np.where(np.arange(one.samples) < 9, np.nan, one.signals)) for one in made]
    assert all(one.orders.size for one in envelopes_of(made, SPEEDS_RPM, lost, SPEEDS_RPM))
    # Other channels say nothing of these.
    other = [replace(one, channels=(Channel(name="housing_b_y", quantity="acceleration"),)) for one in made]
    assert all(one.orders.size for one in envelopes_of(made, SPEEDS_RPM, other, SPEEDS_RPM))


def test_lines_that_lie_as_well_elsewhere_are_not_heard() -> None:
    # Nine tenths of what stands out is a rhythm that no effect has; the outer race's lines meet a tenth of it.
    made = [struck(speed, inner=False, slip=0.12, seed=k) for k, speed in enumerate(SPEEDS_RPM)]
    envelopes = envelopes_of(made, SPEEDS_RPM)
    lines = np.array([line.order for line in RACES[0].signature(test_rig)[:4]])
    added = [
        replace(
            one,
            orders=np.append(one.orders, lines),
            power=np.append(one.power, np.full(4, 0.025 * one.power.sum())),
        )
        for one in envelopes
    ]
    assert 0.05 < rhythm(RACES[0], test_rig, added).share < 0.4
    assert RACES[0] in not_heard(EVERY, test_rig, added)
    # The same share is heard where the rest follows no rhythm at all.
    generator = np.random.default_rng(0)
    spread = [
        replace(one, orders=np.append(generator.uniform(1.0, 25.0, 40), lines), power=np.append(np.ones(40), [1.0] * 4))
        for one in envelopes
    ]
    assert RACES[0] not in not_heard(EVERY, test_rig, spread)


def test_noise_and_no_acceleration_exclude_nothing() -> None:
    generator = np.random.default_rng(1)
    one = struck(1500.0, inner=True, slip=0.01, seed=0)
    noise = Recording(
        signals=generator.normal(size=one.signals.shape),
        rate_hz=RATE_HZ,
        channels=one.channels,
        condition=one.condition,
        provenance=one.provenance,
    )
    assert not_heard(RACES, test_rig, envelopes_of([noise], [1500.0])) == frozenset()
    assert not_heard(RACES, test_rig, ()) == frozenset()


def test_a_ball_that_comes_and_goes_with_the_cage_is_not_taken_for_the_cage() -> None:
    # The train of strikes holds the cage's own rhythm with several harmonics, louder than the ball's.
    envelopes = envelopes_of([a_struck_ball(0.01)], [1800.0])
    shares = {one.NAME: rhythm(one, test_rig, envelopes).share for one in EVERY}
    assert shares["ball_defect"] > 0.75 > 0.6 > shares["cage_defect"] > 0.4
    assert RACES[2] not in not_heard(EVERY, test_rig, envelopes)


def test_a_cage_is_not_taken_for_a_ball() -> None:
    envelopes = envelopes_of([a_struck_ball(0.01, by_the_cage=True)], [1800.0])
    # The tenth harmonic of this cage lies where a ball strikes, but most of what stands out is not the ball's.
    assert rhythm(RACES[2], test_rig, envelopes).share < 0.4 < 0.5 < rhythm(EVERY[3], test_rig, envelopes).share
    assert {RACES[0], RACES[1]} <= not_heard(EVERY, test_rig, envelopes)
    assert EVERY[3] not in not_heard(EVERY, test_rig, envelopes)


def test_lines_of_the_rhythm_are_no_further_lines() -> None:
    envelopes = envelopes_of([a_struck_ball(0.01)], [1800.0])
    lines = [line.order for line in BallDefect(at="bearing_a", slip=0.01).signature(test_rig)]
    twice, side = lines[0], lines[1] - lines[0]
    orders = np.array([[twice, twice - 3 * side, 2 * side], [1.13, twice + 0.45 * side, 2 * twice + side]])
    told = of_a_rhythm(orders, RACES, test_rig, envelopes)
    assert told.tolist() == [[True, True, True], [False, False, True]]
    assert not of_a_rhythm(orders, RACES, test_rig, ()).any()
    assert not of_a_rhythm(orders, (), test_rig, envelopes).any()


def test_under_thrust_a_slip_is_negative_and_whole_orders_stay_the_shaft_s() -> None:
    made = [struck(speed, inner=True, slip=-0.01, seed=k) for k, speed in enumerate(SPEEDS_RPM)]
    cage = (1 - RATIO) / 2 * 1.01
    orders = np.array([BALLS * (1 - cage), BALLS * (1 - cage) + 1, 1.0, 2.0, 4.0])
    told = of_a_rhythm(orders, RACES, test_rig, envelopes_of(made, SPEEDS_RPM))
    assert told.tolist() == [True, True, False, False, False]
