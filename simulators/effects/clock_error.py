"""Clock error: samples are not taken when the recorder believes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from ..effect import Line, SensorEffect
from ..parameter import LogNormal, Normal, parameter

if TYPE_CHECKING:
    from ..machine import Machine
    from ..sensor_record import SensorRecord

#: Samples that one value between them is made of, shares of a sample at which their weights are tabulated (straight
#: lines between these are wrong by 1e-6), and the window's shape: 100 dB down.
TAPS, PHASES, KAISER_BETA = 48, 1024, 10.0


@dataclass(frozen=True, kw_only=True)
class ClockError(SensorEffect):
    """Sample k is taken at k (1 + e) / rate + jitter, but written down as k / rate.

    All frequencies read (1 + e) f: e parts per million too high. Jitter of standard deviation s leaves on a line of
    frequency f a noise of 2 pi f s times its amplitude, so that the signal-to-noise ratio is -20 log10(2 pi f s). Both
    grow with frequency and therefore with speed, not with load. All channels share the clock, the angle of the shaft
    too: orders that are counted with a tacho on the same clock stay right.
    """

    NAME = "clock_error"
    LINK = "clock"
    MEANING = "The recorder's clock runs fast or slow, or trembles."
    CHECK = (
        "What frequency does a reference tone or the mains show in the record? Do two recorders agree after an hour?"
    )
    RIVALS = {
        "speed_wander": "a reference tone on another channel trembles as well",
        "dropped_samples": "single jumps of phase instead of a steady drift",
    }
    REFERENCES = (
        "M. Shinagawa, Y. Akazawa and T. Wakimoto, Jitter analysis of high-speed sampling systems, "
        "IEEE J. Solid-State Circuits 25 (1990) 220-224",
        "IEEE Std 1241, Terminology and Test Methods for Analog-to-Digital Converters",
    )

    rate_error_ppm: float = parameter(
        unit="ppm",
        bounds=(-2e4, 2e4),
        zero=0.0,
        prior=Normal(500.0, 1000.0),
        meaning="true sampling interval over the nominal one, less 1, in parts per million",
        source="estimate: crystals have 50, recorders paced by software or a microcontroller's oscillator up to 10000",
    )
    jitter_s: float = parameter(
        unit="s",
        bounds=(0.0, 1e-3),
        zero=0.0,
        prior=LogNormal(5e-6, 5.0),
        meaning="standard deviation of each sample's instant",
        source="estimate: sampling started by software 1e-5, by a clean clock below 1e-9",
    )

    @property
    def is_random(self) -> bool:
        """Whether there is jitter."""
        return self.jitter_s > 0

    def demand(self, *, rate_hz: float, duration_s: float) -> tuple[int, float]:
        """Return no oversampling and the time by which a slow clock overruns the record."""
        late = max(self.rate_error_ppm, 0.0) * 1e-6 * duration_s + 4 * self.jitter_s
        return 1, late + 2 / rate_hz if late > 0 else 0.0

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Take all channels' samples, and the shaft's angle, at the true instants."""
        if self.rate_error_ppm == 0 and self.jitter_s == 0:
            return record
        count = record.signals.shape[1]
        instants = np.arange(count) * (1 + 1e-6 * self.rate_error_ppm)
        if self.jitter_s > 0:
            instants = instants + self.jitter_s * record.rate_hz * np.clip(generator.normal(size=count), -4, 4)
        instants = np.clip(instants, 0, count - 1)
        signals = record.signals.copy()
        chosen = self.chosen(record.channels)
        signals[chosen] = at_instants(signals[chosen], instants)
        nominal = np.arange(count)
        return replace(
            record,
            signals=signals,
            phase_rad=np.interp(instants, nominal, record.phase_rad),
            speed_rad_s=np.interp(instants, nominal, record.speed_rad_s),
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return no line: all lines move by the same share of their frequency."""
        return ()


def at_instants(signals: np.ndarray, instants: np.ndarray) -> np.ndarray:
    """Return band-limited signals between their samples.

    Parameters
    ----------
    signals : ndarray (samples,) or (channels, samples)
    instants : ndarray (instants,)
        In samples, from 0 to samples - 1.

    Notes
    -----
    A sinc of `TAPS` samples under a Kaiser window: the error is below 2e-5 of a line up to 0.4 of the rate. At the ends
    the signal is continued by its odd reflection, after its trend is taken off.
    """
    count = signals.shape[-1]
    if count < 2:
        return np.broadcast_to(signals, (*signals.shape[:-1], instants.size)).copy()
    first, slope = signals[..., :1], (signals[..., -1:] - signals[..., :1]) / (count - 1)
    level = signals - first - slope * np.arange(count)
    room = [(0, 0)] * (signals.ndim - 1) + [(TAPS // 2, TAPS // 2)]
    padded = np.pad(level, room, mode="reflect", reflect_type="odd")
    whole = np.floor(instants).astype(int)
    phase = (instants - whole) * PHASES
    step = np.minimum(phase.astype(int), PHASES - 1)
    share = phase - step
    weights = _weights()
    found = np.zeros((*signals.shape[:-1], instants.size))
    for tap in range(TAPS):
        weight = weights[tap, step] * (1 - share) + weights[tap, step + 1] * share
        found += weight * padded[..., whole + tap + 1]
    return found + first + slope * instants


@cache
def _weights() -> np.ndarray:
    """Return each tap's weight at evenly spaced shares of a sample, shape (TAPS, PHASES + 1)."""
    away = np.arange(TAPS)[:, None] - (TAPS // 2 - 1) - np.arange(PHASES + 1) / PHASES
    within = np.sqrt(np.clip(1 - (away / (TAPS / 2)) ** 2, 0, None))
    weights = np.sinc(away) * np.i0(KAISER_BETA * within) / np.i0(KAISER_BETA)
    return weights / weights.sum(axis=0)
