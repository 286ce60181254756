"""Particle swarm optimisation: minimum of a function without derivatives, within bounds.

J. Kennedy and R. Eberhart, Proc. IEEE Int. Conf. Neural Networks (1995) 1942; coefficients that converge from
M. Clerc and J. Kennedy, IEEE Trans. Evolutionary Computation 6 (2002) 58-73.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .errors import InvalidValueError

# Clerc and Kennedy: constriction 0.7298 of inertia 1 and attractions 2.05.
_INERTIA, _ATTRACTION = 0.7298, 0.7298 * 2.05


@dataclass(frozen=True)
class SwarmResult:
    """Where a swarm ended.

    Attributes
    ----------
    best : ndarray (unknowns,)
    value : float
        Of the objective there.
    history : ndarray (iterations + 1,)
        Best value after each iteration, the first after the start.
    """

    best: np.ndarray
    value: float
    history: np.ndarray


def particle_swarm(
    objective: Callable[[np.ndarray], np.ndarray],
    *,
    low: np.ndarray,
    high: np.ndarray,
    seed: int,
    particles: int = 50,
    iterations: int = 100,
) -> SwarmResult:
    """Return the best point that a swarm finds.

    Parameters
    ----------
    objective : callable
        ``objective(points (particles, unknowns)) -> values (particles,)``.
    low, high : ndarray (unknowns,)
        Bounds. A particle that would leave them stops at them.
    seed : int
    particles, iterations : int
        50 and 100 in paper 000.
    """
    low, high = np.asarray(low, float), np.asarray(high, float)
    if particles < 2 or iterations < 1 or low.shape != high.shape or not np.all(low < high):
        raise InvalidValueError(
            f"Swarm of {particles} particles, {iterations} iterations, bounds {low} to {high}; allowed: 2 or more, "
            "1 or more, low below high. Correct them."
        )
    generator = np.random.default_rng(seed)
    shape = (particles, low.size)
    points = low + (high - low) * generator.random(shape)
    speeds = (high - low) * (generator.random(shape) - 0.5)
    own_best, own_value = points.copy(), objective(points)
    history = [own_value.min()]
    for _ in range(iterations):
        leader = own_best[np.argmin(own_value)]
        pull_own, pull_leader = _ATTRACTION * generator.random((2, *shape))
        speeds = _INERTIA * speeds + pull_own * (own_best - points) + pull_leader * (leader - points)
        points = points + speeds
        outside = (points < low) | (points > high)
        points, speeds = np.clip(points, low, high), np.where(outside, 0.0, speeds)
        value = objective(points)
        better = value < own_value
        own_best[better], own_value[better] = points[better], value[better]
        history.append(own_value.min())
    winner = int(np.argmin(own_value))
    return SwarmResult(own_best[winner], float(own_value[winner]), np.array(history))
