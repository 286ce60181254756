"""Covariance of lines of which noise and model error tie only the conditions of one line together.

What unknowns do to all of them is of low rank beside that, so that no matrix of all lines is needed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .lines import OrderLines, in_blocks, seen_in
from .whitening import factor_of


@dataclass(frozen=True, eq=False)
class LineCovariance:
    """How lines become vectors of unit variance, and what they say of the unknowns.

    Attributes
    ----------
    inverse : ndarray (2, probes, orders, conditions, conditions)
        Of the lower Cholesky factor of noise and model error of each line's real and imaginary parts.
    parts : ndarray (2, conditions, probes, orders), bool
        `OrderLines.parts`.
    unknowns : ndarray (unknowns, reals)
        What the unknowns, each by its deviation, do to lines whitened by noise and model error alone.
    """

    inverse: np.ndarray
    parts: np.ndarray
    unknowns: np.ndarray

    def alone(self, lines: np.ndarray) -> np.ndarray:
        """Return lines (..., conditions, probes, orders) whitened by noise and model error alone, (..., reals)."""
        return _whitened_alone(lines, self.inverse, self.parts)

    def whole(self, lines: np.ndarray) -> np.ndarray:
        """Return lines (..., conditions, probes, orders) whitened by all that is uncertain, (..., reals)."""
        directions, deviations, _ = self._principal
        white = self.alone(lines)
        return white - ((1 - 1 / np.sqrt(1 + deviations**2)) * (white @ directions)) @ directions.T

    def density(self, white: np.ndarray) -> np.ndarray:
        """Return the logarithm of the density of vectors from `whole`, (..., reals), up to a constant."""
        scale = np.log(np.diagonal(self.inverse, axis1=-2, axis2=-1)).sum()
        return scale - 0.5 * (np.log1p(self._principal[1] ** 2).sum() + (white**2).sum(axis=-1))

    def told(self, lines: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what lines (conditions, probes, orders) say of the unknowns, in their deviations.

        Returns
        -------
        change : ndarray (unknowns,)
        root : ndarray (unknowns, unknowns)
            Its covariance is root root'.
        """
        directions, deviations, axes = self._principal
        known, widths = deviations.size, np.ones(len(axes))
        widths[:known] = 1 / np.sqrt(1 + deviations**2)
        along = deviations * widths[:known] ** 2 * (self.alone(lines) @ directions)
        return axes[:, :known] @ along, axes * widths

    def times(self, factor: float) -> LineCovariance:
        """Return the covariance times a factor."""
        return replace(self, inverse=self.inverse / np.sqrt(factor))

    @cached_property
    def _principal(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return orthonormal directions (reals, n) of the unknowns, the lines' deviations there, and their axes."""
        orthonormal, upper = np.linalg.qr(self.unknowns.T)
        turn, deviations, axes = np.linalg.svd(upper)
        return orthonormal @ turn[:, : deviations.size], deviations, axes.T


def line_covariance(
    lines: OrderLines, errors: np.ndarray, slopes: np.ndarray, deviations: np.ndarray
) -> LineCovariance:
    """Return the covariance of lines.

    Parameters
    ----------
    lines : OrderLines
        Their noise and what of them is seen counts.
    errors : ndarray (probes, orders, conditions, conditions)
        `error_blocks`.
    slopes : ndarray (unknowns, conditions, probes, orders)
    deviations : ndarray (unknowns,)
        Of the unknowns.
    """
    parts = lines.parts
    # What is unseen stands alone and has unit variance.
    inverse = np.linalg.inv(factor_of(noisy(errors, lines) + _on_diagonal(~seen_in(parts))))
    return LineCovariance(inverse, parts, deviations[:, None] * _whitened_alone(slopes, inverse, parts))


def noisy(errors: np.ndarray, lines: OrderLines) -> np.ndarray:
    """Return model error and noise of each line, (2, probes, orders, conditions, conditions); 0 where unseen."""
    seen = seen_in(lines.parts)
    errors = errors if lines.constant is None else errors + lines.constant[..., None, None] ** 2
    noise = np.where(seen, np.moveaxis(lines.deviations, 0, -1), 0.0) ** 2
    return (seen[..., :, None] & seen[..., None, :]) * errors + _on_diagonal(noise)


def _on_diagonal(values: np.ndarray) -> np.ndarray:
    return values[..., None] * np.eye(values.shape[-1])


def _whitened_alone(lines: np.ndarray, inverse: np.ndarray, parts: np.ndarray) -> np.ndarray:
    white = (inverse @ in_blocks(lines, parts)[..., None])[..., 0]
    return white[..., seen_in(parts)]
