"""Mains hum: the supply's frequency and its multiples in the signal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..effect import Line, SensorEffect
from ..parameter import LogNormal, Uniform, parameter

if TYPE_CHECKING:
    from ..machine import Machine
    from ..sensor_record import SensorRecord


@dataclass(frozen=True, kw_only=True)
class MainsHum(SensorEffect):
    """a (cos(w t + psi) + h2 cos 2(w t + psi) + h3 cos 3(w t + psi)), w = 2 pi x supply frequency, on every channel.

    Fixed in Hz and in size, whatever speed and load do. Left out: pick-up that follows the motor's current.
    """

    NAME = "mains_hum"
    LINK = "cable"
    MEANING = "A ground loop or an unscreened cable adds the supply's frequency and its multiples to the signal."
    CHECK = "Do the lines stay when the machine stands still and the sensor is unplugged? Is the screen earthed twice?"
    RIVALS = {
        "twice_line_force": "stop the machine: hum stays; twice the supply only, without 1 and 3 times, is the motor",
        "unbalance": "speed sweep: hum stays at its frequency",
    }
    REFERENCES = ("H. W. Ott, Electromagnetic Compatibility Engineering, Wiley 2009",)

    amplitude: float = parameter(
        unit="",
        bounds=(0.0, 1.0),
        zero=0.0,
        prior=LogNormal(0.03, 3.0),
        meaning="amplitude of the supply's own frequency over the channel's measuring range",
        source="estimate: tens of millivolts of hum on a signal of one volt",
    )
    supply_hz: float = parameter(
        unit="Hz",
        bounds=(16.0, 400.0),
        default=50.0,
        meaning="frequency of the supply, 50 or 60 nearly everywhere",
        source="known from the country",
    )
    second: float = parameter(
        unit="",
        bounds=(0.0, 2.0),
        prior=Uniform(0.0, 0.6),
        meaning="second harmonic over the first",
        source="estimate: from rectifiers on one half-wave",
    )
    third: float = parameter(
        unit="",
        bounds=(0.0, 2.0),
        prior=Uniform(0.0, 1.0),
        meaning="third harmonic over the first",
        source="estimate: from magnetising currents of transformers",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="phase of the supply at the first sample",
        source="any angle is equally likely",
    )

    @property
    def adds_up_to_hz(self) -> float:
        """The third harmonic."""
        return 3 * self.supply_hz

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Add the hum to the chosen channels."""
        if self.amplitude == 0:
            return record
        angle = 2 * math.pi * self.supply_hz * record.time_s + self.angle_rad
        shares = enumerate((1.0, self.second, self.third), start=1)
        hum = self.amplitude * sum(share * np.cos(n * angle) for n, share in shares)
        rows = self.chosen(record.channels)
        signals = record.signals.copy()
        signals[rows] += record.full_scale[rows, None] * hum
        return record.with_signals(signals)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the supply's frequency and its multiples, strongest first."""
        shares = {1: 1.0, 2: self.second, 3: self.third}
        return tuple(
            Line(0.0, "any", speed_exponent=0.0, load_exponent=0.0, frequency_hz=n * self.supply_hz)
            for n in sorted(shares, key=lambda n: -shares[n])
            if shares[n] > 0
        )
