"""Synchronous averages of the gears of an observation, locked to the tooth mesh, with their condition indicators."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ..datasets.recording import GearPair
from .observe import Observation
from .signal.order_tracking import constant_speed_phase
from .signal.synchronous_average import (
    GearIndicators,
    gear_indicators,
    phase_locked_to_mesh,
    residual_signal,
    synchronous_average,
)

_MESH_HARMONICS = 4.5
_LEAST_TURNS = 10
_BANDWIDTH = 0.1  # over the slower shaft's speed


@dataclass(frozen=True)
class GearAverage:
    """One gear on one channel.

    Attributes
    ----------
    gear : str
    ratio : float
        Speed of its shaft over the reference speed.
    channel, turns : int
    indicators : GearIndicators
    deviation : float
        Standard deviation that the kurtosis of noise has in such an average, sqrt(24 / n) with two independent values
        an order.
    repeated : float
        Largest residual over the standard deviation that it has there from the scatter of the turns. What strikes in
        any one turn, as a bearing does, leaves about 1, and sqrt(k) where k strikes happen to meet.
    """

    gear: str
    ratio: float
    channel: int
    turns: int
    indicators: GearIndicators
    deviation: float
    repeated: float


_KNOWN: WeakKeyDictionary[Observation, tuple[GearAverage, ...]] = WeakKeyDictionary()


def gear_averages(now: Observation) -> tuple[GearAverage, ...]:
    """Return the averages of all gears on all channels; empty where no mesh line stands out of the noise.

    Parameters
    ----------
    now : Observation
        With a speed. A record that a tacho has brought to equal angles is at constant speed already.
    """
    if now not in _KNOWN:
        # Rules and features both ask.
        _KNOWN[now] = tuple(one for gear in now.recording.nameplate.gears for one in _of_pair(now, gear))
    return _KNOWN[now]


def _of_pair(now: Observation, gear: GearPair) -> list[GearAverage]:
    both = ((gear.driver_ratio, gear.driver_teeth), (gear.driven_ratio, gear.driven_teeth))
    sides = [(ratio, teeth) for ratio, teeth in both if ratio is not None and teeth is not None]
    phase = _locked_phase(now, gear, min(ratio for ratio, _ in sides))
    if phase is None:
        return []
    found = []
    for ratio, teeth in sides:
        highest = min(_MESH_HARMONICS * teeth, 0.4 * now.recording.rate_hz / (now.speed_hz * ratio))
        if highest < 1.5 * teeth or ratio * (phase[-1] - phase[0]) < _LEAST_TURNS:
            continue
        average = synchronous_average(now.recording.signals, phase_turns=ratio * phase, highest_order=highest)
        deviation = float(np.sqrt(24.0 / (2.0 * highest)))
        name = f"{teeth}-tooth gear"
        found += [
            GearAverage(
                name,
                ratio,
                channel,
                average.turns,
                gear_indicators(row, teeth=teeth),
                deviation,
                _repeated(row, average.deviation[channel], teeth),
            )
            for channel, row in enumerate(average.average)
        ]
    return found


def _repeated(average: np.ndarray, deviation: np.ndarray, teeth: int) -> float:
    """Return how far the largest sample of the residual signal stands above its own scatter over the turns."""
    residual = np.abs(residual_signal(average, teeth=teeth))
    place = int(np.argmax(residual))
    return float(residual[place] / max(float(deviation[place]), np.finfo(float).tiny))


def _locked_phase(now: Observation, gear: GearPair, slowest_ratio: float) -> np.ndarray | None:
    """Return the reference shaft's angle as the mesh tells it; None where no mesh line stands out or it is lost."""
    recording = now.recording
    if now.speed is None or gear.mesh_order * now.speed_hz > 0.45 * recording.rate_hz:
        return None
    lines = [now.line(gear.mesh_order, channel=channel) for channel in range(now.channel_count)]
    if not any(now.is_significant(line) for line in lines):
        return None
    steady = constant_speed_phase(samples=recording.samples, rate_hz=recording.rate_hz, speed_hz=now.speed_hz)
    phase = phase_locked_to_mesh(
        recording.signals,
        rate_hz=recording.rate_hz,
        phase_turns=steady,
        mesh_order=gear.mesh_order,
        bandwidth_hz=_BANDWIDTH * slowest_ratio * now.speed_hz,
    )
    return None if np.any(np.diff(phase) <= 0) else phase
