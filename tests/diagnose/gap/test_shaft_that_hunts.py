"""A shaft that hunts by less than a sample makes no lines beside its orders: its tacho's edges tell where it is."""

import math

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, OperatingCondition, Recording
from rotorwise.diagnose.gap.lines import LineKind
from rotorwise.diagnose.gap.observe import observe_orders, shaft_turns
from scipy.signal import butter, sosfilt

RATE_HZ, SECONDS, FINER, SPEED_HZ = 2048.0, 4.7, 16, 13.1
#: Of the shaft's angle, radians, at a hertz: 0.6 samples of the tacho, 0.2 % of the speed.
HUNTS_RAD = 0.025
BESIDE_HZ = (-1.0, 1.0)


def record(hunts_rad: float) -> tuple[Recording, np.ndarray]:
    """Return 1X and 2X with a tacho behind an anti-alias filter, and the true turns at every sample."""
    time = np.arange(int(RATE_HZ * SECONDS) * FINER) / (RATE_HZ * FINER)
    turns = 0.3 + SPEED_HZ * time + hunts_rad / (2 * math.pi) * np.sin(2 * math.pi * time)
    pulses = 5.0 * (turns % 1.0 < 0.06)
    seen = np.stack([np.cos(2 * math.pi * turns) + 0.2 * np.cos(4 * math.pi * turns + 0.4), pulses])
    filtered = sosfilt(butter(4, 0.4 * RATE_HZ, fs=RATE_HZ * FINER, output="sos"), seen, axis=1)[:, ::FINER]
    filtered += np.random.default_rng(1).normal(0, 1, filtered.shape) * [[2e-3], [0.02]]
    channels = (Channel(name="a", quantity="displacement"), Channel(name="tacho", quantity="tacho"))
    made = Recording(
        filtered, RATE_HZ, channels, OperatingCondition(speed_rpm=60 * SPEED_HZ), pulses_per_revolution=1.0
    )
    return made, turns[::FINER]


@pytest.mark.parametrize("hunts_rad", [0.0, HUNTS_RAD])
def test_its_sidebands_are_not_seen(hunts_rad: float) -> None:
    made, turns = record(hunts_rad)
    away = shaft_turns(made) - turns
    # A tenth of a sample; the mean is the zero of the tacho's pulse, and the filter's delay.
    assert float((away - away.mean())[200:-200].std()) < 0.1 * SPEED_HZ / RATE_HZ
    kinds = (LineKind(), LineKind(), *(LineKind(phase=False, frequency_hz=added) for added in BESIDE_HZ))
    (found,) = observe_orders([made], orders=(1.0, 2.0, 1.0, 1.0), channels={"a": "a"}, kinds=kinds)
    first, second, *beside = np.abs(found.amplitudes[0, 0])
    assert first == pytest.approx(1.0, rel=2e-3)
    assert second == pytest.approx(0.2, rel=5e-3)
    # Followed by a steady law they are half of what the angle moves: 0.0125 each.
    assert max(beside) < 2e-3


def test_the_law_of_a_steady_shaft_is_as_smooth_as_before() -> None:
    made, _ = record(0.0)
    bends = np.diff(shaft_turns(made), 3)
    # A cubic: its third differences are one constant.
    assert np.ptp(bends) < 1e-9
