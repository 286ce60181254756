"""Re-mounted sensor: it looks in a slightly different direction, with another gain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..effect import Line, SensorEffect
from ..parameter import Normal, parameter

if TYPE_CHECKING:
    from ..assembly import Probe
    from ..machine import Machine
    from ..sensor_record import SensorRecord


@dataclass(frozen=True, kw_only=True)
class RemountedSensor(SensorEffect):
    """x' = g (x cos a + y sin a), y' = g (y cos a - x sin a), then y and axial in the same way with the tilt b.

    All lines change by one factor, at every speed and load, with a little of each direction in the others: no machine
    fault does that. A direction in which nothing is recorded contributes nothing, its own channel keeps the cosine.
    Left out: a changed mounting resonance, which is an effect of its own, and the different place on the housing.
    """

    NAME = "remounted_sensor"
    LINK = "mounting"
    MEANING = "The sensor was taken off and put back, or replaced: other sensitivity, turned and tilted axes."
    CHECK = "Was the sensor or cable changed since the reference? Is the sensitivity set that of this serial number?"
    RIVALS = {
        "unbalance": "all lines change by one factor, 2X and the floor included; the other sensors do not change",
        "support_anisotropy": "ratio of directions changes equally in all lines and at all speeds; look at the sensor",
        "mounting_resonance": "one factor at all frequencies, not a band that rises",
    }
    REFERENCES = (
        "ISO 16063-21, Calibration of vibration transducers by comparison",
        "ISO 5348, Mechanical mounting of accelerometers",
    )

    gain_change: float = parameter(
        unit="",
        bounds=(-0.9, 2.0),
        zero=0.0,
        prior=Normal(0.05, 0.1),
        meaning="gain over the old one, less 1",
        source="estimate: industrial accelerometers keep 5 to 10 % of their nominal sensitivity; sign a guess",
    )
    rotation_rad: float = parameter(
        unit="rad",
        bounds=(-math.pi, math.pi),
        zero=0.0,
        prior=Normal(0.1, 0.1),
        meaning="angle a by which the sensor is turned about the shaft's axis, from x to y",
        source="estimate: 6 degrees when aligned by eye",
    )
    tilt_rad: float = parameter(
        unit="rad",
        bounds=(-math.pi, math.pi),
        zero=0.0,
        prior=Normal(0.05, 0.05),
        meaning="angle b from y to the axial direction",
        source="estimate: 3 degrees when seated on paint or a curved surface",
    )

    def fits(self, probe: Probe) -> bool:
        """Return whether the probe looks in a direction of space."""
        return probe.direction in ("x", "y", "axial")

    def chosen(self, probes: Sequence[Probe]) -> list[int]:
        """Return the channels of one sensor: all at the location named, or at the first one."""
        found = super().chosen(probes)
        where = probes[found[0]]
        return [
            i for i in found if self.at or (probes[i].location, probes[i].quantity) == (where.location, where.quantity)
        ]

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Turn and scale the sensor's channels."""
        signals = record.signals.copy()
        turn, tilt, gain = self.rotation_rad, self.tilt_rad, 1 + self.gain_change
        for i in self.chosen(record.channels):
            x, y, axial = (self._beside(record, i, direction) for direction in ("x", "y", "axial"))
            across = y * math.cos(turn) - x * math.sin(turn)
            signals[i] = (
                gain
                * {
                    "x": x * math.cos(turn) + y * math.sin(turn),
                    "y": across * math.cos(tilt) + axial * math.sin(tilt),
                    "axial": axial * math.cos(tilt) - across * math.sin(tilt),
                }[record.channels[i].direction]
            )
        return record.with_signals(signals)

    def _beside(self, record: SensorRecord, channel: int, direction: str) -> np.ndarray:
        """Return the signal in one direction at the place of a channel; zeros when there is none."""
        own = record.channels[channel]
        if own.direction == direction:
            return record.signals[channel]
        for i, other in enumerate(record.channels):
            if (other.location, other.quantity, other.direction) == (own.location, own.quantity, direction):
                return record.signals[i]
        return np.zeros(record.signals.shape[1])

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return no line: all lines change."""
        return ()
