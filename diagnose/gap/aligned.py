"""Two causes that point along one line of the shaft: two seldom do, the parts of one that looks like a third do.

What one cause makes at 1X, a bent shaft say, a combination of others takes the shape of (a misaligned coupling and an
unbalance), each in the direction of the one, or against it. Two causes that have nothing to do with each other lie
within the usual 10 deg of one line in one case of nine. In trials all seven pairs that a bow, left out of the
catalogue, was called lay so, and two of five true ones, which are no longer named (README, "Trials").
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .evidence import Problem
from .refine import Fit
from .responses import Responses
from .stretched import at_its_end

if TYPE_CHECKING:
    from .posterior import Posterior

#: Of what each makes 1X must hold this share, and turning its angles turn that to within this error: an uneven coupling
#: sends a part of it round the other way (0.5 of it on the magnetic-bearing rotor); what stands still is off by 1.4.
MOSTLY, CLOSE = 0.5, 0.8
#: Directions told no better than this (rad, to both sides) do not show whether they lie along one line.
WIDEST = math.pi / 8


def not_as_two(posterior: Posterior, problem: Problem) -> Posterior:
    """Return the posterior in which something unknown takes the place of two leading causes along one line.

    Or of two of which one is as strong as it can be.
    """
    leading = next(iter(posterior.probabilities))
    if len(leading) != 2 or "unknown" in leading:
        return posterior
    if not along_one_line(posterior.best(leading), problem) and not at_its_end(posterior.best(leading), problem):
        return posterior
    shares = dict(posterior.probabilities)
    shares["unknown",] = shares.get(("unknown",), 0.0) + shares.pop(leading)
    ordered = dict(sorted(shares.items(), key=lambda item: -item[1]))
    return replace(posterior, probabilities=ordered, opposed=(posterior.best(leading), *posterior.opposed))


def along_one_line(fit: Fit, problem: Problem) -> bool:
    """Return whether two effects make mostly 1X, turn with the shaft, and point the same way or opposite ways."""
    if len(fit.candidates) != 2:
        return False
    first, second = _directions(fit, problem)
    if first is None or second is None:
        return False
    reach = math.hypot(first[1], second[1])
    return reach < WIDEST and abs(math.remainder(first[0] - second[0], math.pi)) < reach


def _directions(fit: Fit, problem: Problem) -> list[tuple[float, float] | None]:
    """Return each effect's direction on the shaft and how far to both sides it may lie, rad; None where it has none."""
    machine = (fit.problem or problem).baseline.machine
    each = Responses(fit.candidates, machine, problem.predictor).own(fit.position, fit.response)
    found, start = [], 0
    for candidate, own in zip(fit.candidates, each, strict=True):
        numbers = range(start, start + len(candidate.coordinates))
        found.append(_direction(fit, own, numbers, problem) if candidate.effect.STAGE != "sensor" else None)
        start += len(candidate.coordinates)
    return found


def _direction(fit: Fit, own: np.ndarray, numbers: range, problem: Problem) -> tuple[float, float] | None:
    lines = problem.lines
    once = [
        k for k, (order, kind) in enumerate(zip(lines.orders, lines.kinds, strict=True)) if kind.phase and order == 1
    ]
    angles = [i for i in numbers if fit.coordinates[i].is_angle and fit.coordinates[i].parameter.period > math.pi]
    if not once or not angles:
        return None
    # In lines of unit noise. An offset and a tilt have an angle each: only together do they turn all that is made.
    weight = 1 / np.where(lines.seen, lines.deviations, np.inf)
    made = weight * own
    turned = np.array([(weight * fit.slopes[i])[..., once[0]] for i in angles])
    at_once = made[..., once[0]]
    power = float((np.abs(at_once) ** 2).sum())
    if power <= MOSTLY * float((np.abs(made) ** 2).sum()):
        return None
    if float((np.abs(turned.sum(axis=0) - 1j * at_once) ** 2).sum()) > CLOSE**2 * power:
        return None
    strongest = angles[int(np.argmax((np.abs(turned) ** 2).sum(axis=(1, 2))))]
    low, high = fit.interval(strongest)
    return fit.coordinates[strongest].value(float(fit.position[strongest])), (high - low) / 2
