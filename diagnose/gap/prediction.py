"""How well a hypothesis predicts each condition from the others: a check of its evidence that needs no prior.

About the fit everything is linear and Gaussian: the lines have the mean and covariance that the hypothesis gives before
its values are known, and the density of one condition's lines given all others is in closed form.
"""

from __future__ import annotations

import math

import numpy as np

from .evidence import Comparison
from .refine import CIRCLE_PRECISION, Fit
from .result import Score
from .unknown_force import Unknown


def score_of(fit: Fit, compared: Comparison) -> Score:
    """Return the figures of a fit; ``compared`` is what it was fitted in when it does not say so itself."""
    where = fit.compared or compared
    slopes = where.whitened(fit.slopes) if fit.candidates else np.zeros((0, where.residual.size))
    precision = np.array([CIRCLE_PRECISION if c.is_angle else c.precision for c in fit.coordinates])
    # Before its values are known, the mean is that at the middle of the prior; an angle is taken where it was found.
    known = np.array([not c.is_angle for c in fit.coordinates], dtype=bool)
    left = fit.residual + (fit.position * known) @ slopes
    directions = np.concatenate([fit.law, slopes / np.sqrt(precision)[:, None]])
    return Score(fit.log_evidence, left_out(where, left, directions))


def score_of_unknown(unknown: Unknown, compared: Comparison) -> Score:
    """Return the figures of the hypothesis that something unknown acts."""
    widened = compared
    if unknown.kernels:
        widened = compared.widened(sum(unknown.kernels.values(), np.zeros_like(compared.covariance)))
    nothing = np.zeros((0, widened.residual.size))
    return Score(unknown.log_evidence, left_out(widened, widened.residual, nothing))


def left_out(compared: Comparison, residual: np.ndarray, directions: np.ndarray) -> float:
    """Return the sum over conditions of the logarithm of their lines' density given the lines of all others.

    Parameters
    ----------
    compared : Comparison
    residual : ndarray (reals,)
        Whitened: of the lines less their mean.
    directions : ndarray (directions, reals)
        Whitened: the covariance is I + D' D.
    """
    spread = compared.factor @ directions.T
    covariance = compared.factor @ compared.factor.T + spread @ spread.T
    precision = np.linalg.inv(covariance)
    weighted = precision @ (compared.factor @ residual)
    condition = np.concatenate([np.nonzero(part)[0] for part in compared.lines.parts])
    total = 0.0
    for one in np.unique(condition):
        rows = np.flatnonzero(condition == one)
        # The inverse of a block of the precision is the covariance given all others.
        block = precision[np.ix_(rows, rows)]
        power = float(weighted[rows] @ np.linalg.solve(block, weighted[rows]))
        total += -0.5 * power + 0.5 * float(np.linalg.slogdet(block)[1]) - 0.5 * rows.size * math.log(2 * math.pi)
    return total
