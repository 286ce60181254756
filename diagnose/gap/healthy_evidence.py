"""How probable healthy lines are about a calibrated machine, its unknowns and the probes' gains integrated out.

By how much the model is wrong beside them is taken as likely as it can be.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .baseline import Baseline, model_error, similarity
from .lines import OrderLines
from .whitening import factor_of

#: Factors of the usual model error of which the likeliest counts.
ERROR_FACTORS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
#: Deviations of a sum of squares within which nothing is missed.
WITHIN = 3.0


@dataclass(frozen=True, eq=False)
class HealthyWhitening:
    """How healthy lines become vectors of unit variance about a machine.

    Noise and model error tie only the conditions of one line together; what the unknowns do to the lines is of low rank
    beside that, so that no matrix of all lines is needed.

    Attributes
    ----------
    inverse : ndarray (2, probes, orders, conditions, conditions)
        Of the lower Cholesky factor of noise and model error of each line's real and imaginary parts.
    seen : ndarray (2, probes, orders, conditions), bool
        Which of them say something.
    unknowns : ndarray (reals, unknowns)
        What the unknowns, each within its prior, do to lines whitened by noise and model error alone.
    directions : ndarray (reals, unknowns)
        Orthonormal, along which they do it.
    deviations : ndarray (unknowns,)
        Of the lines along these, by the unknowns alone.
    """

    inverse: np.ndarray
    seen: np.ndarray
    unknowns: np.ndarray
    directions: np.ndarray
    deviations: np.ndarray

    def alone(self, lines: np.ndarray) -> np.ndarray:
        """Return lines (..., conditions, probes, orders) whitened by noise and model error alone, (..., reals)."""
        return _whitened_alone(lines, self.inverse, self.seen)

    def whole(self, lines: np.ndarray) -> np.ndarray:
        """Return lines (..., conditions, probes, orders) whitened by all that is uncertain, (..., reals)."""
        white = self.alone(lines)
        less = 1 - 1 / np.sqrt(1 + self.deviations**2)
        return white - (less * (white @ self.directions)) @ self.directions.T

    def density(self, white: np.ndarray) -> np.ndarray:
        """Return the logarithm of the density of whitened residuals (..., reals), up to a constant."""
        scale = np.log(np.diagonal(self.inverse, axis1=-2, axis2=-1)).sum()
        return scale - 0.5 * (np.log1p(self.deviations**2).sum() + (white**2).sum(axis=-1))


def whitening_about(current: Baseline, healthy: OrderLines, factor: float) -> HealthyWhitening:
    """Return the whitening about a machine with the usual model error times a factor."""
    seen = np.moveaxis(healthy.parts, 1, -1)
    inverse = np.linalg.inv(factor_of(_covariances(current, healthy, factor, seen)))
    unknowns = (_whitened_alone(current.slopes, inverse, seen) * current.prior[:, None]).T
    orthonormal, upper = np.linalg.qr(unknowns)
    turn, deviations, _ = np.linalg.svd(upper, full_matrices=False)
    return HealthyWhitening(inverse, seen, unknowns, orthonormal @ turn, deviations)


def _covariances(current: Baseline, healthy: OrderLines, factor: float, seen: np.ndarray) -> np.ndarray:
    """Return noise and model error of each line over the conditions; what says nothing is of unit variance."""
    error = factor * model_error(current.lines)
    both = seen[..., :, None] & seen[..., None, :]
    found = both * similarity(healthy.conditions) * error[..., None, None] ** 2
    own = np.arange(seen.shape[-1])
    found[..., own, own] += np.where(seen, np.moveaxis(healthy.deviations, 0, -1), 1.0) ** 2
    return found


def _whitened_alone(lines: np.ndarray, inverse: np.ndarray, seen: np.ndarray) -> np.ndarray:
    each = np.moveaxis(np.stack([np.real(lines), np.imag(lines)], axis=-4), -3, -1)
    white = (inverse @ np.where(seen, each, 0.0)[..., None])[..., 0]
    return white[..., seen]


def left_over(current: Baseline, healthy: OrderLines) -> np.ndarray:
    """Return what the machine leaves of its healthy lines, shape (conditions, probes, orders)."""
    return healthy.amplitudes - current.lines - np.tensordot(current.prior_mean, current.slopes, 1)


def evidence(current: Baseline, healthy: OrderLines) -> float:
    """Return the logarithm of the evidence of the healthy lines, up to a constant."""
    return max(density for _, _, density in _each(current, healthy))


def is_explained(current: Baseline, healthy: OrderLines) -> bool:
    """Return whether the lines are as near as noise, the usual model error and what is uncertain allow."""
    (_, white, first), *others = _each(current, healthy)
    likeliest = all(first >= density for _, _, density in others)
    return likeliest and float(white @ white) <= white.size + WITHIN * math.sqrt(2 * white.size)


def fitted(current: Baseline, healthy: OrderLines) -> tuple[np.ndarray, np.ndarray]:
    """Return the most probable change of the machine's unknowns and the gains, by their slopes, and its covariance."""
    whitening, _, _ = max(_each(current, healthy), key=lambda one: one[2])
    left = whitening.alone(left_over(current, healthy))
    inner = whitening.unknowns.T @ whitening.unknowns + np.eye(current.prior.size)
    covariance = current.prior[:, None] * np.linalg.inv(inner) * current.prior
    change = current.prior * np.linalg.solve(inner, whitening.unknowns.T @ left)
    return current.prior_mean + change, covariance


def whitened(current: Baseline, healthy: OrderLines, factor: float) -> tuple[HealthyWhitening, np.ndarray, float]:
    """Return the whitening, what the machine leaves of the lines in it, and the logarithm of its density."""
    whitening = whitening_about(current, healthy, factor)
    white = whitening.whole(left_over(current, healthy))
    return whitening, white, float(whitening.density(white))


def _each(current: Baseline, healthy: OrderLines) -> list[tuple[HealthyWhitening, np.ndarray, float]]:
    return [whitened(current, healthy, factor) for factor in ERROR_FACTORS]
