"""How quickly with speed a model is wrong: told by the healthy lines where there are enough of them.

Between two healthy conditions the model error is interpolated. Supports with sharp resonances that a model lacks make
it change within a few per cent of speed; taken for smoother than that, it makes sound records look like something new.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .lines import Condition
from .model_error import ERROR_LENGTH_SPEED, ModelError

#: Changes of speed that are tried, and by how much the logarithm of the likelihood must rise to leave the usual one.
LENGTHS = (0.1, 0.05, 0.025, 0.0125)
LEAST_RISE = 5.0


def length_of(
    conditions: tuple[Condition, ...], left: np.ndarray, noise: np.ndarray, error: ModelError, parts: np.ndarray
) -> float:
    """Return the change of speed over which what a model misses of healthy lines changes much.

    Parameters
    ----------
    conditions : tuple of Condition
    left : ndarray (conditions, probes, orders), complex
        What is left of the lines.
    noise : ndarray (conditions, probes, orders)
        Variance of the real part and of the imaginary part; infinite where a line is not seen.
    error : ModelError
        Its size.
    parts : ndarray (orders,)
        Of how many parts each line is: 2, or 1 of one without phase.
    """

    def likelihood(length: float) -> float:
        return float(line_likelihoods(conditions, left, noise, replace(error, length=length), parts).sum())

    found, best = ERROR_LENGTH_SPEED, likelihood(ERROR_LENGTH_SPEED) + LEAST_RISE
    for length in LENGTHS:
        own = likelihood(length)
        if own > best:
            found, best = length, own
    return found


def line_likelihoods(
    conditions: tuple[Condition, ...], left: np.ndarray, noise: np.ndarray, error: ModelError, parts: np.ndarray
) -> np.ndarray:
    """Return the logarithm of each line's likelihood, up to a constant, (probes, orders); see `length_of`."""
    seen = np.isfinite(noise)
    size = np.where(seen, error.at(conditions), 0.0)
    # What is not seen is 0 with variance 1: it adds a constant.
    own = np.moveaxis(np.where(seen, noise, 1.0), 0, -1)
    each, values = np.moveaxis(size, 0, -1), np.moveaxis(np.where(seen, left, 0.0), 0, -1)
    covariance = error.alike(conditions) * each[..., :, None] * each[..., None, :]
    covariance = covariance + own[..., None] * np.eye(len(conditions))
    lower = np.linalg.cholesky(covariance)
    white = np.linalg.solve(lower, values[..., None])
    log_determinant = 2 * np.log(np.diagonal(lower, axis1=-2, axis2=-1)).sum(axis=-1)
    return -0.5 * (np.abs(white) ** 2).sum(axis=(-2, -1)) - 0.5 * parts * log_determinant
