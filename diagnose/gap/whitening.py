"""Lines as real vectors of unit variance: divided by the lower Cholesky factor of their covariance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...simulators.errors import InvalidValueError
from .lines import stacked


@dataclass(frozen=True, eq=False)
class Whitening:
    """How lines become vectors of unit variance.

    Attributes
    ----------
    factor : ndarray (reals, reals)
        Lower Cholesky factor of the covariance of the stacked lines.
    parts : ndarray (2, conditions, probes, orders), bool
        `OrderLines.parts`.
    """

    factor: np.ndarray
    parts: np.ndarray

    def whole(self, response: np.ndarray) -> np.ndarray:
        """Return responses (..., conditions, probes, orders) as whitened vectors (..., reals)."""
        flat = stacked(response, self.parts)
        return lower_solved(self.factor, flat.reshape(-1, flat.shape[-1]).T).T.reshape(flat.shape)

    def of_orders(self, response: np.ndarray) -> np.ndarray:
        """Return the whitened vector of each order alone, and of each turned by a quarter, (2, orders, reals)."""
        return self._apart(response, self.parts.shape[2])

    def of_probes(self, response: np.ndarray) -> np.ndarray:
        """Return the same of each order at each probe alone, (2, orders, probes, reals)."""
        found = self._apart(response, 1)
        return found.reshape(2, self.parts.shape[3], self.parts.shape[2], -1)

    def of_each(self, sizes: np.ndarray) -> np.ndarray:
        """Return the whitened vector of each line alone, of those that are not zero, (lines, reals).

        ``sizes`` (conditions, probes, orders) are real.
        """
        place, _, inverse = self._pieces
        flat = stacked(sizes.astype(complex), self.parts)[place]
        rows = np.flatnonzero(flat)
        return flat[rows, None] * inverse[rows]

    def at_places(self, values: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Return the whitened vectors of lines of one order at one probe alone, and of each turned by a quarter.

        Parameters
        ----------
        values : ndarray (places, ways, conditions), complex
        places : ndarray of int (places, 2)
            Probe and order of each.

        Returns
        -------
        ndarray (2 x places x ways, reals)
        """
        _, edges, inverse = self._pieces
        found = np.zeros((2, *values.shape[:2], inverse.shape[1]))
        for number, (probe, order) in enumerate(places.tolist()):
            piece = order * self.parts.shape[2] + probe
            real, imaginary = self.parts[:, :, probe, order]
            for turn, own in enumerate((values[number], 1j * values[number])):
                flat = np.concatenate([own.real[:, real], own.imag[:, imaginary]], axis=1)
                found[turn, number] = flat @ inverse[edges[piece] : edges[piece + 1]]
        return found.reshape(-1, inverse.shape[1])

    def _apart(self, response: np.ndarray, together: int) -> np.ndarray:
        """Return the whitened vectors of so many neighbouring pieces of a response, of each with the others zero.

        A piece is small, so that multiplying its rows of the inverse is faster than solving for a vector of zeros.
        """
        place, edges, inverse = self._pieces
        flat = np.stack([stacked(response, self.parts), stacked(1j * response, self.parts)])[:, place]
        starts, ends = edges[:-1:together], edges[together::together]
        found = np.zeros((2, starts.size, flat.shape[1]))
        for number, (start, end) in enumerate(zip(starts, ends, strict=True)):
            own = flat[:, start:end]
            if own.any():
                found[:, number] = own @ inverse[start:end]
        return found

    @cached_property
    def _pieces(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the stacked lines order by order and in it probe by probe, where each begins, the inverse's rows."""
        probes, orders = self.parts.shape[2:]
        number = np.broadcast_to(np.arange(orders) * probes + np.arange(probes)[:, None], self.parts.shape[1:])
        piece = stacked(number + 1j * number, self.parts).astype(int)
        place = np.argsort(piece, kind="stable")
        edges = np.searchsorted(piece[place], np.arange(orders * probes + 1))
        inverse = lower_solved(self.factor, np.eye(self.factor.shape[0]))
        return place, edges, np.ascontiguousarray(inverse.T[place])


def factor_of(covariance: np.ndarray) -> np.ndarray:
    """Return the lower Cholesky factor; what rounding has spoilt is mended by a little of the diagonal.

    Of a matrix (reals, reals), or of each of many.
    """
    own = covariance * np.eye(covariance.shape[-1])
    for share in (0.0, 1e-10, 1e-8, 1e-6):
        try:
            return np.linalg.cholesky(covariance + share * own)
        except np.linalg.LinAlgError:
            continue
    raise InvalidValueError(
        "The lines' covariance is not positive: a channel is constant, or its noise is far below what numbers resolve. "
        "Leave that channel out."
    )


def lower_solved(lower: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the solution of a lower triangular system (reals, reals) for ``right`` (reals, ...)."""
    from scipy.linalg import solve_triangular

    # Looking for what is not a number in the matrix would take longer than the solution.
    return solve_triangular(lower, right, lower=True, check_finite=False)
