"""Run-out: a proximity probe sees the shaft's surface, not its centre."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..effect import Line, SensorEffect
from ..parameter import LogNormal, Uniform, parameter

if TYPE_CHECKING:
    from ..assembly import Probe
    from ..machine import Machine
    from ..sensor_record import SensorRecord

#: Harmonics of the surface's pattern: a dent of a tenth of the circumference has as many.
HARMONICS = 12
#: Those that any pattern shows. Higher ones are told where a spectrum shows them, not looked for.
USUAL = 6


def _height(harmonic: int, median_m: float, factor: float) -> Any:
    return parameter(
        unit="m",
        bounds=(0.0, 5e-4),
        zero=0.0,
        prior=LogNormal(median_m, factor),
        meaning=f"amplitude of harmonic {harmonic} of the pattern",
        source="API 670 asks for at most 6 um of combined electrical and mechanical run-out; field values up to 50 um; "
        "how the harmonics share it is a guess",
    )


def _place(harmonic: int) -> Any:
    return parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning=f"angle from x to a high spot of harmonic {harmonic} at shaft angle 0",
        source="any angle is equally likely",
        period=2 * math.pi / harmonic,
        only_with=f"harmonic_{harmonic}_m",
    )


@dataclass(frozen=True, kw_only=True)
class RunOut(SensorEffect):
    """sum_n r_n cos n (phi + a_n - theta) on a probe that looks from the angle theta (x: 0, y: 90 degrees).

    The pattern belongs to the surface (scratches, magnetic spots, out-of-round) and may have any shape: both probes
    read it, the second a quarter turn later, and it is the same at any speed and load, which is how slow roll finds it.
    Left out: harmonics above the twelfth, and the pattern's shift when the shaft moves along its axis.
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

    harmonic_1_m: float = _height(1, 6e-6, 2.0)
    harmonic_2_m: float = _height(2, 3e-6, 3.0)
    harmonic_3_m: float = _height(3, 2e-6, 3.0)
    harmonic_4_m: float = _height(4, 1.5e-6, 3.0)
    harmonic_5_m: float = _height(5, 1e-6, 3.0)
    harmonic_6_m: float = _height(6, 1e-6, 3.0)
    harmonic_7_m: float = _height(7, 7e-7, 3.0)
    harmonic_8_m: float = _height(8, 7e-7, 3.0)
    harmonic_9_m: float = _height(9, 7e-7, 3.0)
    harmonic_10_m: float = _height(10, 7e-7, 3.0)
    harmonic_11_m: float = _height(11, 7e-7, 3.0)
    harmonic_12_m: float = _height(12, 7e-7, 3.0)
    angle_1_rad: float = _place(1)
    angle_2_rad: float = _place(2)
    angle_3_rad: float = _place(3)
    angle_4_rad: float = _place(4)
    angle_5_rad: float = _place(5)
    angle_6_rad: float = _place(6)
    angle_7_rad: float = _place(7)
    angle_8_rad: float = _place(8)
    angle_9_rad: float = _place(9)
    angle_10_rad: float = _place(10)
    angle_11_rad: float = _place(11)
    angle_12_rad: float = _place(12)

    @property
    def heights_m(self) -> tuple[float, ...]:
        """Amplitude of each harmonic, the first first."""
        return tuple(getattr(self, f"harmonic_{n}_m") for n in range(1, HARMONICS + 1))

    def fits(self, probe: Probe) -> bool:
        """Return whether it is a lateral displacement probe."""
        return super().fits(probe) and probe.direction in ("x", "y")

    def mixing(self, channels: Sequence[Probe]) -> np.ndarray:
        """Return that each channel stays itself."""
        return np.eye(len(channels))

    def added(self, channels: Sequence[Probe]) -> dict[int, np.ndarray]:
        """Return the surface's pattern at the chosen probes, by harmonic."""
        chosen = self.chosen(channels)
        turned = [math.pi / 2 if channels[i].direction == "y" else 0.0 for i in chosen]
        found = {}
        for n, height_m in enumerate(self.heights_m, start=1):
            if height_m:
                found[n] = np.zeros(len(channels), dtype=complex)
                found[n][chosen] = height_m * np.exp(1j * n * (getattr(self, f"angle_{n}_rad") - np.array(turned)))
        return found

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Add the surface's pattern to the chosen probes."""
        added = self.added(record.channels)
        if not added:
            return record
        signals = record.signals.copy()
        for i in self.chosen(record.channels):
            harmonic = turning = np.exp(1j * record.shaft_ratios[i] * record.phase_rad)
            for n in range(1, max(added) + 1):
                if n in added:
                    signals[i] += np.real(added[n][i] * harmonic)
                # A product each costs less than a cosine.
                harmonic = harmonic * turning
        return record.with_signals(signals)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the first six harmonics of the shaft that the first chosen probe looks at, strongest first."""
        assembly = machine.bare_assembly()
        probe = assembly.probes[self.chosen(assembly.probes)[0]]
        ratio = assembly.places[probe.location].shaft_ratio if probe.location in assembly.places else 1.0
        heights = {n: height_m for n, height_m in enumerate(self.heights_m[:USUAL], start=1) if height_m}
        return tuple(
            Line(n * ratio, speed_exponent=0.0, load_exponent=0.0) for n in sorted(heights, key=lambda n: -heights[n])
        )
