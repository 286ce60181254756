"""Quantisation: too few steps of the converter for the signal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Line, SensorEffect
from ..parameter import Uniform, parameter
from ..sensor_record import rounded

if TYPE_CHECKING:
    import numpy as np

    from ..machine import Machine
    from ..sensor_record import SensorRecord


@dataclass(frozen=True, kw_only=True)
class Quantisation(SensorEffect):
    """Values are rounded to steps of 2 x range / 2^bits: a noise of step / sqrt(12) rms.

    For a sine that fills the range the signal-to-noise ratio is 6.02 bits + 1.76 dB (Bennett 1948). The noise does not
    grow with speed or load; weak signals suffer most. With a slow or weak signal the error is no noise but harmonics.
    """

    NAME = "quantisation"
    LINK = "converter"
    MEANING = "The signal uses few of the converter's steps: gain too low, or a converter with few bits."
    CHECK = "How many different values does the record hold? Measure again with a higher gain."
    RIVALS = {"clipping": "a gain step: higher gain removes quantisation and brings clipping"}
    REFERENCES = (
        "W. R. Bennett, Spectra of quantized signals, Bell System Tech. J. 27 (1948) 446-472",
        "IEEE Std 1241, Terminology and Test Methods for Analog-to-Digital Converters",
    )

    bits: float = parameter(
        unit="",
        bounds=(1.0, 64.0),
        zero=64.0,
        prior=Uniform(5.0, 11.0),
        meaning="bits that the measuring range uses, need not be whole; 64 stands for no rounding",
        source="estimate: 12 bits, of which a gain set too low wastes 1 to 7",
    )

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Round the chosen channels."""
        if self.bits == 64.0:
            return record
        rows = self.chosen(record.channels)
        signals = record.signals.copy()
        signals[rows] = rounded(signals[rows], 2 * record.full_scale[rows, None] / 2**self.bits)
        return record.with_signals(signals)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return no line: the floor rises."""
        return ()
