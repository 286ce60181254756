"""The best values of one hypothesis, their uncertainty, and its evidence by Laplace's method."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...simulators.machine import Machine
from .climb import climb, laws_of, precision_of
from .coordinates import Coordinate, log_prior, values_at
from .evidence import (
    STRENGTH_TOLERANCE,
    Comparison,
    Problem,
    Widened,
    log_density,
    strength_columns,
)
from .hypotheses import Candidate
from .least_known import told_to_a_factor
from .predict import Predictor, UnpredictableError
from .responses import STEP, Responses, with_candidates

MOST_STEPS = 12
#: Data tell a value where less than this share of what the prior leaves open stays open.
TOLD = 0.8
#: So far out in its prior a value is only where the data push it: to the edge of what is allowed.
PUSHED = 2.5


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
    problem : Problem, optional
        With the machine's own unknowns where they were when the effects were fitted; None when not fitted together.
    unknown_beside : frozenset of int
        Numbers of the orders that something unknown makes beside the effect.
    compared : Comparison, optional
        In which it was fitted.
    hills : ndarray (coordinates, coordinates), optional
        Second moment of how far other hills of the likelihood lie away, where that was looked at.
    arcs : mapping of int to float
        Of angles that choose one part of several: how far to both sides the same part is chosen.
    mirrored : frozenset of int
        Directions that may as well be their mirror image about the vertical.
    redrawn : bool
        Whether ``problem`` has a machine that was sought beside the effects, see `open_resonance.py`.
    """

    candidates: tuple[Candidate, ...]
    position: np.ndarray
    covariance: np.ndarray
    response: np.ndarray
    slopes: np.ndarray
    log_evidence: float
    residual: np.ndarray
    law: np.ndarray
    problem: Problem | None = None
    unknown_beside: frozenset[int] = frozenset()
    compared: Comparison | None = None
    hills: np.ndarray | None = None
    arcs: Mapping[int, float] = field(default_factory=dict)
    mirrored: frozenset[int] = frozenset()
    redrawn: bool = False

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all effects."""
        return tuple(c for candidate in self.candidates for c in candidate.coordinates)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects, sorted, and "unknown" after them where something else acts beside them."""
        return (*sorted(candidate.name for candidate in self.candidates), *(["unknown"] if self.unknown_beside else []))

    @property
    def power(self) -> float:
        """Squared residual, as far as the laws' tolerance does not hold it: in the mean of noise one for each real."""
        return float(self.residual @ Widened(self.law).solve(self.residual))

    def machine(self, machine: Machine, position: np.ndarray | None = None) -> Machine:
        """Return the machine with the effects."""
        return with_candidates(machine, self.candidates, self.position if position is None else position)

    def interval(self, number: int, *, share: float = 0.9) -> tuple[float, float]:
        """Return the values of one coordinate's parameter that hold ``share`` of its probability.

        An angle on the machine is told no better than the phase of a law: at the strongest order that is as wrong as
        its strength. So are all values of a law whose form is an idealisation, beside what the data leave open.
        """
        from scipy.special import ndtri

        if number in self.arcs:
            middle = self.coordinates[number].value(float(self.position[number]))
            return middle - self.arcs[number], middle + self.arcs[number]
        deviation = math.sqrt(self.covariance[number, number])
        least = STRENGTH_TOLERANCE if self._acts_on_machine(number) and self.coordinates[number].is_angle else 0.0
        share_reach = float(ndtri(0.5 + share / 2))
        reach = share_reach * max(deviation, least)
        one, at = self.coordinates[number], float(self.position[number])
        if one.is_angle:
            around, half = (one.value(at) - reach, one.value(at) + reach), one.parameter.period / 2
            return around if self.tells(number) and reach < half else (-half, half)
        if self._candidate(number).effect.IDEALISED:
            reach = math.hypot(reach, share_reach * STRENGTH_TOLERANCE * min(_relative(one, at), 1.0))
        low, high = sorted((one.value(at - reach), one.value(at + reach)))
        if number in self.mirrored:
            low, high = min(low, math.pi - high), max(high, math.pi - low)
        return low, high

    def _acts_on_machine(self, number: int) -> bool:
        """Return whether a coordinate belongs to an effect on the machine, not on the measuring chain."""
        return self._candidate(number).effect.STAGE != "sensor"

    def _candidate(self, number: int) -> Candidate:
        """Return the effect to which a coordinate belongs."""
        return [candidate for candidate in self.candidates for _ in candidate.coordinates][number]

    def tells(self, number: int) -> bool:
        """Return whether the data say clearly more of a coordinate than its prior does."""
        one = self.coordinates[number]
        pushed = abs(float(self.position[number])) > PUSHED and not one.is_strength and not one.is_angle
        known = math.sqrt(self.covariance[number, number] * one.least_precision) < TOLD
        return number in self.arcs or pushed or known

    @property
    def parts(self) -> list[tuple[Candidate, slice]]:
        """Each effect with the place of its coordinates among all of them."""
        ends = np.cumsum([0, *(len(one.coordinates) for one in self.candidates)]).tolist()
        return [(one, slice(ends[i], ends[i + 1])) for i, one in enumerate(self.candidates)]

    def values(self) -> list[dict[str, float]]:
        """Return each effect's values by name."""
        return [values_at(one.coordinates, self.position[own]) for one, own in self.parts]


def _relative(one: Coordinate, at: float) -> float:
    """Return the change of a coordinate, at a place, that changes its parameter by as much as it is away from zero."""
    slope = abs(one.value(at + STEP) - one.value(at - STEP)) / (2 * STEP)
    away = abs(one.value(at) - (one.parameter.zero or 0.0))
    return away / slope if slope else 1.0


def nothing(compared: Comparison) -> Fit:
    """Return the hypothesis that no effect is present."""
    empty = np.zeros((0, compared.residual.size))
    none = np.zeros((0, *compared.seen.shape), dtype=complex)
    response = np.zeros(compared.seen.shape, dtype=complex)
    evidence = log_density(compared, compared.residual, Widened(empty))
    return Fit((), np.zeros(0), np.zeros((0, 0)), response, none, evidence, compared.residual, empty)


def refined(
    chosen: Sequence[Candidate], start: np.ndarray, compared: Comparison, machine: Machine, predictor: Predictor
) -> Fit | None:
    """Return the fit of effects from a start; None where their motion cannot be computed."""
    response = Responses(chosen, machine, predictor)
    try:
        best = climb(response, start, precision_of(chosen), compared, MOST_STEPS)
        slopes = best.slopes
        if slopes is None:
            slopes = response.slopes(best.position, best.added, best.alive)
        return fit_at(response, best.position, best.added, slopes, compared)
    except UnpredictableError:
        return None


def fit_at(
    response: Responses, position: np.ndarray, added: np.ndarray, slopes: np.ndarray, compared: Comparison
) -> Fit:
    """Return the fit at its best position with Laplace's evidence."""
    chosen = response.chosen
    coordinates = tuple(c for candidate in chosen for c in candidate.coordinates)
    own = response.own(position, added)
    law = laws_of(compared, chosen, own)
    residual = compared.residual - compared.whitened(added)
    white = compared.whitened(slopes)
    least = np.array([c.least_precision for c in coordinates])
    information = white @ law.solve(white).T + np.diag(least)
    evidence = (
        log_density(compared, residual, law)
        + log_prior(coordinates, position)
        + 0.5 * len(coordinates) * math.log(2 * math.pi)
        - 0.5 * float(np.linalg.slogdet(information)[1])
    )
    by_strength = _by_strength(chosen, position, slopes, own, compared)
    wrongly = [] if by_strength is own else [laws_of(compared, chosen, by_strength).directions]
    open_strength = Widened(
        np.concatenate([law.directions, *wrongly, *(strength_columns(compared, one) for one in by_strength)])
    )
    covariance = np.linalg.inv(white @ open_strength.solve(white).T + np.diag(least))
    covariance = told_to_a_factor(covariance, chosen, position, own, compared)
    found = Fit(chosen, position, covariance, added, slopes, evidence, residual, law.directions)
    return replace(found, compared=compared)


def _by_strength(
    chosen: Sequence[Candidate],
    position: np.ndarray,
    slopes: np.ndarray,
    own: Sequence[np.ndarray],
    compared: Comparison,
) -> Sequence[np.ndarray]:
    """Return by how much the lines change with each effect's strengths, as a share of these.

    That is what it adds, where phases refer to the shaft; else they turn with what it adds at the reference probe.
    """
    if all(one.tied for one in compared.lines.conditions):
        return own
    found, start = [], 0
    for candidate, added in zip(chosen, own, strict=True):
        change = np.zeros_like(added)
        for number in candidate.strengths:
            share = _relative(candidate.coordinates[number], float(position[start + number]))
            change = change + share * slopes[start + number]
        found.append(change if change.any() else added)
        start += len(candidate.coordinates)
    return found


def density(response: Responses, position: np.ndarray, compared: Comparison) -> float:
    """Return the logarithm of likelihood and prior of one effect, its law's tolerance there included.

    Minus infinity where its motion cannot be computed.
    """
    try:
        added = response(position)
    except UnpredictableError:
        return -math.inf
    coordinates = [c for candidate in response.chosen for c in candidate.coordinates]
    residual = compared.residual - compared.whitened(added)
    law = laws_of(compared, response.chosen, [added])
    return log_density(compared, residual, law) + log_prior(coordinates, position)


def density_beside(fit: Fit, response: Responses, position: np.ndarray) -> float:
    """Return the same of the effects of a fit at another position, their laws' tolerance that of the fit."""
    assert fit.compared is not None
    try:
        added = response(position)
    except UnpredictableError:
        return -math.inf
    residual = fit.compared.residual - fit.compared.whitened(added)
    return log_density(fit.compared, residual, Widened(fit.law)) + log_prior(fit.coordinates, position)
