"""Mounting resonance: an accelerometer on a soft mount."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Line, SensorEffect
from ..parameter import LogNormal, parameter
from ..sensor_record import filtered, resonance

if TYPE_CHECKING:
    import numpy as np

    from ..machine import Machine
    from ..sensor_record import SensorRecord


@dataclass(frozen=True, kw_only=True)
class MountingResonance(SensorEffect):
    """H = 1 / (1 - (f T)^2 + 2 i zeta f T): the sensor's mass on the spring of its mount, 1 / T the resonance.

    Raises everything near the resonance (by 1 / (2 zeta) on it), cuts what lies above, turns the phase by 90 degrees at
    it. Fixed in Hz: it does not move with speed and does not depend on load. Left out: the base's own compliance, and
    what lies above 0.4 of the output rate, which no record holds; a resonance there shows its lower flank only.
    """

    NAME = "mounting_resonance"
    LINK = "mounting"
    QUANTITIES = ("acceleration",)
    MEANING = "The accelerometer sits on a soft mount (magnet, hand-held probe, thick glue) and resonates on it."
    CHECK = "How is the sensor mounted? Does the peak move when it is mounted again, screwed instead of by magnet?"
    RIVALS = {
        "remounted_sensor": "a band that rises, not a gain at all frequencies; mount again with a stud",
        "aliasing": "speed sweep: the band stays at one frequency, folded lines move backwards",
    }
    REFERENCES = (
        "ISO 5348, Mechanical mounting of accelerometers",
        "M. Serridge and T. R. Licht, Piezoelectric Accelerometers and Vibration Preamplifiers, Bruel & Kjaer 1987",
    )

    resonance_period_s: float = parameter(
        unit="s",
        bounds=(0.0, 2e-3),
        zero=0.0,
        prior=LogNormal(2e-4, 2.0),
        meaning="1 / mounted resonance frequency: 2e-4 is 5 kHz; 0 is a rigid mount",
        source="Serridge and Licht: a small accelerometer has 30 kHz on a stud, 7 kHz on a magnet, 2 kHz held by hand",
    )
    damping_ratio: float = parameter(
        unit="",
        bounds=(0.005, 0.7),
        prior=LogNormal(0.05, 2.0),
        meaning="of the mounted resonance",
        source="estimate: dry metal contact 0.02, magnet or wax 0.1",
    )

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Pass the accelerometers' signals through the resonance."""
        if self.resonance_period_s == 0:
            return record
        rows = self.chosen(record.channels)
        signals = record.signals.copy()
        signals[rows] = filtered(
            signals[rows],
            record.rate_hz,
            lambda f: resonance(f, period_s=self.resonance_period_s, damping_ratio=self.damping_ratio),
        )
        return record.with_signals(signals)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return no line: what lies near the resonance, wherever that is, is raised."""
        return ()
