"""What moves too slowly for a line: told by its share, not where it is fast, small, or usual."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.slow_sway import slow_sways, sway_words
from rotorwise.simulators import amb_rotor

from .made_campaigns import altered, recorded

SPEEDS_RPM = (1200.0, 1800.0, 2500.0, 3300.0)
HOW = {"rate_hz": 4000.0, "duration_s": 1.5}
NAMES = ["path_1", "path_2", "path_3", "path_4"]
ONLY = frozenset(("unbalance", "coupling_misalignment", "dc_drift", "load_fluctuation"))


@pytest.fixture(scope="module")
def real():
    return altered(amb_rotor, share=0.05, seed=3)


@pytest.fixture(scope="module")
def healthy(real):
    return recorded(real, SPEEDS_RPM, seed=1, **HOW)


@pytest.fixture(scope="module")
def sound(real):
    return recorded(real, SPEEDS_RPM, seed=21, **HOW)


def swaying(recordings, share, frequency_hz, *, phase=1.2):
    """Return recordings whose displacements sway by a share of their deviation, rms."""
    made = []
    for one in recordings:
        signals = one.signals.copy()
        time = np.arange(one.samples) / one.rate_hz
        for i, channel in enumerate(one.channels):
            if channel.name in NAMES:
                size = np.sqrt(2) * share * signals[i].std()
                signals[i] += size * np.cos(2 * np.pi * frequency_hz * time + phase)
        made.append(replace(one, signals=signals))
    return tuple(made)


def test_a_swing_of_less_than_three_periods_is_told_by_its_share(sound, healthy):
    found = slow_sways(swaying(sound, 0.3, 1.0), healthy, NAMES)
    assert [one.channel for one in found] == NAMES
    for one in found:
        # 1.5 periods under a Hann window: most of the power lies in the two lines looked at.
        assert one.share == pytest.approx(0.3, rel=0.25)
        assert one.growth > 4
        assert one.below_hz == pytest.approx(2.5 / 1.5)
    assert "sway more slowly" in sway_words(found)[0]


def test_what_is_fast_or_usual_or_small_is_none(sound, healthy):
    assert not slow_sways(sound, healthy, NAMES)
    assert not slow_sways(swaying(sound, 0.3, 9.0), healthy, NAMES)
    assert not slow_sways(swaying(sound, 0.3, 1.0), swaying(healthy, 0.2, 1.3), NAMES)
    assert not slow_sways(swaying(sound, 0.02, 1.0), healthy, NAMES)
    assert not slow_sways(swaying(sound, 0.3, 1.0)[:1] + sound[1:], healthy, NAMES)
    assert not slow_sways(swaying(sound, 0.3, 1.0), (), NAMES)
    assert sway_words(()) == ()


def test_a_machine_that_sways_is_not_called_sound(sound, healthy):
    answer = explain_gap(Campaign(swaying(sound, 0.3, 0.9), healthy), amb_rotor, only=ONLY)
    assert answer.kind == "unknown"
    assert set(answer.flawed) == set(NAMES)
    assert any("sway more slowly" in one for one in answer.remarks)
