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

    def mixing(self, channels: Sequence[Probe]) -> np.ndarray:
        """Return what each channel of the sensor shows of the three directions at its place."""
        matrix = np.eye(len(channels))
        turn, tilt, gain = self.rotation_rad, self.tilt_rad, 1 + self.gain_change
        across = {"x": -math.sin(turn), "y": math.cos(turn)}
        shown = {
            "x": {"x": math.cos(turn), "y": math.sin(turn)},
            "y": {one: share * math.cos(tilt) for one, share in across.items()} | {"axial": math.sin(tilt)},
            "axial": {one: -share * math.sin(tilt) for one, share in across.items()} | {"axial": math.cos(tilt)},
        }
        for row in self.chosen(channels):
            matrix[row] = 0.0
            for direction, share in shown[channels[row].direction].items():
                for column in _beside(channels, row, direction):
                    matrix[row, column] = gain * share
        return matrix

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Turn and scale the sensor's channels."""
        return record.with_signals(self.mixing(record.channels) @ record.signals)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return no line: all lines change."""
        return ()


def _beside(channels: Sequence[Probe], row: int, direction: str) -> list[int]:
    """Return the channel that shows one direction at the place of another one; none where nothing does."""
    own = channels[row]
    if own.direction == direction:
        return [row]
    alike = (own.location, own.quantity, direction)
    return [i for i, other in enumerate(channels) if (other.location, other.quantity, other.direction) == alike][:1]
