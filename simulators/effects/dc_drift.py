"""DC drift: an offset, and one that dies out slowly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..effect import Line, SensorEffect
from ..parameter import LogNormal, Normal, parameter

if TYPE_CHECKING:
    from ..machine import Machine
    from ..sensor_record import SensorRecord


@dataclass(frozen=True, kw_only=True)
class DcDrift(SensorEffect):
    """o + d exp(-t / tau), in shares of the measuring range: a wrong zero, and a sensor or amplifier warming up.

    It does not depend on speed or load. Integrated to velocity the drift becomes a large slow wave, which is how it is
    mostly met. Left out: offsets that a strong vibration causes (rectification in the amplifier).
    """

    NAME = "dc_drift"
    LINK = "transducer"
    MEANING = "The zero of the signal is off, and creeps after switching on or after a change of temperature."
    CHECK = "Does the mean of the record move when nothing is changed? Was the sensor given time to warm up?"
    RIVALS = {
        "gravity": "the mean moves with time at one speed; sag does not",
        "clipping": "one-sided cutting goes with the offset when the gain stays",
    }
    REFERENCES = (
        "M. Serridge and T. R. Licht, Piezoelectric Accelerometers and Vibration Preamplifiers, Bruel & Kjaer 1987",
    )

    offset: float = parameter(
        unit="",
        bounds=(-2.0, 2.0),
        zero=0.0,
        prior=Normal(0.2, 0.2),
        meaning="standing offset over the channel's measuring range",
        source="estimate; the sign is a guess",
    )
    drift: float = parameter(
        unit="",
        bounds=(-5.0, 5.0),
        zero=0.0,
        prior=Normal(0.5, 0.5),
        meaning="further offset at the first sample, over the measuring range; it dies out",
        source="estimate: a piezoelectric sensor touched with a warm hand; the sign is a guess",
    )
    time_constant_s: float = parameter(
        unit="s",
        bounds=(0.05, 1e4),
        prior=LogNormal(10.0, 3.0),
        meaning="time after which 37 % of the drift is left",
        source="estimate: seconds for a sensor, minutes for an amplifier",
    )

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Add offset and drift to the chosen channels."""
        if self.offset == 0 and self.drift == 0:
            return record
        rows = self.chosen(record.channels)
        signals = record.signals.copy()
        moved = self.offset + self.drift * np.exp(-record.time_s / self.time_constant_s)
        signals[rows] += record.full_scale[rows, None] * moved
        return record.with_signals(signals)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the mean."""
        return (Line(0.0, "any", speed_exponent=0.0, load_exponent=0.0),)
