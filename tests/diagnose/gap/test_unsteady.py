"""A record that scatters far more than the healthy machine's has changed, though its lines say nothing."""

import math
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, OperatingCondition, Provenance, Recording
from rotorwise.diagnose.gap.unsteady import channels_of, unsteady, unsteady_words

RATE_HZ, SECONDS = 2_000.0, 4.0
NAMES = ("a", "b")


def record(speed_rpm: float, *, noise: float, seed: int, names: tuple[str, ...] = NAMES) -> Recording:
    """Return lines at 1X and 2X, large beside the noise."""
    generator = np.random.default_rng(seed)
    turn = 2 * math.pi * speed_rpm / 60 * np.arange(int(RATE_HZ * SECONDS)) / RATE_HZ
    lines = np.cos(turn) + 0.4 * np.cos(2 * turn)
    rows = [lines + noise * generator.normal(size=turn.size) for _ in names]
    channels = [Channel(name=name, quantity="acceleration") for name in names]
    return Recording(
        signals=np.array(rows),
        rate_hz=RATE_HZ,
        channels=tuple(channels),
        condition=OperatingCondition(speed_rpm=speed_rpm),
        provenance=Provenance(),
    )


SPEEDS_RPM = (1200.0, 1700.0, 2400.0)
HEALTHY = [record(speed, noise=0.01, seed=k) for k, speed in enumerate(SPEEDS_RPM)]


def test_power_between_the_lines_is_compared_with_the_healthy_records_near_in_speed() -> None:
    loud = record(1600.0, noise=0.2, seed=9)
    made = [record(1250.0, noise=0.01, seed=8), loud]
    (found,) = unsteady(made, (1250.0, 1600.0), HEALTHY, SPEEDS_RPM, NAMES)
    assert found.speed_rpm == 1600.0
    assert found.channels == ("a", "b")
    # White noise of 20 times the amplitude.
    assert found.louder_db == pytest.approx(20 * math.log10(20), abs=1.5)
    (said,) = unsteady_words([found])
    assert "1600 rpm" in said
    assert "26 dB" in said or "25 dB" in said or "27 dB" in said


def test_larger_lines_and_longer_records_are_no_scatter() -> None:
    louder = replace(HEALTHY[1], signals=HEALTHY[1].signals + 50 * record(1700.0, noise=0.0, seed=0).signals)
    assert unsteady([louder], [1700.0], HEALTHY, SPEEDS_RPM, NAMES) == ()
    short = replace(HEALTHY[1], signals=HEALTHY[1].signals[:, : HEALTHY[1].samples // 2])
    assert unsteady([short], [1700.0], HEALTHY, SPEEDS_RPM, NAMES) == ()


def test_without_healthy_records_near_in_speed_nothing_is_said() -> None:
    loud = record(1600.0, noise=0.5, seed=9)
    assert unsteady([loud], [1600.0], [], [], NAMES) == ()
    assert unsteady([loud], [1600.0], HEALTHY[2:], [2450.0], NAMES) == ()
    other = [record(1600.0, noise=0.01, seed=1, names=("c",))]
    assert unsteady([loud], [1600.0], other, [1600.0], NAMES) == ()
    silent = [replace(HEALTHY[1], signals=np.zeros_like(HEALTHY[1].signals))]
    assert unsteady([loud], [1600.0], silent, [1600.0], NAMES) == ()
    assert unsteady_words(()) == ()


def test_flaws_of_the_recorder_account_for_their_channels() -> None:
    found = unsteady([record(1600.0, noise=0.5, seed=9)], [1600.0], HEALTHY, SPEEDS_RPM, NAMES)
    assert channels_of(found, {}) == ("a", "b")
    assert channels_of(found, {"clipping": ("a",)}) == ("b",)
    # A speed that wanders fills the spectrum of all of them.
    assert channels_of(found, {"speed_wander": ()}) == ()
    assert channels_of((), {}) == ()
