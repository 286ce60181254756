"""Signals with a known truth for the tests of the diagnosis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, MountedBearing, Nameplate, OperatingCondition, Recording
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing
from rotorwise.simulators.synthetic_vibration import ImpactTrain, synthetic_vibration

SPEED_HZ = 24.6
RATE_HZ = 12_800.0
HEALTHY = {1: 0.3, 2: 0.12, 3: 0.06}


@dataclass(frozen=True)
class Machine:
    """What the synthetic machine does; every field has a quiet default."""

    lines: dict[float, float] = field(default_factory=lambda: dict(HEALTHY))
    impacts: tuple[ImpactTrain, ...] = ()
    noise_rms: float = 0.3
    seconds: float = 5.0
    speed_hz: float = SPEED_HZ
    rate_hz: float = RATE_HZ
    quantity: str | None = "acceleration"
    nameplate: Nameplate = field(
        default_factory=lambda: Nameplate(bearings=(MountedBearing(find_bearing("6205")),), line_frequency_hz=50.0)
    )
    hint_rpm: float | None = 1480.0
    seed: int = 0


Make = Callable[..., Recording]


@pytest.fixture
def make() -> Make:
    """Return a function that makes a two-channel recording of a machine."""

    def made(**changes: object) -> Recording:
        machine = Machine(**changes)  # pyright: ignore[reportArgumentType]
        signals = [
            synthetic_vibration(
                duration_s=machine.seconds,
                rate_hz=machine.rate_hz,
                speed_hz=machine.speed_hz,
                seed=10 * machine.seed + channel,
                shaft_lines={order: gain * value for order, value in machine.lines.items()},
                impacts=machine.impacts,
                noise_rms=machine.noise_rms,
            )
            for channel, gain in enumerate((1.0, 0.8))
        ]
        channels = tuple(Channel(name, machine.quantity, "drive end", name) for name in ("horizontal", "vertical"))
        return Recording(
            np.array(signals), machine.rate_hz, channels, OperatingCondition(machine.hint_rpm), machine.nameplate
        )

    return made
