"""What to record next: the speed at which the hypotheses left over differ most, in standard deviations of the noise."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .lines import Condition
from .predict import UnpredictableError
from .refine import Fit

if TYPE_CHECKING:
    from .explain import Prepared

#: Speeds that can be run, as shares of the lowest and the highest recorded one.
SLOWER, FASTER, SPEEDS = 0.6, 1.25, 12
#: A measurement that separates two hypotheses by less is not worth proposing.
LEAST_SEPARATION = 9.0


def next_measurement(kind: str, best: Fit, rivals: Sequence[Fit], prepared: Prepared) -> str:
    """Return the proposal in words; empty when nothing is open."""
    if kind == "cannot tell":
        speed = _emptiest_speed(prepared)
        return f"Record at more speeds (for instance {speed:.0f} rpm) and longer, with a tacho."
    if not rivals or not best.candidates:
        return ""
    names = ", ".join("+".join(rival.names) or "nothing" for rival in rivals)
    speed, separation = most_separating_speed(best, rivals, prepared)
    parts = []
    if separation > LEAST_SEPARATION:
        parts.append(f"A recording at {speed:.0f} rpm would separate {'+'.join(best.names)} from {names}.")
    for rival in rivals:
        for candidate in best.candidates:
            for other in rival.names:
                if other in candidate.effect.RIVALS:
                    parts.append(f"{candidate.name} or {other}: {candidate.effect.RIVALS[other]}")
    return " ".join(parts)


def most_separating_speed(best: Fit, rivals: Sequence[Fit], prepared: Prepared) -> tuple[float, float]:
    """Return the speed (rpm) at which the least separated rival is separated best, and its d2 there."""
    measured = prepared.measured
    speeds = [c.speed_rpm for c in measured.conditions]
    tried = np.linspace(SLOWER * min(speeds), FASTER * max(speeds), SPEEDS)
    load = measured.conditions[0].load
    predictor = prepared.predictor.at([Condition(float(speed), load) for speed in tried])
    noise = np.median(np.where(measured.seen, measured.deviations, np.nan), axis=0)
    noise = np.where(np.isfinite(noise), noise, np.nanmax(noise))
    machine = prepared.baseline.machine
    separation = np.full(SPEEDS, np.inf)
    try:
        leading = predictor.amplitudes(best.machine(machine))
        for rival in rivals:
            other = predictor.amplitudes(rival.machine(machine))
            scale = noise**2 + (0.05 * np.abs(leading)) ** 2
            separation = np.minimum(separation, (np.abs(leading - other) ** 2 / scale).sum(axis=(1, 2)))
    except UnpredictableError:
        return float(tried[0]), 0.0
    where = int(np.argmax(separation))
    return float(tried[where]), float(separation[where])


def _emptiest_speed(prepared: Prepared) -> float:
    """Return the middle of the widest gap between the recorded speeds, or a quarter above a single one."""
    speeds = sorted(c.speed_rpm for c in prepared.measured.conditions)
    if len(speeds) < 2 or speeds[-1] < 1.05 * speeds[0]:
        return 1.25 * speeds[-1]
    gaps = [(b - a, (a + b) / 2) for a, b in itertools.pairwise(speeds)]
    return max(gaps)[1]
