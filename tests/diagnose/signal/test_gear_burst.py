"""A damaged tooth in a recording without a tacho: features and finding, against sound, worn and eccentric gears."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, GearPair, Nameplate, OperatingCondition, Recording
from rotorwise.diagnose.faults.gear_burst import judge
from rotorwise.diagnose.features import features
from rotorwise.diagnose.gear_average import gear_averages
from rotorwise.diagnose.observe import observe

RATE = 10_000.0
TIME = np.arange(60_000) / RATE
PINION, TEETH, WHEEL_TEETH = 24.7, 21, 53


def recording(
    *, burst: float = 0.0, eccentricity: float = 0.0, mesh: float = 1.0, noise: float = 0.5, seed: int = 0
) -> Recording:
    """A pair of gears whose speed wanders by 0.05 %; the burst sits on one tooth of the pinion."""
    angle = PINION * TIME + 0.005 * np.sin(2 * np.pi * 0.3 * TIME)
    modulation = 1 + eccentricity * np.cos(2 * np.pi * angle)
    teeth = mesh * sum(np.cos(2 * np.pi * TEETH * k * angle + k) / k for k in (1, 2, 3)) * modulation
    place = (angle % 1.0 - 0.5) * TEETH
    strike = burst * np.exp(-(place**2) / 0.3) * np.cos(2 * np.pi * 55 * angle)
    low = sum(np.cos(2 * np.pi * k * angle) for k in (1, 2))
    rng = np.random.default_rng(seed)
    signals = np.stack([gain * (teeth + strike) + low + rng.normal(0, noise, TIME.size) for gain in (1.0, 0.7)])
    channels = tuple(Channel(name, "acceleration", "gearbox", name) for name in ("horizontal", "vertical"))
    plate = Nameplate(gears=(GearPair(TEETH, WHEEL_TEETH),))
    return Recording(signals, RATE, channels, OperatingCondition(60 * PINION), plate)


def with_strikes(order: float, depth: float) -> Recording:
    """The sound pair, and a bearing that strikes hard at an order of the pinion, with slip, once a pinion turn harder.

    The strikes that stray into one part of the average are few, so that what is left of them is no noise.
    """
    sound = recording()
    angle = PINION * TIME + 0.005 * np.sin(2 * np.pi * 0.3 * TIME)
    rng = np.random.default_rng(5)
    signals = sound.signals.copy()
    wander = np.cumsum(rng.normal(0, 1e-5, TIME.size))
    phase = (order * angle + wander) % 1.0
    for row in range(2):
        loud = 1 + np.cos(2 * np.pi * angle)
        signals[row] += depth * loud * np.exp(-phase / 0.02) * np.sin(2 * np.pi * 1300.0 * TIME)
    return replace(sound, signals=signals)


def burst_of(changes: dict, baseline: dict | None = None) -> float:
    found = judge(observe(recording(**changes)), None if baseline is None else observe(recording(seed=1, **baseline)))
    return max((one.probability for one in found), default=0.0)


def test_the_gear_with_the_bad_tooth_is_named():
    now = observe(recording(burst=3.0))
    (finding,) = judge(now, None)
    assert finding.fault == "gear_tooth_fault"
    assert finding.probability > 0.5
    assert f"{TEETH}-tooth gear" in finding.summary
    values = features(now)
    # The burst fills about one tooth in 21.
    assert values["gear_na4"] > 8
    assert values["gear_fm4"] > 8


@pytest.mark.parametrize("changes", [{}, {"eccentricity": 0.4}, {"mesh": 4.0}, {"noise": 2.0, "seed": 3}])
def test_sound_eccentric_and_worn_gears_have_no_burst(changes):
    assert burst_of(changes) == 0.0
    # Largest of four averages of noise with deviations of 0.35 and 0.22.
    assert features(observe(recording(**changes)))["gear_na4"] < 3 + 4 * 0.36


def test_bursts_in_noise_are_rare_and_never_likely():
    """Four averages a record; beyond four deviations of a skewed distribution lie a few in a thousand."""
    chances = [burst_of({"noise": 2.0, "seed": seed}) for seed in range(6)]
    assert sum(chance > 0 for chance in chances) <= 1
    assert max(chances) < 0.25


def test_a_burst_that_was_there_before_does_not_count():
    assert burst_of({"burst": 3.0}, {"burst": 3.0}) < 0.1
    assert burst_of({"burst": 3.0}, {}) > 0.8


def test_the_strikes_of_a_bearing_are_no_burst_of_a_tooth():
    """Inner-race impacts are harder where the race is loaded; their leftovers in the average do not repeat."""
    now = observe(with_strikes(4.43, 400.0))
    assert max(one.indicators.na4 for one in gear_averages(now)) > 4.5
    assert judge(now, None) == []
    assert judge(now, observe(recording(seed=1))) == []


def test_the_average_holds_though_no_tacho_is_there():
    averages = gear_averages(observe(recording(burst=3.0)))
    assert {one.gear for one in averages} == {f"{TEETH}-tooth gear", f"{WHEEL_TEETH}-tooth gear"}
    assert all(one.turns > 50 for one in averages)
    # A burst on the pinion is nowhere on the wheel, whose turn is no whole number of the pinion's.
    assert max(one.indicators.na4 for one in averages if one.gear.startswith(str(WHEEL_TEETH))) < 5


def test_without_a_mesh_line_or_a_gear_nothing_is_said():
    quiet = recording(mesh=0.0, noise=1.0)
    assert gear_averages(observe(quiet)) == ()
    assert judge(observe(quiet), None) == []
    assert np.isnan(features(observe(quiet))["gear_na4"])
