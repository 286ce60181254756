"""What to record next: the speed at which the hypotheses left over differ most, in standard deviations of the noise."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .lines import Condition, different_speeds
from .predict import Predictor, UnpredictableError
from .refine import Fit

if TYPE_CHECKING:
    from .prepared import Prepared

#: Speeds that can be run, as shares of the lowest and the highest recorded one.
SLOWER, FASTER, SPEEDS = 0.6, 1.25, 12
#: A measurement that separates two hypotheses by less is not worth proposing.
LEAST_SEPARATION = 9.0
#: Fewer speeds leave causes alike.
FEW_SPEEDS = 3


def next_measurement(kind: str, best: Fit, rivals: Sequence[Fit], prepared: Prepared) -> str:
    """Return what to record next and why, in sentences; empty when nothing is open."""
    if kind == "cannot tell":
        return " ".join(_lacking(prepared))
    if not rivals or not best.candidates:
        return ""
    parts = []
    speed, told_apart = most_separating_speed(best, rivals, prepared)
    if told_apart:
        names = " and from ".join(_words(rival) for rival in told_apart)
        parts.append(f"A recording at {speed:.0f} rpm would separate {_words(best)} from {names}.")
    alike = " and from ".join(_words(rival) for rival in rivals if rival not in told_apart)
    if alike:
        low, high = _range(prepared)
        parts.append(
            f"At these probes no speed from {low:.0f} to {high:.0f} rpm separates {_words(best)} from {alike}: measure "
            "at a further place."
        )
    for rival in rivals:
        for candidate in best.candidates:
            for other in rival.names:
                if other in candidate.effect.RIVALS:
                    pair = f"{candidate.name} and {other}".replace("_", " ")
                    parts.append(f"What tells {pair} apart elsewhere: {candidate.effect.RIVALS[other].rstrip('.')}.")
    return " ".join(parts) or " ".join(_lacking(prepared))


def _words(fit: Fit) -> str:
    return " + ".join(name.replace("_", " ") for name in fit.names) or "nothing"


def _lacking(prepared: Prepared) -> list[str]:
    """Return what these recordings lack, each with what to do about it."""
    conditions, parts = prepared.measured.conditions, []
    speed, count = _emptiest_speed(prepared), different_speeds(prepared.measured.conditions)
    if count < FEW_SPEEDS:
        said = "One speed was recorded" if count == 1 else f"{count} speeds were recorded"
        parts.append(f"{said}, at which different causes look alike: record at {speed:.0f} rpm too.")
    if not all(one.tied for one in conditions):
        parts.append("Phases to the shaft are unknown: record a tacho with one pulse a turn.")
    if not prepared.healthy:
        parts.append("The healthy machine's own lines are unknown: give recordings of it as baseline.")
    if not parts:
        parts.append(f"What differs is small beside its uncertainty: record at {speed:.0f} rpm too, and longer.")
    return parts


def most_separating_speed(best: Fit, rivals: Sequence[Fit], prepared: Prepared) -> tuple[float, tuple[Fit, ...]]:
    """Return a speed (rpm) and the rivals that a recording there separates from the best.

    Of the rivals that any speed can separate, the speed at which the least separated one is separated best. A
    difference counts beyond noise and what the values of both fits leave open.
    """
    measured = prepared.measured
    tried = np.linspace(*_range(prepared), SPEEDS)
    load = measured.conditions[0].load
    predictor = prepared.predictor.at([Condition(float(speed), load) for speed in tried])
    noise = np.median(np.where(measured.seen, measured.deviations, np.inf), axis=0)
    found: list[tuple[Fit, np.ndarray]] = []
    try:
        leading, open_still = _expected(best, prepared, predictor)
        scale = noise**2 + (0.05 * np.abs(leading)) ** 2 + open_still
        for rival in rivals:
            other, open_too = _expected(rival, prepared, predictor)
            found.append((rival, (np.abs(leading - other) ** 2 / (scale + open_too)).sum(axis=(1, 2))))
    except UnpredictableError:
        return float(tried[0]), ()
    able = [(rival, apart) for rival, apart in found if apart.max() > LEAST_SEPARATION]
    if not able:
        return float(tried[0]), ()
    where = int(np.argmax(np.min([apart for _, apart in able], axis=0)))
    return float(tried[where]), tuple(rival for rival, apart in able if apart[where] > LEAST_SEPARATION)


def _expected(fit: Fit, prepared: Prepared, predictor: Predictor) -> tuple[np.ndarray, np.ndarray]:
    """Return the lines that a fit lets expect, and the variance that its own values leave open in them."""
    machine = (fit.problem or prepared).baseline.machine
    lines = predictor.amplitudes(fit.machine(machine))
    variance = np.zeros(lines.shape)
    if fit.candidates and predictor.repeats(fit.machine(machine)):
        for moved in np.linalg.cholesky(fit.covariance).T:
            variance += np.abs(predictor.amplitudes(fit.machine(machine, fit.position + moved)) - lines) ** 2
    return lines, variance


def _range(prepared: Prepared) -> tuple[float, float]:
    speeds = [c.speed_rpm for c in prepared.measured.conditions]
    return SLOWER * min(speeds), FASTER * max(speeds)


def _emptiest_speed(prepared: Prepared) -> float:
    """Return the middle of the widest gap between the recorded speeds, or a quarter above a single one."""
    speeds = sorted(c.speed_rpm for c in prepared.measured.conditions)
    if len(speeds) < 2 or speeds[-1] < 1.05 * speeds[0]:
        return 1.25 * speeds[-1]
    gaps = [(b - a, (a + b) / 2) for a, b in itertools.pairwise(speeds)]
    return max(gaps)[1]
