"""Run-out: a proximity probe sees the shaft's surface, not its centre."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..effect import Line, SensorEffect
from ..parameter import LogNormal, Uniform, parameter

if TYPE_CHECKING:
    from ..assembly import Probe
    from ..machine import Machine
    from ..sensor_record import SensorRecord

HARMONICS = 8
#: Angle between successive leaves of many plants: multiples of it never line up.
GOLDEN_RAD = math.pi * (3 - math.sqrt(5))


@dataclass(frozen=True, kw_only=True)
class RunOut(SensorEffect):
    """r sum_n d^(n - 1) cos(n (phi - theta) + psi_n) on a probe that looks from the angle theta (x: 0, y: 90 degrees).

    The pattern belongs to the surface (scratches, magnetic spots, out-of-round): both probes read it, the second a
    quarter turn later, and it is the same at any speed and load, which is how slow roll finds it. The
    harmonics' angles are psi_n = psi + 2.4 (n^2 - 1) rad, the golden angle, so that the pattern is no single spike.
    Left out: the pattern's shift when the shaft moves along its axis.
    """

    NAME = "run_out"
    LINK = "surface"
    QUANTITIES = ("displacement",)
    MEANING = "Scratches, magnetic spots or an out-of-round track under a proximity probe look like vibration."
    CHECK = "What does the probe show at slow roll, when nothing vibrates? Was the probe track burnished and degaussed?"
    RIVALS = {
        "shaft_bow": "a bow is amplified at the critical speed, run-out is not; both show at slow roll",
        "unbalance": "slow-roll vector: run-out does not grow with speed",
    }
    REFERENCES = (
        "API Standard 670, Machinery Protection Systems",
        "D. E. Bently and C. T. Hatch, Fundamentals of Rotating Machinery Diagnostics, Bently Pressurized Bearing "
        "Press 2002",
    )

    run_out_m: float = parameter(
        unit="m",
        bounds=(0.0, 5e-4),
        zero=0.0,
        prior=LogNormal(6e-6, 2.0),
        meaning="amplitude r of the pattern's first harmonic",
        source="API 670 asks for at most 6 um of combined electrical and mechanical run-out; field values up to 50 um",
    )
    decay: float = parameter(
        unit="",
        bounds=(0.0, 1.0),
        prior=Uniform(0.2, 0.8),
        meaning="each harmonic over the one before; 8 are there",
        source="estimate: out-of-round 0.2, scratches 0.8",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="angle psi of the first harmonic at shaft angle 0",
        source="any angle is equally likely",
    )

    def fits(self, probe: Probe) -> bool:
        """Return whether it is a lateral displacement probe."""
        return super().fits(probe) and probe.direction in ("x", "y")

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Add the surface's pattern to the chosen probes."""
        if self.run_out_m == 0:
            return record
        signals = record.signals.copy()
        for i in self.chosen(record.channels):
            behind = math.pi / 2 if record.channels[i].direction == "y" else 0.0
            angle = record.shaft_ratios[i] * record.phase_rad - behind
            for n in range(1, HARMONICS + 1):
                start = self.angle_rad + GOLDEN_RAD * (n**2 - 1)
                signals[i] += self.run_out_m * self.decay ** (n - 1) * np.cos(n * angle + start)
        return record.with_signals(signals)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the first harmonics of the shaft that the first chosen probe looks at."""
        assembly = machine.bare_assembly()
        probe = assembly.probes[self.chosen(assembly.probes)[0]]
        ratio = assembly.places[probe.location].shaft_ratio if probe.location in assembly.places else 1.0
        return tuple(Line(n * ratio, speed_exponent=0.0, load_exponent=0.0) for n in (1, 2, 3))
