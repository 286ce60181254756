"""How well a hypothesis predicts each condition from the others: a check of its evidence that needs no prior.

About the fit everything is linear and Gaussian: the lines have the mean and covariance that the hypothesis gives before
its values are known, and the density of one condition's lines given all others is in closed form.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .evidence import Comparison, Widened
from .refine import Fit
from .result import Score
from .unknown_force import Unknown
from .whitening import lower_solved


def score_of(fit: Fit, compared: Comparison) -> Score:
    """Return the figures of a fit; ``compared`` is what it was fitted in when it does not say so itself."""
    where = fit.compared or compared
    slopes = where.whitened(fit.slopes) if fit.candidates else np.zeros((0, where.residual.size))
    left, directions = prior_of(fit, fit.residual, slopes, fit.law)
    return Score(fit.log_evidence, left_out(where, left, directions))


def prior_of(fit: Fit, residual: np.ndarray, slopes: np.ndarray, law: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what the lines differ from their mean, and the directions they spread in, before the values are known.

    Parameters
    ----------
    fit : Fit
    residual : ndarray (reals,)
        Whitened, at the fitted values.
    slopes : ndarray (coordinates, reals)
        Whitened.
    law : ndarray (directions, reals)
        Whitened directions in which the law may be wrong.
    """
    precision = np.array([c.least_precision for c in fit.coordinates])
    # The mean is that at the middle of the prior; an angle is taken where it was found.
    known = np.array([not c.is_angle for c in fit.coordinates], dtype=bool)
    return residual + (fit.position * known) @ slopes, np.concatenate([law, slopes / np.sqrt(precision)[:, None]])


def score_of_unknown(unknown: Unknown, compared: Comparison) -> Score:
    """Return the figures of the hypothesis that something unknown acts."""
    widened = compared
    if unknown.kernels:
        widened = compared.widened(sum(unknown.kernels.values(), np.zeros_like(compared.covariance)))
    nothing = np.zeros((0, widened.residual.size))
    return Score(unknown.log_evidence, left_out(widened, widened.residual, nothing))


def left_out(compared: Comparison, residual: np.ndarray, directions: np.ndarray) -> float:
    """Return the sum over conditions of the logarithm of their lines' density given the lines of all others.

    Parameters as in `given_others`.
    """
    conditions, widened = np.unique(np.nonzero(compared.seen)[0]), Widened(directions)
    each = [_given_others(compared, residual, widened, _rows(compared, [int(one)])) for one in conditions]
    return sum(_log_density(error, own) for error, own in each)


@dataclass(frozen=True)
class Predicted:
    """How probable some lines are, given others.

    Attributes
    ----------
    log_density : float
    chance : float
        Of a distance as large as theirs, were the hypothesis true.
    own_chance : float
        The same of the lines that the hypothesis makes; 1 where it makes none.
    """

    log_density: float
    chance: float
    own_chance: float


def given_others(
    compared: Comparison,
    residual: np.ndarray,
    directions: np.ndarray,
    conditions: Sequence[int],
    *,
    made: np.ndarray | None = None,
) -> Predicted:
    """Return how probable the lines of some conditions are, given those of all others.

    Parameters
    ----------
    compared : Comparison
    residual : ndarray (reals,)
        Whitened: of the lines less their mean.
    directions : ndarray (directions, reals)
        Whitened: the covariance is I + D' D.
    conditions : sequence of int
    made : ndarray (orders,), bool, optional
        The orders that the hypothesis makes; all when not given.
    """
    rows = _rows(compared, conditions)
    error, own = _given_others(compared, residual, Widened(directions), rows)
    order = np.concatenate([np.nonzero(part)[2] for part in compared.lines.parts])[rows]
    chosen = np.flatnonzero(np.ones(rows.size, dtype=bool) if made is None else made[order])
    own_chance = _distance(error[chosen], own[np.ix_(chosen, chosen)])[1]
    return Predicted(_log_density(error, own), _distance(error, own)[1], own_chance)


def _rows(compared: Comparison, conditions: Sequence[int]) -> np.ndarray:
    """Return the places of some conditions' lines among the stacked ones."""
    condition = np.concatenate([np.nonzero(part)[0] for part in compared.lines.parts])
    return np.flatnonzero(np.isin(condition, conditions))


def _given_others(
    compared: Comparison, residual: np.ndarray, widened: Widened, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return by how much the lines in ``rows`` miss what all others let expect, and the covariance of that."""
    back = lower_solved(compared.factor, np.eye(residual.size)[:, rows])
    # The inverse of a block of the precision is the covariance given all others.
    own = np.linalg.inv(back.T @ widened.solve(back.T).T)
    return own @ (back.T @ widened.solve(residual)), own


def _log_density(error: np.ndarray, covariance: np.ndarray) -> float:
    scale = float(np.linalg.slogdet(covariance)[1]) + error.size * math.log(2 * math.pi)
    return -0.5 * (_distance(error, covariance)[0] + scale)


def _distance(error: np.ndarray, covariance: np.ndarray) -> tuple[float, float]:
    """Return the squared distance in standard deviations, and its chance."""
    from scipy.stats import chi2

    if not error.size:
        return 0.0, 1.0
    power = float(error @ np.linalg.solve(covariance, error))
    return power, float(chi2.sf(power, error.size))
