"""What rose and no rule names: it is told, with its place, size and channel; what did not rise is not."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, Nameplate, OperatingCondition, Recording
from rotorwise.diagnose import Analysis, analyse_recording
from rotorwise.diagnose.compare import risen_db
from rotorwise.diagnose.evidence import LEAST_PROBABILITY

RATE_HZ, SPEED_HZ, SECONDS = 5000.0, 48.3, 4.0
PROBES = ("a", "b", "c", "d")
Probes = Callable[..., Recording]


def tones(sizes: dict[float, float], seed: int) -> np.ndarray:
    """Return lines of these amplitudes in um at these frequencies in Hz, random phase, in metres."""
    time = np.arange(int(RATE_HZ * SECONDS)) / RATE_HZ
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(sizes))
    signal = np.zeros(time.size)
    for (frequency_hz, size), phase in zip(sizes.items(), phases, strict=True):
        signal += 1e-6 * size * np.cos(2 * np.pi * frequency_hz * time + phase)
    return signal


def probes(one: tuple[float, ...], extra: dict[float, float] | None = None, seed: int = 0) -> Recording:
    """Return shaft probes with 1X of these amplitudes in um, further lines on the last one, and noise of 0.05 um."""
    noise = 5e-8 * np.random.default_rng(seed + 99).normal(size=(len(one), int(RATE_HZ * SECONDS)))
    rows = [tones({SPEED_HZ: size, 2 * SPEED_HZ: 0.03 * size}, seed + index) for index, size in enumerate(one)]
    rows[-1] = rows[-1] + tones(extra or {}, seed + 50)
    channels = tuple(Channel(name, "displacement", "bearing", None, "um") for name in PROBES[: len(one)])
    return Recording(np.array(rows) + noise, RATE_HZ, channels, OperatingCondition(60 * SPEED_HZ), Nameplate())


def told(analysis: Analysis, words: str) -> bool:
    return any(words in text for text in analysis.warnings)


def stated(analysis: Analysis, fault: str) -> float:
    return next((one.probability for one in analysis.findings if one.fault == fault), 0.0)


EVEN = (20.0, 24.0, 22.0, 25.0)


@pytest.mark.parametrize("count", [1, 2, 4, 12])
def test_a_rise_read_from_the_channels_that_rose_most_is_not_overrated(count: int) -> None:
    """Where nothing rose, the chance of 2 s or more is no larger than one channel's, 2.3 %."""
    random = np.random.default_rng(count)
    rises = np.array([risen_db(4.0 * random.normal(size=count), 4.0)[0] for _ in range(4000)])
    one_channel = 0.5 * math.erfc(2 / math.sqrt(2))
    assert (rises > 8.0).mean() < one_channel + 3 * math.sqrt(one_channel / 4000)


def test_1x_that_rose_on_two_probes_and_fell_on_two_is_found() -> None:
    """A force at one place of a shaft may do so; the median of these changes is below 1 dB."""
    analysis = analyse_recording(probes((160.0, 192.0, 11.0, 12.5)), baseline=probes(EVEN, seed=7))
    assert analysis.findings[0].fault == "unbalance"
    assert stated(analysis, "unbalance") > 0.25
    assert "1X rose most on a, b" in analysis.findings[0].summary


def test_1x_that_rose_on_two_probes_too_little_to_name_a_fault_is_told() -> None:
    """The level of probe a rises into another zone: silence, or a faint hint alone, would be wrong."""
    analysis = analyse_recording(probes((72.0, 86.0, 11.0, 12.5)), baseline=probes(EVEN, seed=7))
    assert all(one.probability < 0.5 for one in analysis.findings)
    assert told(analysis, "1X, 48.3 Hz, rose by 11 dB on")
    assert "Not explained: 1X" in analysis.verdict


def test_1x_that_rose_on_one_probe_alone_is_no_sure_unbalance() -> None:
    """A new force that leaves three of four probes as they were is rare; a support that changed is as likely."""
    alone = analyse_recording(probes((200.0, 24.0, 22.0, 25.0)), baseline=probes(EVEN, seed=7))
    everywhere = analyse_recording(probes((200.0, 240.0, 220.0, 250.0)), baseline=probes(EVEN, seed=7))
    assert 0.2 < stated(alone, "unbalance") < 0.5 < stated(everywhere, "unbalance")
    # Its 2X rose by no more than the 1X that drags it along.
    assert stated(alone, "misalignment") < stated(alone, "unbalance")


def test_1x_that_scattered_over_the_probes_is_nothing() -> None:
    """Changes of +5, -4, +3 and -5 dB: what re-mounting does."""
    analysis = analyse_recording(probes((35.6, 15.1, 31.1, 14.1)), baseline=probes(EVEN, seed=7))
    assert not analysis.findings
    assert not analysis.warnings


@pytest.mark.parametrize("frequency_hz", [37.0, 17.3, 71.0])
def test_a_new_line_beside_the_orders_is_told(frequency_hz: float) -> None:
    analysis = analyse_recording(probes(EVEN, {frequency_hz: 20.0}), baseline=probes(EVEN, seed=7))
    assert told(analysis, f"A line at {frequency_hz:g} Hz ({frequency_hz / SPEED_HZ:.3f}X, no order of the shaft) rose")
    assert told(analysis, "on d, from")
    assert told(analysis, "to 20 um") or told(analysis, "to 19.9 um") or told(analysis, "to 20.1 um")
    assert "Not explained: a line at" in analysis.verdict


def test_a_line_that_the_baseline_has_too_is_not_told() -> None:
    """With 1 % more speed in the baseline; the line stays where it is, as one of the mains would."""
    now, before = probes(EVEN, {37.0: 20.0}), probes(EVEN, {37.0: 14.0}, seed=7)
    assert not told(analyse_recording(now, baseline=before), "no likely finding accounts")


@pytest.mark.parametrize("seed", range(8))
def test_healthy_probes_are_silent(seed: int) -> None:
    analysis = analyse_recording(probes(EVEN, seed=seed), baseline=probes(EVEN, seed=100 + seed))
    assert not analysis.findings
    assert not analysis.warnings


def test_differences_with_1x_are_not_told_beside_their_source() -> None:
    source, image = 37.0, SPEED_HZ - 37.0
    analysis = analyse_recording(probes(EVEN, {source: 20.0, image: 12.0}), baseline=probes(EVEN, seed=7))
    assert told(analysis, f"A line at {source:g} Hz")
    assert not told(analysis, f"A line at {image:.4g} Hz")


def test_the_difference_of_a_stronger_line_and_1x_is_no_oil_whirl() -> None:
    """0.542X and 1X make a line at 0.458X where forces are not linear; only the larger of the two can be the source."""
    source, image = 0.542 * SPEED_HZ, 0.458 * SPEED_HZ
    healthy = probes(EVEN, seed=7)
    both = analyse_recording(probes(EVEN, {source: 48.0, image: 2.0}), baseline=healthy)
    assert stated(both, "oil_whirl") < LEAST_PROBABILITY
    assert told(both, f"A line at {source:.4g} Hz")
    whirl = analyse_recording(probes(EVEN, {source: 2.0, image: 48.0}), baseline=healthy)
    assert stated(whirl, "oil_whirl") > 0.5
    assert not told(whirl, "no likely finding accounts")


def test_a_level_in_zone_c_without_a_finding_is_not_called_no_fault() -> None:
    """A line that no rule names lifts the level; the answer must not read as if all were well."""
    analysis = analyse_recording(probes(EVEN, {37.0: 70.0}), baseline=probes(EVEN, seed=7))
    assert analysis.severity[0].zone in "CD"
    assert not analysis.findings
    assert "No fault is evident" not in analysis.verdict
    assert "no known fault explains it" in analysis.verdict
    assert "not significantly above" not in analysis.verdict
    always = probes(EVEN, {37.0: 70.0}, seed=7)
    assert (
        "not significantly above the baseline" in analyse_recording(probes(EVEN, {37.0: 70.0}), baseline=always).verdict
    )


def test_the_same_line_in_unknown_units_is_told_as_well() -> None:
    now, before = (
        replace(one, channels=tuple(Channel(name) for name in PROBES))
        for one in (probes(EVEN, {37.0: 20.0}), probes(EVEN, seed=7))
    )
    assert told(analyse_recording(now, baseline=before), "(unit unknown), and no likely finding accounts for it")
