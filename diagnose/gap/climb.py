"""The way from a start to the best values of a hypothesis: Levenberg-Marquardt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...simulators.machine import Machine
from .boxed_step import boxed_step
from .evidence import Comparison, Widened, law_columns
from .hypotheses import Candidate
from .predict import Predictor, UnpredictableError
from .responses import Responses

FIRST_STEPS = 3
LONGEST_MOVE = 1.0
#: Ever shorter moves that are tried at a step, and gain of the logarithm below which no further step is made; also
#: where each is a simulation, which repeats itself no better than to some tenths.
TRIES, TRIES_IN_TIME = 6, 3
WORTH, WORTH_IN_TIME = 1e-2, 0.5
#: By how much the logarithm of the density may be worse than at the best place of a climb.
ASTRAY = 20.0
#: A coordinate whose whole prior moves the lines by less than this, in standard deviations, is left alone where each
#: slope is a simulation.
DEAD = 0.3


@dataclass(frozen=True, eq=False)
class Climbed:
    """Where a climb has got to.

    Attributes
    ----------
    position : ndarray (coordinates,)
    added : ndarray (conditions, probes, orders), complex
        The response there.
    objective : float
        Minus the logarithm of likelihood and prior, up to a constant.
    alive : ndarray (coordinates,), bool
        Those that move the lines at all.
    slopes : ndarray (coordinates, conditions, probes, orders), complex, or None
        There, when they are known.
    """

    position: np.ndarray
    added: np.ndarray
    objective: float
    alive: np.ndarray
    slopes: np.ndarray | None


def climbed(
    chosen: Sequence[Candidate],
    starts: Sequence[np.ndarray],
    compared: Comparison,
    machine: Machine,
    predictor: Predictor,
    *,
    steps: int,
) -> list[Climbed]:
    """Return where several starts have got to after some steps, the best first; those that can be computed.

    Levenberg-Marquardt on the whitened residual and the prior; the law's tolerance is that of the current response.
    """
    response, precision = Responses(chosen, machine, predictor), precision_of(chosen)
    tried = []
    for start in starts:
        try:
            tried.append(climb(response, start, precision, compared, steps))
        except UnpredictableError:
            continue
    return sorted(tried, key=lambda one: one.objective)


def climb(
    response: Responses,
    position: np.ndarray,
    precision: np.ndarray,
    compared: Comparison,
    most_steps: int,
) -> Climbed:
    """Return where some steps from a position have got to; see `climbed`.

    Raises
    ------
    UnpredictableError
        Where the response at the start cannot be computed.
    """
    added, damping = response(position), 1e-3
    slopes, law = None, laws_of(compared, response.chosen, response.own(position, added))
    here = _objective(compared, added, position, precision, law)
    least = here + 0.5 * law.log_determinant
    alive = np.ones(position.size, dtype=bool)
    for _ in range(most_steps):
        in_time = response.steps(position)
        slopes = response.slopes(position, added, alive)
        white = compared.whitened(slopes)
        if in_time:
            # Each costs a simulation in every condition.
            alive = (white**2).sum(axis=1) > DEAD**2
        gradient = white @ law.solve(compared.residual - compared.whitened(added)) - precision * position
        curvature = white @ law.solve(white).T + np.diag(precision)
        trial, reached = position, None
        for _ in range(TRIES_IN_TIME if in_time else TRIES):
            scaled = curvature + damping * np.diag(np.diag(curvature) + 1e-9)
            trial = position + boxed_step(scaled, gradient, LONGEST_MOVE)
            reached = _better(response, trial, precision, compared, (position, here, law), least + ASTRAY)
            if reached is not None:
                break
            damping = max(10 * damping, 1e-3)
        if reached is None:
            break
        gained = here - reached.by_old_law
        position, damping, slopes = trial, damping / 5, None
        added, here, law = reached.added, reached.objective, reached.law
        least = min(least, here + 0.5 * law.log_determinant)
        if gained < (WORTH_IN_TIME if in_time else WORTH):
            break
    return Climbed(position, added, here, alive, slopes)


@dataclass(frozen=True, eq=False)
class _Reached:
    """A better place: the response there, its law, and the objective by that and by the law of the place before."""

    added: np.ndarray
    law: Widened
    objective: float
    by_old_law: float


def _better(
    response: Responses,
    trial: np.ndarray,
    precision: np.ndarray,
    compared: Comparison,
    before: tuple[np.ndarray, float, Widened],
    most: float,
) -> _Reached | None:
    """Return what is at a trial; None where that is no better than the position, objective and law ``before``.

    The law is held for a step: were its width, a share of what the effect makes, to count at once, effects that make
    less would seem likelier. But a step to where the law allows for other errors may lead on to ever worse places: by
    its own law, with what its width costs, none may be worse than ``most``.
    """
    position, here, law = before
    try:
        response.prepare([trial], near=position)
        added = response(trial)
        by_old_law = _objective(compared, added, trial, precision, law)
        if by_old_law >= here:
            return None
        own = laws_of(compared, response.chosen, response.own(trial, added))
    except UnpredictableError:
        return None
    there = _objective(compared, added, trial, precision, own)
    return _Reached(added, own, there, by_old_law) if there + 0.5 * own.log_determinant < most else None


def precision_of(chosen: Sequence[Candidate]) -> np.ndarray:
    """Return the precision of the prior of every coordinate of effects."""
    return np.array([c.precision for candidate in chosen for c in candidate.coordinates])


def laws_of(compared: Comparison, chosen: Sequence[Candidate], responses: Sequence[np.ndarray]) -> Widened:
    """Return in which directions the laws of effects may be wrong, each for itself."""
    each = zip(chosen, responses, strict=True)
    found = [law_columns(compared, own, idealised=one.effect.IDEALISED, directed=one.is_directed) for one, own in each]
    return Widened(np.concatenate([np.zeros((0, compared.residual.size)), *found]))


def _objective(
    compared: Comparison, added: np.ndarray, position: np.ndarray, precision: np.ndarray, law: Widened
) -> float:
    residual = compared.residual - compared.whitened(added)
    return 0.5 * float(residual @ law.solve(residual)) + 0.5 * float(precision @ position**2)
