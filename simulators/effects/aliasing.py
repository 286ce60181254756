"""Aliasing: what lies above half the sampling rate folds back."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..effect import Line, SensorEffect
from ..parameter import Uniform, parameter

if TYPE_CHECKING:
    import numpy as np

    from ..machine import Machine
    from ..sensor_record import SensorRecord


@dataclass(frozen=True, kw_only=True)
class Aliasing(SensorEffect):
    """A share of what lies above half the sampling rate passes the anti-alias filter; f then shows at |f - k rate|.

    A folded line moves backwards when the speed rises, or sits at an odd place; with speed and load it grows as its
    source does. The
    machine is simulated at a higher rate for this, up to ``highest_hz``. Left out: the filter's own phase, and noise
    from above, which the simulated machine has not.
    """

    NAME = "aliasing"
    LINK = "filter"
    MEANING = "The anti-alias filter is missing or set too high: high frequencies show up folded as low ones."
    CHECK = "Does the line move when the sampling rate is changed? Is there a filter below half the sampling rate?"
    RIVALS = {
        "mounting_resonance": "another sampling rate: folded lines move, a resonance stays",
        "clock_error": "another sampling rate: only folded lines move",
    }
    REFERENCES = ("C. E. Shannon, Communication in the presence of noise, Proc. IRE 37 (1949) 10-21",)

    leak: float = parameter(
        unit="",
        bounds=(0.0, 1.0),
        zero=0.0,
        prior=Uniform(0.1, 1.0),
        meaning="share of the amplitude above half the rate that passes; 1 is no filter at all",
        source="estimate: a first-order filter a decade below passes 0.1",
    )
    highest_hz: float = parameter(
        unit="Hz",
        bounds=(100.0, 3e4),
        default=1e4,
        meaning="highest frequency that the sensor brings to the converter; longer computing time for more",
        source="data sheets: industrial accelerometers reach 10 kHz",
    )

    def demand(self, *, rate_hz: float, duration_s: float) -> tuple[int, float]:
        """Return the multiple of the output rate whose record is flat up to the highest frequency."""
        if self.leak == 0:
            return 1, 0.0
        return max(2, math.ceil(self.highest_hz / (0.4 * rate_hz))), 0.0

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Let the filter of the chosen channels leak; two leaks let more through, never more than all."""
        leak = record.leak.copy()
        rows = self.chosen(record.channels)
        leak[rows] = 1 - (1 - leak[rows]) * (1 - self.leak)
        return replace(record, leak=leak)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return no line: which lines fold, and where to, depends on the sampling rate."""
        return ()
