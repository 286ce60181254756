"""Largest Lyapunov exponent: does a small disturbance grow? Then the motion is chaotic and has statistics only.

G. Benettin et al., Meccanica 15 (1980) 9: a second trajectory starts close by; after each interval its distance is
recorded and set back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InvalidValueError
from ..machine import Machine
from ..speed_profile import as_profile
from .blas import single_blas_thread
from .stepper import LaneGroup, Stepper

#: Initial distance over the size of the motion, each state measured by its own rms.
DISTANCE = 1e-7


@dataclass(frozen=True)
class LyapunovEstimate:
    """Largest Lyapunov exponent of a motion.

    Attributes
    ----------
    exponent_1_s, uncertainty_1_s : float
        Mean growth rate of a disturbance, and its standard error from batches of the record.
    duration_s : float
        Over which it was followed.
    """

    exponent_1_s: float
    uncertainty_1_s: float
    duration_s: float

    @property
    def is_chaotic(self) -> bool:
        """Whether the exponent is positive beyond three standard errors."""
        return self.exponent_1_s > 3 * self.uncertainty_1_s

    @property
    def sentence(self) -> str:
        """What it means, for the user."""
        figure = f"largest Lyapunov exponent {self.exponent_1_s:.3g} +- {self.uncertainty_1_s:.2g} 1/s"
        if self.is_chaotic:
            return f"The motion is chaotic ({figure}): compare spectra and statistics, not waveforms."
        # A disturbance that did not even grow e-fold while it was followed says nothing against regular motion.
        if self.exponent_1_s > self.uncertainty_1_s and self.exponent_1_s * self.duration_s > 1:
            return f"The motion is not clearly regular ({figure}): follow it for longer."
        return f"The motion is regular ({figure})."


@single_blas_thread
def lyapunov_exponent(
    machine: Machine,
    *,
    speed_rpm: float,
    duration_s: float,
    settle_s: float | None = None,
    step_s: float | None = None,
    intervals: int = 100,
    seed: int = 0,
) -> LyapunovEstimate:
    """Return the largest Lyapunov exponent from ``duration_s`` of steady running.

    Parameters
    ----------
    machine : Machine
    speed_rpm : float
    duration_s : float
    settle_s, step_s : float, optional
        The machine's own by default.
    intervals : int
        The distance is set back so often; 10 or more.
    seed : int
        For the direction of the first disturbance.
    """
    if intervals < 10 or not duration_s > 0:
        raise InvalidValueError(f"{intervals} intervals in {duration_s} s; allowed: 10 or more, more than 0 s.")
    profile = as_profile(speed_rpm)
    step = machine.definition.step_s if step_s is None else step_s
    settle = machine.definition.settle_s if settle_s is None else settle_s
    system = machine.system(speed_rpm=profile)
    group = LaneGroup([machine] * 2, [profile] * 2, [system] * 2)
    stepper = Stepper(group, step_s=step, start_s=-settle, modal=False)
    each = max(1, round(duration_s / intervals / step))
    stepper.advance(max(1, round(settle / step)))
    scale = _state_scale(stepper, each)
    disturbance = np.random.default_rng(seed).normal(size=system.states) * scale
    stepper.states[:, 1] = stepper.states[:, 0] + DISTANCE * disturbance / np.sqrt(system.states)
    growth = np.zeros(intervals)
    # The disturbance first turns into the fastest growing direction: a fifth of the intervals are not counted.
    for i in range(-(intervals // 5), intervals):
        stepper.advance(each)
        difference = stepper.states[:, 1] - stepper.states[:, 0]
        size = float(np.linalg.norm(difference / scale) / np.sqrt(system.states))
        if not size > 0:
            size = DISTANCE * 1e-30
            difference = DISTANCE * 1e-30 * disturbance
        if i >= 0:
            growth[i] = np.log(size / DISTANCE) / (each * step)
        stepper.states[:, 1] = stepper.states[:, 0] + difference * DISTANCE / size
    batches = growth[: intervals // 10 * 10].reshape(10, -1).mean(axis=1)
    return LyapunovEstimate(float(growth.mean()), float(batches.std(ddof=1) / np.sqrt(10)), intervals * each * step)


def _state_scale(stepper: Stepper, steps: int) -> np.ndarray:
    """Return the size of each state's alternating motion; a small floor for states that rest."""
    seen = []
    for _ in range(16):
        stepper.advance(max(1, steps // 16))
        seen.append(stepper.states[:, 0].copy())
    size = np.std(seen, axis=0)
    return np.maximum(size, 1e-6 * size.max() + 1e-300)
