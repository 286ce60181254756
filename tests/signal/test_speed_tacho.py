"""Speed from a tacho: exact trains, damaged trains, and what is no train."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal.order_tracking import phase_from_pulses
from rotorwise.diagnose.signal.speed import pulse_times, speed_from_tacho
from rotorwise.simulators.errors import InvalidValueError
from scipy.signal import butter, sosfilt

RATE = 20_000.0
SECONDS = 4.0
TIME = np.arange(int(RATE * SECONDS)) / RATE


def train(angle: np.ndarray, *, duty: float = 0.05) -> np.ndarray:
    """Pulses 0 to 1 at whole turns, with edges a sample wide, as an anti-alias filter leaves them."""
    turn_per_sample = np.gradient(angle)
    position = angle % 1.0
    rise = np.clip(position / turn_per_sample + 0.5, 0, 1)
    fall = np.clip((duty - position) / turn_per_sample + 0.5, 0, 1)
    return rise * fall + np.clip((position - 1) / turn_per_sample + 0.5, 0, 1)


def steady(speed_hz: float) -> np.ndarray:
    return 0.3 + speed_hz * TIME


def found(pulses: np.ndarray, **options):
    result = speed_from_tacho(pulses, rate_hz=RATE, **options)
    assert result is not None
    return result


# --- exact trains ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [2.3, 24.71, 59.9, 401.3])
def test_steady_speed_to_10_in_a_million(speed):
    estimate, times = found(train(steady(speed)))
    assert estimate.speed_hz == pytest.approx(speed, rel=1e-5)
    assert estimate.low_hz <= speed <= estimate.high_hz
    assert estimate.confidence > 0.98
    assert estimate.variation < 2e-4 + 0.2 * speed / RATE
    # The shaft passes whole turns at these times; an edge as steep as a sample is known to a tenth of it.
    assert 0.3 + speed * times == pytest.approx(np.arange(1, times.size + 1), abs=0.1 * speed / RATE)


@pytest.mark.parametrize("per_turn", [1.0, 2.0, 6.0, 60.0])
def test_several_pulses_a_turn(per_turn):
    estimate, _ = found(train(steady(24.71) * per_turn, duty=0.4), pulses_per_revolution=per_turn)
    assert estimate.speed_hz == pytest.approx(24.71, rel=1e-5)
    assert estimate.speed_rpm == pytest.approx(60 * 24.71, rel=1e-5)


@pytest.mark.parametrize("apart", [0.1, 0.2, 0.25, 0.3, 0.4])
def test_two_marks_anywhere_on_the_shaft(apart):
    """Two unlike distances a turn are no bounce, and none of them is a missing pulse."""
    turn = steady(24.71) % 1.0
    marks = ((turn < 0.02) | ((turn > apart) & (turn < apart + 0.02))).astype(float)
    estimate, times = found(marks, pulses_per_revolution=2.0)
    assert estimate.speed_hz == pytest.approx(24.71, rel=2e-5)
    assert times.size in (197, 198)


@pytest.mark.parametrize("speed", [10.0, 25.5, 36.0, 50.0])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_an_encoder_behind_an_anti_alias_filter(speed, noise):
    """Sixty stripes at 7 to 33 samples each: after eight poles at 0.4 of the rate it rings and is never at rest."""
    finer = 8
    angle = 60 * (0.3 + speed * np.arange(TIME.size * finer) / (RATE * finer))
    filtered = sosfilt(butter(8, 0.4 * RATE, fs=RATE * finer, output="sos"), 5.0 * (angle % 1.0 < 0.5))[::finer]
    pulses = filtered + np.random.default_rng(3).normal(0, noise, TIME.size)
    estimate, times = found(pulses, pulses_per_revolution=60.0)
    assert estimate.speed_hz == pytest.approx(speed, rel=1e-5)
    assert np.diff(times) == pytest.approx(1 / (60 * speed), abs=0.6 / RATE)


def test_a_contact_that_bounces():
    """One to four edges within a tenth of a turn, in most turns more than one: the first is the pulse."""
    random, turn = np.random.default_rng(12), RATE / 24.71
    pulses = np.zeros(TIME.size)
    starts = (np.arange(int(SECONDS * 24.71) - 1) + 0.3) * turn
    for start in starts:
        for after in (0.0, *np.cumsum(random.uniform(0.015, 0.035, random.integers(1, 4)))):
            pulses[int(start + after * turn) : int(start + (after + 0.008) * turn)] = 1.0
    estimate, times = found(pulses)
    assert estimate.speed_hz == pytest.approx(24.71, rel=1e-4)
    # Edges lie between two samples, up to one and a half after the true place was cut to a whole one.
    assert times * RATE == pytest.approx(starts, abs=1.6)


def test_a_step_before_the_first_pulse_is_none():
    """A filter that starts from rest in the middle of a pulse makes an edge of its own: no pulse is lost for it."""
    pulses = train(steady(24.71))
    pulses[: int(0.3 * RATE / 24.71)] = 0.0
    pulses[int(0.32 * RATE / 24.71) : int(0.36 * RATE / 24.71)] = 1.0
    estimate, times = found(pulses)
    whole = 0.3 + 24.71 * times
    assert whole == pytest.approx(np.arange(1, times.size + 1), abs=0.01)
    assert estimate.variation < 1e-3


@pytest.mark.parametrize("duty", [0.003, 0.05, 0.5, 0.95])
def test_pulses_that_go_down_give_the_same_speed_and_the_times_of_their_ends(duty):
    estimate, times = found(-3.0 * train(steady(24.71), duty=duty) + 1.0)
    assert estimate.speed_hz == pytest.approx(24.71, rel=1e-5)
    past_the_end = (0.3 + 24.71 * times - duty + 0.5) % 1.0 - 0.5
    assert np.abs(past_the_end).max() < 2e-3


@given(gain=st.floats(1e-3, 1e3), offset=st.floats(-100, 100))
@settings(max_examples=10, deadline=None)
def test_voltage_and_offset_do_not_matter(gain, offset):
    estimate, _ = found(gain * (train(steady(24.71)) + offset))
    assert estimate.speed_hz == pytest.approx(24.71, rel=1e-5)


def test_a_sine_serves_as_a_train():
    estimate, _ = found(np.sin(2 * np.pi * 24.71 * TIME))
    assert estimate.speed_hz == pytest.approx(24.71, rel=1e-5)


def test_a_ramp_gives_the_mean_speed_and_its_variation():
    estimate, _ = found(train(20 * TIME + 0.5 * (4 / SECONDS) * TIME**2))
    assert estimate.speed_hz == pytest.approx(22, rel=2e-3)
    # Periods are taken over the whole turns in 2000 samples, three here; their middles span the change less one such
    # stretch, and 90 % of them lie within 90 % of that.
    stretch = 3 / 22
    assert estimate.variation == pytest.approx(0.9 * 4 / 22 * (1 - stretch / SECONDS), rel=0.03)


@pytest.mark.parametrize("hunting_hz", [0.5, 2.0, 7.3])
def test_hunting_shows_whether_slow_or_fast(hunting_hz):
    """In means of a tenth of a second 7 Hz is hardly to be seen; 90 % of the time lie between the quantiles."""
    deep = 0.02
    angle = 40.0 * (TIME - deep * np.cos(2 * np.pi * hunting_hz * TIME) / (2 * np.pi * hunting_hz))
    expected = 2 * deep * math.sin(0.45 * math.pi)
    assert found(train(angle))[0].variation == pytest.approx(expected, rel=0.12)


@pytest.mark.parametrize("per_turn", [1, 8, 60])
def test_constant_speed_shows_no_variation(per_turn):
    """Neither the half sample of an edge nor unevenly spaced stripes are a varying speed."""
    angle = 24.71 * TIME
    stripes = (np.arange(per_turn) + 0.02 * np.random.default_rng(0).uniform(-1, 1, per_turn)) / per_turn
    distance = np.min([np.abs((angle - one + 0.5) % 1.0 - 0.5) for one in stripes], axis=0)
    estimate, _ = speed_from_tacho(
        (distance < 0.15 / per_turn).astype(float), rate_hz=RATE, pulses_per_revolution=per_turn
    )
    assert estimate.speed_hz == pytest.approx(24.71, rel=1e-4)
    assert estimate.variation < 1e-3


@pytest.mark.parametrize("share", [0.2, 0.35, 0.45])
@pytest.mark.parametrize("seed", range(4))
def test_a_train_that_lacks_many_pulses_at_random(share, seed):
    """Half of the periods are of several turns: the middle one is no turn."""
    random = np.random.default_rng(seed)
    pulses, lost = train(steady(41.3)), random.random(200) < share
    turn = np.floor(steady(41.3) + 0.2).astype(int)
    estimate, times = found(np.where(lost[turn], 0.0, pulses))
    assert estimate.speed_hz == pytest.approx(41.3, rel=1e-4)
    assert np.diff(times) == pytest.approx(1 / 41.3, rel=1e-2)


@pytest.mark.parametrize("seed", range(4))
def test_a_train_that_lacks_six_pulses_of_ten_is_right_or_none(seed):
    random = np.random.default_rng(seed)
    pulses, lost = train(steady(41.3)), random.random(200) < 0.6
    turn = np.floor(steady(41.3) + 0.2).astype(int)
    result = speed_from_tacho(np.where(lost[turn], 0.0, pulses), rate_hz=RATE)
    assert result is None or result[0].speed_hz == pytest.approx(41.3, rel=1e-4)


# --- damaged trains -------------------------------------------------------------------------------------------


def damaged(*, missing: int = 0, doubled: int = 0, seed: int = 0) -> np.ndarray:
    """98 turns at 24.71 Hz; pulses wiped out, and false ones put between."""
    rng = np.random.default_rng(seed)
    pulses = train(steady(24.71))
    chosen = rng.choice(np.arange(3, 95), missing + doubled, replace=False)
    for index, turn in enumerate(chosen):
        start = (turn - 0.3) / 24.71
        if index < missing:
            pulses[int((start - 0.005) * RATE) : int((start + 0.01) * RATE)] = 0.0
        else:
            extra = int((start + rng.uniform(0.2, 0.8) / 24.71) * RATE)
            pulses[extra : extra + 20] = 1.0
    return pulses


@pytest.mark.parametrize(("missing", "doubled"), [(1, 0), (15, 0), (0, 1), (0, 15), (8, 8)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_missing_and_false_pulses_change_neither_speed_nor_angle(missing, doubled, seed):
    estimate, times = found(damaged(missing=missing, doubled=doubled, seed=seed))
    assert estimate.speed_hz == pytest.approx(24.71, rel=1e-4)
    assert estimate.confidence < 0.99 - 0.5 * (missing + doubled) / 98
    angle = phase_from_pulses(times, samples=TIME.size, rate_hz=RATE)
    # A false pulse beside a missing one may stand for it: the turn count still holds.
    assert angle + 1 == pytest.approx(steady(24.71), abs=0.5 if missing and doubled else 5e-3)


@pytest.mark.parametrize("sigma", [0.005, 0.02, 0.035])
@pytest.mark.parametrize("seed", [1, 2])
def test_noise_on_the_tacho(sigma, seed):
    noisy = train(steady(24.71)) + np.random.default_rng(seed).normal(0, sigma, TIME.size)
    estimate, times = found(noisy)
    assert estimate.speed_hz == pytest.approx(24.71, rel=2e-5)
    assert times.size == 99
    assert estimate.low_hz <= 24.71 <= estimate.high_hz


def test_stated_intervals_hold_the_speed():
    """Edges jitter by 0.2 % of a turn; 100 trains, 95 % wanted, 88 allow for the scatter of 100 draws."""
    rng = np.random.default_rng(5)
    inside = 0
    for _ in range(100):
        speed = rng.uniform(20, 30)
        edges = (np.arange(1, int(SECONDS * speed)) + rng.normal(0, 0.002, int(SECONDS * speed) - 1)) / speed
        pulses = np.interp(
            TIME, np.ravel(edges[:, None] + [-1e-4, 1e-4, 2e-3, 2.2e-3]), np.tile([0.0, 1, 1, 0], edges.size)
        )
        estimate, _ = found(pulses)
        inside += estimate.low_hz <= speed <= estimate.high_hz
    assert inside >= 88


# --- no train -------------------------------------------------------------------------------------------------

NO_TRAINS = {
    "zeros": np.zeros(5000),
    "constant": np.full(5000, 4.9),
    "noise": np.random.default_rng(6).normal(size=50_000),
    "noise above the limit": train(steady(24.71)) + np.random.default_rng(7).normal(0, 0.2, TIME.size),
    "two pulses": train(0.5 * TIME + 0.3),
    "one step": (TIME > 1.0).astype(float),
    "irregular": np.isin(np.arange(50_000), np.random.default_rng(8).choice(50_000, 300)).astype(float),
    "one sample": np.array([1.0]),
}


@pytest.mark.parametrize("name", NO_TRAINS)
def test_what_is_no_train_gives_none(name):
    assert speed_from_tacho(NO_TRAINS[name], rate_hz=RATE) is None


def test_pulse_times_of_silence_are_empty():
    assert pulse_times(np.zeros(100), rate_hz=RATE).shape == (0,)


@pytest.mark.parametrize("per_turn", [0.0, -1.0])
def test_pulses_per_revolution_must_be_above_zero(per_turn):
    with pytest.raises(InvalidValueError, match="allowed: above 0"):
        speed_from_tacho(train(steady(24.71)), rate_hz=RATE, pulses_per_revolution=per_turn)


@given(speed=st.floats(1.5, 300), share=st.floats(0.02, 0.6))
@settings(max_examples=15, deadline=None)
def test_any_speed_and_pulse_width(speed, share):
    estimate, _ = found(train(steady(speed), duty=share))
    assert estimate.speed_hz == pytest.approx(speed, rel=1e-3)
    assert math.isfinite(estimate.variation)
