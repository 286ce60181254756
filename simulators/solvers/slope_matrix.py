"""What slopes of forces along a motion do to its harmonics, as a real matrix: a compiled loop.

In a step of Newton's method this is asked for every pair of a force and a motion that it reads, in every lane; with
numpy each pair would cost a dozen calls on small arrays.
"""

from __future__ import annotations

import numpy as np

from ..compiled_code import njit


@njit(cache=True, error_model="numpy", nogil=True)
def _fill(matrix, spectrum, acts, places, factors):  # type: ignore[no-untyped-def]
    lanes, orders = factors.shape[0], factors.shape[1]
    for lane in range(lanes):
        for pair in range(acts.size):
            act, place = acts[pair], places[pair]
            for k in range(orders):
                for m in range(orders):
                    factor = factors[lane, m, pair]
                    one = factor * (spectrum[pair, lane, k - m] if k >= m else np.conj(spectrum[pair, lane, m - k]))
                    # The mean has no conjugate beside it.
                    other = np.conj(factor) * spectrum[pair, lane, k + m] if m > 0 else 0j
                    plus, minus = one + other, one - other
                    matrix[lane, 0, act, k, 0, place, m] += plus.real
                    matrix[lane, 0, act, k, 1, place, m] -= minus.imag
                    matrix[lane, 1, act, k, 0, place, m] += plus.imag
                    matrix[lane, 1, act, k, 1, place, m] += minus.real


def slope_matrix(
    spectrum: np.ndarray, acts: np.ndarray, places: np.ndarray, factors: np.ndarray, *, sizes: tuple[int, int]
) -> np.ndarray:
    """Return S for real parts, then imaginary parts, shape (lanes, 2 x forces x (K + 1), 2 x displacements x (K + 1)).

    In both parts force by force (or displacement by displacement) the harmonics 0 to K.

    Parameters
    ----------
    spectrum : ndarray (pairs, lanes, 2 K + 1), complex
        Harmonics of the slope of a force in a motion.
    acts, places : ndarray of int (pairs,)
        Number of each pair's force, and of the displacement that its motion is or whose velocity it is.
    factors : ndarray (lanes, K + 1, pairs), complex
        Motion over displacement.
    sizes : tuple of int
        Number of forces, of displacements.
    """
    lanes, orders = factors.shape[:2]
    matrix = np.zeros((lanes, 2, sizes[0], orders, 2, sizes[1], orders))
    _fill(matrix, np.ascontiguousarray(spectrum), acts, places, np.ascontiguousarray(factors))
    return matrix.reshape(lanes, 2 * sizes[0] * orders, -1)
