"""Clipping: the signal is larger than the input range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..effect import Line, SensorEffect
from ..parameter import Uniform, parameter

if TYPE_CHECKING:
    from ..machine import Machine
    from ..sensor_record import SensorRecord


@dataclass(frozen=True, kw_only=True)
class Clipping(SensorEffect):
    """Values farther than (1 - lost) x measuring range from the middle of the range are cut to it.

    A cut sine has odd harmonics only; with a mean or a second line even ones come as well. The cut-off peaks grow with
    the signal: more speed or load, more clipping. The cut is made after the anti-alias filter, at the converter, so
    that its harmonics fold back as in the real one. Left out: an overloaded amplifier in front of the filter, and how
    long it takes to recover.
    """

    NAME = "clipping"
    LINK = "converter"
    MEANING = "The signal is larger than the range of amplifier or converter; its peaks are cut flat."
    CHECK = "Does the record touch the same highest value again and again? Measure again with a lower gain."
    RIVALS = {
        "quantisation": "a gain step: lower gain removes clipping and worsens quantisation",
        "coupling_misalignment": "2X and 3X that go when the gain is lowered are no misalignment",
    }
    REFERENCES = ("R. B. Randall, Vibration-based Condition Monitoring, Wiley 2011",)

    lost_range: float = parameter(
        unit="",
        bounds=(0.0, 0.99),
        zero=0.0,
        prior=Uniform(0.1, 0.7),
        meaning="share of the measuring range that is missing; that range is the record's own unless a chain states it",
        source="estimate: a gain set one step of 2 too high leaves half of the range",
    )

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Cut the chosen channels."""
        if self.lost_range == 0:
            return record
        rows = self.chosen(record.channels)
        end = (1 - self.lost_range) * record.full_scale[rows, None]
        signals = record.signals.copy()
        middle = record.middle[rows, None]
        signals[rows] = np.clip(signals[rows], middle - end, middle + end)
        return record.with_signals(signals)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the third harmonic of 1X; other strong lines get theirs as well."""
        return (Line(3.0, "any"),)
