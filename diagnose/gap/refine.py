"""The best values of one hypothesis, their uncertainty, and its evidence by Laplace's method."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...simulators.machine import Machine
from .coordinates import Coordinate, log_prior, values_at
from .evidence import Comparison, Widened, law_columns, log_density
from .hypotheses import Candidate
from .predict import Predictor, UnpredictableError

STEP = 2e-3
MOST_STEPS = 12
#: Least precision of an angle: of a flat prior on a full circle.
CIRCLE_PRECISION = 12 / (2 * math.pi) ** 2
LONGEST_MOVE = 1.0


@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis at its most probable values.

    Attributes
    ----------
    candidates : tuple of Candidate
        Effects that act together; none for the hypothesis that nothing is wrong.
    position : ndarray (coordinates,)
        Coordinates of all of them, one after the other.
    covariance : ndarray (coordinates, coordinates)
    response : ndarray (conditions, probes, orders), complex
        What the effects add to the lines.
    slopes : ndarray (coordinates, conditions, probes, orders), complex
    log_evidence : float
    residual : ndarray (reals,)
        Whitened, what stays unexplained.
    law : ndarray (directions, reals)
        Whitened directions in which the law may be wrong.
    """

    candidates: tuple[Candidate, ...]
    position: np.ndarray
    covariance: np.ndarray
    response: np.ndarray
    slopes: np.ndarray
    log_evidence: float
    residual: np.ndarray
    law: np.ndarray

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all effects."""
        return tuple(c for candidate in self.candidates for c in candidate.coordinates)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects, sorted."""
        return tuple(sorted(candidate.name for candidate in self.candidates))

    def machine(self, machine: Machine, position: np.ndarray | None = None) -> Machine:
        """Return the machine with the effects."""
        return with_candidates(machine, self.candidates, self.position if position is None else position)

    def interval(self, number: int, *, share: float = 0.9) -> tuple[float, float]:
        """Return the values of one coordinate's parameter that hold ``share`` of its probability."""
        from scipy.special import ndtri

        reach = float(ndtri(0.5 + share / 2)) * math.sqrt(self.covariance[number, number])
        one, at = self.coordinates[number], self.position[number]
        if one.is_angle:
            return (-math.pi, math.pi) if reach >= math.pi else (one.value(at) - reach, one.value(at) + reach)
        low, high = sorted((one.value(at - reach), one.value(at + reach)))
        return low, high

    def values(self) -> list[dict[str, float]]:
        """Return each effect's values by name."""
        found, start = [], 0
        for candidate in self.candidates:
            stop = start + len(candidate.coordinates)
            found.append(values_at(candidate.coordinates, self.position[start:stop]))
            start = stop
        return found


def with_candidates(machine: Machine, chosen: Sequence[Candidate], position: np.ndarray) -> Machine:
    """Return the machine with the candidates' effects at a position of their joint coordinates."""
    effects, start = [], 0
    for candidate in chosen:
        stop = start + len(candidate.coordinates)
        effects.append(candidate.at(position[start:stop]))
        start = stop
    return machine.with_effects(*effects)


def nothing(compared: Comparison) -> Fit:
    """Return the hypothesis that no effect is present."""
    empty = np.zeros((0, compared.residual.size))
    none = np.zeros((0, *compared.seen.shape), dtype=complex)
    response = np.zeros(compared.seen.shape, dtype=complex)
    evidence = log_density(compared, compared.residual, Widened(empty))
    return Fit((), np.zeros(0), np.zeros((0, 0)), response, none, evidence, compared.residual, empty)


def refined(
    chosen: Sequence[Candidate],
    start: np.ndarray,
    compared: Comparison,
    machine: Machine,
    predictor: Predictor,
    *,
    most_steps: int = MOST_STEPS,
) -> Fit | None:
    """Return the fit of effects from a start in their coordinates; None where their motion cannot be computed.

    Levenberg-Marquardt on the whitened residual and the prior; the law's tolerance is that of the current response.
    """
    coordinates = tuple(c for candidate in chosen for c in candidate.coordinates)
    precision = np.array([c.precision for c in coordinates])
    base = predictor.amplitudes(machine)

    def response(position: np.ndarray) -> np.ndarray:
        return predictor.amplitudes(with_candidates(machine, chosen, position)) - base

    try:
        position, added = _climb(response, start, precision, compared, most_steps)
        slopes = _slopes(response, position, added)
    except UnpredictableError:
        return None
    law = Widened(law_columns(compared, added))
    residual = compared.residual - compared.whitened(added)
    white = compared.whitened(slopes)
    least = np.where([c.is_angle for c in coordinates], CIRCLE_PRECISION, precision)
    information = white @ law.solve(white).T + np.diag(least)
    covariance = np.linalg.inv(information)
    evidence = (
        log_density(compared, residual, law)
        + log_prior(coordinates, position)
        + 0.5 * len(coordinates) * math.log(2 * math.pi)
        - 0.5 * float(np.linalg.slogdet(information)[1])
    )
    return Fit(tuple(chosen), position, covariance, added, slopes, evidence, residual, law.directions)


def _climb(
    response: Callable[[np.ndarray], np.ndarray],
    position: np.ndarray,
    precision: np.ndarray,
    compared: Comparison,
    most_steps: int,
) -> tuple[np.ndarray, np.ndarray]:
    added, damping = response(position), 1e-3
    for _ in range(most_steps):
        law = Widened(law_columns(compared, added))
        here = _objective(compared, added, position, precision, law)
        white = compared.whitened(_slopes(response, position, added))
        gradient = white @ law.solve(compared.residual - compared.whitened(added)) - precision * position
        curvature = white @ law.solve(white).T + np.diag(precision)
        moved = False
        for _ in range(6):
            scaled = curvature + damping * np.diag(np.diag(curvature) + 1e-9)
            move = np.linalg.solve(scaled, gradient)
            move *= min(1.0, LONGEST_MOVE / max(float(np.abs(move).max()), 1e-300))
            trial = position + move
            try:
                there = response(trial)
                value = _objective(compared, there, trial, precision, law)
            except UnpredictableError:
                value = math.inf
            if value < here:
                moved = True
                break
            damping = max(10 * damping, 1e-3)
        if not moved:
            break
        position, added, damping = trial, there, damping / 5
        if here - value < 1e-2:
            break
    return position, added


def _objective(
    compared: Comparison, added: np.ndarray, position: np.ndarray, precision: np.ndarray, law: Widened
) -> float:
    residual = compared.residual - compared.whitened(added)
    return 0.5 * float(residual @ law.solve(residual)) + 0.5 * float(precision @ position**2)


def _slopes(response: Callable[[np.ndarray], np.ndarray], position: np.ndarray, added: np.ndarray) -> np.ndarray:
    slopes = np.zeros((position.size, *added.shape), dtype=complex)
    for i in range(position.size):
        moved = position.copy()
        moved[i] += STEP
        slopes[i] = (response(moved) - added) / STEP
    return slopes
