"""The best step of a quadratic whose every coordinate may move so far and no further.

A Newton step that goes too far in one coordinate, because the lines hardly tell it, would drag all others to a crawl if
it were scaled as a whole, and point elsewhere, perhaps uphill, if that coordinate alone were cut. Here the others are
solved for again beside what was cut.
"""

from __future__ import annotations

import numpy as np


def boxed_step(curvature: np.ndarray, gradient: np.ndarray, limit: float) -> np.ndarray:
    """Return a step that lowers 0.5 m' H m - g' m, with no coordinate of it larger than a limit.

    Parameters
    ----------
    curvature : ndarray (coordinates, coordinates)
        H, symmetric and positive definite.
    gradient : ndarray (coordinates,)
        g: minus the slope of what is to become small.
    limit : float
    """
    newton = np.linalg.solve(curvature, gradient)
    scaled = newton * min(1.0, limit / max(float(np.abs(newton).max(initial=0.0)), 1e-300))
    boxed = _cut(curvature, gradient, newton, limit)
    # Cut one after the other, not all corners are found: never worse than the scaled step.
    return min((boxed, scaled), key=lambda move: 0.5 * float(move @ curvature @ move) - float(gradient @ move))


def _cut(curvature: np.ndarray, gradient: np.ndarray, newton: np.ndarray, limit: float) -> np.ndarray:
    """Return the step with what lies furthest beyond the limit put on it, one after the other."""
    move, free = newton.copy(), np.ones(gradient.size, dtype=bool)
    while free.any():
        beyond = np.where(free, np.abs(move), 0.0)
        furthest = int(np.argmax(beyond))
        if beyond[furthest] <= limit:
            break
        move[furthest] = np.copysign(limit, move[furthest])
        free[furthest] = False
        held = curvature[np.ix_(free, ~free)] @ move[~free]
        move[free] = np.linalg.solve(curvature[np.ix_(free, free)], gradient[free] - held)
    return move
