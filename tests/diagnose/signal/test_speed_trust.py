"""A wrong speed is not sure: combs that are not the shaft's, ranges that the shaft's speed is not in.

Seeds, ratios and numbers of teeth are none of those that the limits were chosen on (tests/benchmarks/speed_trust.py).
"""

from __future__ import annotations

import numpy as np
import pytest
from rotorwise.diagnose.signal.speed_track import track_speed
from rotorwise.diagnose.signal.speed_trust import trust
from scipy.signal import lfilter

RATE = 10_000.0
TIME = np.arange(80_000) / RATE
SPEEDS = {"constant": np.full(TIME.size, 24.0), "run-up": 15 + 20 * TIME / TIME[-1]}


def comb(angle: np.ndarray, sizes: dict[float, float], rng: np.random.Generator) -> np.ndarray:
    return np.sum([a * np.cos(2 * np.pi * (n * angle + rng.uniform())) for n, a in sizes.items()], axis=0)


def impacts(angle: np.ndarray, ratio: float, rng: np.random.Generator) -> np.ndarray:
    """A defect passed `ratio` times a turn with 0.5 % slip, through resonances at 300 and 3000 Hz; unit rms."""
    places = np.cumsum(1 + 0.005 * rng.normal(size=int(ratio * angle[-1]) + 3)) / ratio
    places = np.searchsorted(angle, places)
    train = np.zeros(angle.size)
    train[places[places < angle.size]] = 1.0
    out = np.zeros(angle.size)
    for frequency_hz, decay in ((300.0, 0.98), (3000.0, 0.97)):
        turn = np.cos(2 * np.pi * frequency_hz / RATE)
        rung = lfilter([1.0], [1.0, -2 * decay * turn, decay**2], train)
        out += rung / rung.std()
    return out / out.std()


def tracked(signal: np.ndarray, speed: np.ndarray, **limits: float) -> tuple[float, float]:
    """Return the share of frames within 3 % and the median confidence."""
    found = track_speed(signal, rate_hz=RATE, **limits)
    wrong = np.abs(found.speed_hz / np.interp(found.time_s, TIME, speed) - 1)
    return float((wrong < 0.03).mean()), float(np.median(found.confidence))


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("ratio", [2.84, 3.29, 5.93])
@pytest.mark.parametrize("shaft", [0.0, 0.15])
def test_a_bearings_comb_is_not_the_shafts_for_certain(name, ratio, shaft):
    """Impacts with shaft lines far below them, or none: followed alone they gave a confidence of 1."""
    rng = np.random.default_rng(9100)
    angle = np.cumsum(SPEEDS[name]) / RATE
    signal = impacts(angle, ratio, rng) + comb(angle, {1: shaft, 2: 0.6 * shaft}, rng) + rng.normal(0, 0.4, angle.size)
    right, confidence = tracked(signal, SPEEDS[name])
    assert right > 0.5 or confidence < 0.5


@pytest.mark.parametrize("teeth", [15, 29])
def test_a_mesh_is_not_a_shaft(teeth):
    rng = np.random.default_rng(9200)
    angle = np.cumsum(SPEEDS["run-up"]) / RATE
    mesh = comb(teeth * angle, {1: 1.0, 2: 0.5, 3: 0.3}, rng) * (1 + 0.2 * np.cos(2 * np.pi * angle))
    right, confidence = tracked(mesh + rng.normal(0, 0.4, angle.size), SPEEDS["run-up"])
    assert right < 0.5
    assert confidence < 0.5


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("limits", [(0.2, 0.8), (0.3, 0.7), (1.25, 4.0), (1.4, 6.0)])
def test_a_range_without_the_speed_gives_no_confidence(name, limits):
    """Half, a third, twice, three times the speed lie in these: each gave 65 to 100 %."""
    rng = np.random.default_rng(9300)
    speed = SPEEDS[name]
    angle = np.cumsum(speed) / RATE
    signal = comb(angle, {1: 1, 2: 0.7, 3: 0.5, 4: 0.4, 5: 0.3}, rng) + rng.normal(0, 0.5, angle.size)
    low, high = limits[0] * (speed.min() if limits[0] < 1 else speed.max()), limits[1] * speed.max()
    high = min(high, limits[1] * speed.min()) if limits[1] < 1 else high
    assert tracked(signal, speed, lowest_hz=low, highest_hz=high)[1] < 0.5


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("sizes", [{1: 1, 2: 0.5, 3: 0.3}, {1: 0.3, 2: 1, 3: 0.2, 4: 0.5}])
def test_the_shafts_own_comb_stays_sure(name, sizes):
    """Three harmonics, or a strong second one: the doubt must not fall on these."""
    rng = np.random.default_rng(9400)
    angle = np.cumsum(SPEEDS[name]) / RATE
    right, confidence = tracked(
        comb(angle, sizes, rng) + rng.normal(0, 0.4, angle.size), SPEEDS[name], lowest_hz=10.0, highest_hz=60.0
    )
    assert right > 0.95
    assert confidence > 0.6


def test_a_half_order_leaves_two_speeds():
    """Every second harmonic strong, or a shaft of twice the speed with a half order: the lines are the same."""
    rng = np.random.default_rng(9400)
    angle = np.cumsum(SPEEDS["constant"]) / RATE
    signal = comb(angle, {0.5: 0.1, 1: 1, 2: 0.6, 3: 0.5, 4: 0.4, 5: 0.3}, rng) + rng.normal(0, 0.4, angle.size)
    assert 0.2 < tracked(signal, SPEEDS["constant"], lowest_hz=10.0, highest_hz=60.0)[1] < 0.8


@pytest.mark.parametrize("factor", [0.5, 2.0, 3.0, 1 / 3])
def test_an_angle_that_is_a_multiple_of_the_shafts_is_seen(factor):
    """Told the angle itself: the shaft's is believed, a multiple of it is not."""
    rng = np.random.default_rng(9500)
    angle = np.cumsum(SPEEDS["run-up"]) / RATE
    signal = (comb(angle, {1: 1, 2: 0.8, 3: 0.6, 4: 0.4}, rng) + rng.normal(0, 0.5, angle.size))[None]
    options = {"rate_hz": RATE, "range_hz": (4.0, 500.0)}
    assert min(one.chance for one in trust(signal, phase_turns=angle, **options)) > 0.8
    assert max(one.chance for one in trust(signal, phase_turns=factor * angle, **options)) < 0.1


def test_an_angle_that_turns_back_is_not_believed():
    angle = 24 * TIME
    angle[40_000:] -= 1.0
    pieces = trust(np.ones((1, TIME.size)), rate_hz=RATE, phase_turns=angle, range_hz=(4.0, 500.0))
    assert min(one.chance for one in pieces) == 0.0


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("ratio", [2.84, 3.29])
def test_the_shaft_is_followed_where_all_of_the_record_shows_it_beside_a_strong_bearing(name, ratio):
    """Its two lines have a seventh of the bearing's amplitude: hardly seen in a piece of the record."""
    rng = np.random.default_rng(9600)
    angle = np.cumsum(SPEEDS[name]) / RATE
    lines = 0.15 * comb(angle, {1: 1, 2: 0.7}, rng)
    signal = impacts(angle, ratio, rng) + lines + rng.normal(0, 0.5, angle.size)
    found = track_speed(signal, rate_hz=RATE, lowest_hz=4.0, highest_hz=500.0)
    wrong = np.abs(found.speed_hz / np.interp(found.time_s, TIME, SPEEDS[name]) - 1)
    assert (wrong < 0.03).mean() > 0.8
    assert found.phase_turns[-1] - found.phase_turns[0] == pytest.approx(angle[-1] - angle[0], rel=0.01)


def test_a_shaft_outside_the_speeds_looked_for_is_not_followed():
    rng = np.random.default_rng(9601)
    angle = np.cumsum(SPEEDS["constant"]) / RATE
    signal = impacts(angle, 3.29, rng) + 0.15 * comb(angle, {1: 1, 2: 0.7}, rng) + rng.normal(0, 0.5, angle.size)
    found = track_speed(signal, rate_hz=RATE, lowest_hz=36.0, highest_hz=500.0)
    assert found.speed_hz.min() > 35.0
    assert np.median(found.confidence) < 0.5
