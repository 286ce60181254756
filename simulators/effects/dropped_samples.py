"""Dropped samples: the recorder misses stretches of the signal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..effect import Line, SensorEffect
from ..parameter import LogNormal, parameter

if TYPE_CHECKING:
    from ..machine import Machine
    from ..sensor_record import SensorRecord


@dataclass(frozen=True, kw_only=True)
class DroppedSamples(SensorEffect):
    """Gaps of one length, one somewhere in each stretch of gap / share: the last value is held on all chosen channels.

    Each step at a gap's end is broad-band: the floor rises and an envelope shows impacts that follow no speed. Their
    number depends on the recorder, not on speed or load. Left out: recorders that leave the stretch out and so move all
    that follows, or write zeros.
    """

    NAME = "dropped_samples"
    LINK = "recorder"
    MEANING = "The recorder or its connection loses blocks of samples and holds the last value."
    CHECK = "Does the record hold runs of equal values? Do the recorder's counters show lost packets?"
    RIVALS = {
        "clipping": "runs of equal values at any level, not at the largest",
        "clock_error": "single jumps instead of a steady drift",
    }
    REFERENCES = (
        "S. Baisch and G. H. R. Bokelmann, Spectral analysis with incomplete time series: an example from seismology, "
        "Computers & Geosciences 25 (1999) 739-750",
    )

    share: float = parameter(
        unit="",
        bounds=(0.0, 0.5),
        zero=0.0,
        prior=LogNormal(0.02, 2.0),
        meaning="share of the time that is lost",
        source="estimate: a wireless link that begins to fail",
    )
    gap_s: float = parameter(
        unit="s",
        bounds=(1e-5, 1.0),
        prior=LogNormal(0.005, 3.0),
        meaning="length of one gap, rounded to whole samples, at least one",
        source="estimate: one packet of 64 samples at 12.8 kHz",
    )

    @property
    def is_random(self) -> bool:
        """Whether anything is lost."""
        return self.share > 0

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Hold the last value in the gaps."""
        if self.share == 0:
            return record
        count = record.signals.shape[1]
        length = max(1, round(self.gap_s * record.rate_hz))
        stretch = length / self.share
        first = stretch * np.arange(math.ceil(count / stretch))
        starts = np.floor(first + generator.random(first.size) * (stretch - length)).astype(int)
        good = np.ones(count + length, dtype=bool)
        good[np.minimum(starts[:, None] + np.arange(length), count)] = False
        good = good[:count]
        good[0] = True
        held = np.maximum.accumulate(np.where(good, np.arange(count), 0))
        rows = self.chosen(record.channels)
        signals = record.signals.copy()
        signals[rows] = signals[rows][:, held]
        return record.with_signals(signals)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return no line: the floor rises."""
        return ()
