"""How probable healthy lines are about a calibrated machine, its unknowns and the probes' gains integrated out.

By how much the model is wrong beside them is taken as likely as it can be.
"""

from __future__ import annotations

import math

import numpy as np

from .baseline import Baseline, error_covariance, model_error, noise_covariance
from .lines import OrderLines, stacked
from .whitening import factor_of, lower_solved

#: Factors of the usual model error of which the likeliest counts.
ERROR_FACTORS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
#: Deviations of a sum of squares within which nothing is missed.
WITHIN = 3.0


def lines_covariance(current: Baseline, healthy: OrderLines, factor: float) -> np.ndarray:
    """Return the covariance of noise and model error, the usual one times a factor."""
    error = factor * model_error(current.lines)
    return noise_covariance(healthy) + error_covariance(healthy.conditions, error, healthy.parts)


def factored(current: Baseline, healthy: OrderLines, factor: float) -> np.ndarray:
    """Return the Cholesky factor of the lines' covariance about the machine, of all that is uncertain."""
    slopes = stacked(current.slopes, healthy.parts)
    return factor_of(lines_covariance(current, healthy, factor) + (slopes.T * current.prior**2) @ slopes)


def whitened(current: Baseline, healthy: OrderLines, factor: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the factor of `factored`, the whitened residual, and the logarithm of its density up to a constant."""
    lower = factored(current, healthy, factor)
    left = healthy.amplitudes - current.lines - np.tensordot(current.prior_mean, current.slopes, 1)
    white = lower_solved(lower, stacked(left, healthy.parts))
    return lower, white, density(lower, white)


def density(lower: np.ndarray, white: np.ndarray) -> float:
    """Return the logarithm of the density of a whitened residual, up to a constant."""
    return -0.5 * float(white @ white) - float(np.log(np.diag(lower)).sum())


def evidence(current: Baseline, healthy: OrderLines) -> float:
    """Return the logarithm of the evidence of the healthy lines, up to a constant."""
    return max(whitened(current, healthy, factor)[2] for factor in ERROR_FACTORS)


def is_explained(current: Baseline, healthy: OrderLines) -> bool:
    """Return whether the lines are as near as noise, the usual model error and what is uncertain allow."""
    each = [whitened(current, healthy, factor)[1:] for factor in ERROR_FACTORS]
    (white, first), *others = each
    likeliest = all(first >= density for _, density in others)
    return likeliest and float(white @ white) <= white.size + WITHIN * math.sqrt(2 * white.size)


def fitted(current: Baseline, healthy: OrderLines) -> tuple[np.ndarray, np.ndarray]:
    """Return the most probable change of the machine's unknowns and the gains, by their slopes, and its covariance."""
    slopes, precision = stacked(current.slopes, healthy.parts), current.prior**-2
    factor = max(ERROR_FACTORS, key=lambda one: whitened(current, healthy, one)[2])
    moved = np.linalg.solve(lines_covariance(current, healthy, factor), slopes.T)
    left = stacked(healthy.amplitudes - current.lines, healthy.parts)
    covariance = np.linalg.inv(slopes @ moved + np.diag(precision))
    return covariance @ (moved.T @ left + precision * current.prior_mean), covariance
