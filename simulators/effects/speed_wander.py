"""Speed wander: the shaft's speed is not constant."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..effect import Line, SpeedEffect
from ..errors import InvalidValueError
from ..parameter import LogNormal, Uniform, parameter

if TYPE_CHECKING:
    from ..machine import Machine

#: Knots of the speed in one period of its fastest change: piecewise linear, within 2e-3 of a sine.
KNOTS_A_PERIOD = 24
MOST_KNOTS = 2_000_000


@dataclass(frozen=True, kw_only=True)
class SpeedWander(SpeedEffect):
    """Speed x (1 + h cos(2 pi f_h t + psi) + noise), the noise of deviation d below a highest frequency.

    Hunting modulates the phase with the index b = h f_shaft / f_h, so that a line of order n gets sidebands f_h apart,
    of relative height J1(n b) / J0(n b): they grow with order and speed. Noise smears every line by n d times its
    frequency. Neither depends on load. Before time 0 the speed is that of time 0. The ideal rotation wanders;
    shafts that twist follow with their inertia. Left out: what makes the speed wander.
    """

    NAME = "speed_wander"
    MEANING = "The speed hunts about its mean or wanders at random, so that lines get sidebands or smear."
    CHECK = "What do a tacho or the motor current show? Is the controller stable, the belt tight, the load even?"
    RIVALS = {
        "load_fluctuation": "the tacho: wander is in the speed itself; order tracking removes its sidebands",
        "gear_eccentricity": "sidebands at a shaft speed and not at a controller's frequency; order tracking",
        "clock_error": "a reference tone on another channel does not tremble",
    }
    REFERENCES = (
        "R. B. Randall, Vibration-based Condition Monitoring, Wiley 2011",
        "J. M. Chowning, The synthesis of complex audio spectra by means of frequency modulation, "
        "J. Audio Eng. Soc. 21 (1973) 526-534",
    )

    hunting: float = parameter(
        unit="",
        bounds=(0.0, 0.1),
        zero=0.0,
        prior=LogNormal(0.005, 2.0),
        meaning="amplitude h of the periodic part over the mean speed",
        source="estimate: a speed controller that hunts by 0.5 %",
    )
    hunting_hz: float = parameter(
        unit="Hz",
        bounds=(0.05, 50.0),
        prior=LogNormal(1.0, 2.0),
        meaning="frequency f_h of the periodic part",
        source="estimate: speed controllers and belts, 0.5 to 2 Hz",
    )
    hunting_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="phase psi of the periodic part at the first sample",
        source="any phase is equally likely",
    )
    deviation: float = parameter(
        unit="",
        bounds=(0.0, 0.05),
        zero=0.0,
        prior=LogNormal(0.001, 3.0),
        meaning="standard deviation d of the random part over the mean speed",
        source="estimate: induction motors on the mains wander by 0.1 % with supply and load",
    )
    highest_hz: float = parameter(
        unit="Hz",
        bounds=(0.05, 50.0),
        prior=LogNormal(0.5, 2.0),
        meaning="highest frequency of the random part",
        source="estimate: the inertia of a drive train smooths what is faster",
    )
    seed: float = parameter(
        unit="",
        bounds=(0.0, 2147483647.0),
        default=0.0,
        meaning="whole number that chooses the draw of the random part",
        source="given; any number",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.seed.is_integer():
            raise InvalidValueError(f"seed = {self.seed!r}; allowed: a whole number from 0. Round it.")

    def speed_change(self, *, duration_s: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Return knots of the relative change of speed, fine enough for both parts."""
        parts = [f for strength, f in ((self.hunting, self.hunting_hz), (self.deviation, self.highest_hz)) if strength]
        if not parts:
            return None
        count = max(4, math.ceil(duration_s * max(parts) * KNOTS_A_PERIOD) + 1)
        if count > MOST_KNOTS:
            raise InvalidValueError(
                f"Speed wander up to {max(parts):g} Hz over {duration_s:g} s needs {count} knots; allowed: "
                f"{MOST_KNOTS}. Simulate a shorter time or a slower wander."
            )
        times = np.linspace(0.0, duration_s, count)
        change = self.hunting * np.cos(2 * math.pi * self.hunting_hz * times + self.hunting_rad)
        return times, change + self._noise(times)

    def _noise(self, times: np.ndarray) -> np.ndarray:
        """Return a sum of sines of random phase: the same process whatever the duration, so that runs can be longer."""
        if self.deviation == 0:
            return np.zeros(times.shape)
        generator = np.random.default_rng(int(self.seed))
        tones = 64
        # One frequency in each of 64 equal bands: flat up to the highest, and no repetition after a common period.
        frequencies = self.highest_hz * (np.arange(tones) + generator.random(tones)) / tones
        phases = generator.uniform(0, 2 * math.pi, tones)
        total = np.zeros(times.shape)
        for frequency, phase in zip(frequencies, phases, strict=True):
            total += np.cos(2 * math.pi * frequency * times + phase)
        # Bounded: the sum of 64 tones passes 4 deviations once in ten thousand draws, and the speed must stay positive.
        return self.deviation * np.clip(total * math.sqrt(2 / tones), -4, 4)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the sidebands of 1X; higher orders have larger ones."""
        return tuple(
            Line(1.0, "any", speed_exponent=1.0, load_exponent=0.0, frequency_hz=side * self.hunting_hz)
            for side in (1, -1)
        )
