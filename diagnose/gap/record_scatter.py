"""By how much what acts differs from one recording to the next although speed and load are the same.

A shaft that heats up bends more from record to record, deposits grow, a foundation settles: the same cause, at another
strength. Recordings of one condition say by which share, those of different conditions cannot; it is then a tolerance
of every hypothesis, of something unknown as well. Else what has the most freedom would describe the difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .lines import Condition, OrderLines
from .whitening import Whitening

#: Speeds within this share of each other are one: on a resonance of 1 % damping a line changes by 0.2 of itself then.
SAME_SPEED = 0.002
#: Loads within this share of the larger one are one.
SAME_LOAD = 0.02
#: Departures of an order that are so many times their noise, all probes together, tell.
CLEAR = 10.0
#: Shares that are tried, and by how much one must be likelier than none, in the logarithm.
SHARES = np.geomspace(1e-3, 0.5, 60)
LEAST_GAIN = 2.0


@dataclass(frozen=True)
class _Told:
    """Of the factors of one order in one condition: squared spread and noise of a part, and degrees of freedom."""

    power: float
    noise: float
    count: int


def record_scatter(lines: OrderLines, expected: np.ndarray) -> float:
    """Return the standard deviation of the factor of what acts, of its real and of its imaginary part.

    0 where no two recordings are of one condition, or nothing clear acts in them.

    Parameters
    ----------
    lines : OrderLines
        To explain.
    expected : ndarray (conditions, probes, orders), complex
        Of the machine without any effect.
    """
    phase = [order for order, kind in enumerate(lines.kinds) if kind.phase]
    told = [
        one
        for group in same_conditions(lines.conditions)
        for order in phase
        if (one := _of_order(lines, expected, group, order)) is not None
    ]
    power, noise, count = (np.array([getattr(one, name) for one in told]) for name in ("power", "noise", "count"))

    def density(share: np.ndarray) -> np.ndarray:
        variance = share[:, None] ** 2 + noise
        return -(power / variance + count * np.log(variance)).sum(axis=1)

    each = density(SHARES) - density(np.zeros(1))
    best = int(np.argmax(each))
    return float(SHARES[best]) if each[best] > LEAST_GAIN else 0.0


def same_conditions(conditions: Sequence[Condition]) -> list[list[int]]:
    """Return the numbers of conditions of nearly the same speed and load, in groups of two and more."""
    groups: list[list[int]] = []
    for number, one in enumerate(conditions):
        for group in groups:
            if _is_same(conditions[group[0]], one):
                group.append(number)
                break
        else:
            groups.append([number])
    return [group for group in groups if len(group) > 1]


def directions(response: np.ndarray, whitening: Whitening, share: float) -> np.ndarray:
    """Return the whitened directions (directions, reals) in which a response may differ by record, each order alone."""
    found = [np.zeros((0, whitening.factor.shape[0]))]
    for number in range(response.shape[0]) if share else ():
        own = np.zeros_like(response)
        own[number] = response[number]
        found.append(share * whitening.of_orders(own).reshape(-1, whitening.factor.shape[0]))
    return np.concatenate(found)


def alike(count: int, share: float) -> np.ndarray:
    """Return by which factors a covariance of lines in so many conditions grows, (conditions, conditions)."""
    return 1 + 2 * share**2 * np.eye(count)


def _is_same(one: Condition, other: Condition) -> bool:
    first, second = one.load or 0.0, other.load or 0.0
    same_load = abs(first - second) <= SAME_LOAD * max(abs(first), abs(second))
    return same_load and abs(one.speed_rpm - other.speed_rpm) <= SAME_SPEED * one.speed_rpm


def _of_order(lines: OrderLines, expected: np.ndarray, group: Sequence[int], order: int) -> _Told | None:
    """Return how the departures of one order differ within a group by a factor that all probes share."""
    rows = np.array(group)
    probes = lines.seen[rows, :, order].all(axis=0)
    if not probes.any():
        return None
    departure = (lines.amplitudes - expected)[rows][:, probes, order]
    weight = lines.deviations[rows][:, probes, order] ** -2.0
    mean = (weight * departure).sum(axis=0) / weight.sum(axis=0)
    told = (weight * np.abs(mean) ** 2).sum(axis=1)
    if told.sum() < CLEAR**2:
        return None
    factors = (weight * np.conj(mean) * departure).sum(axis=1) / told
    spread = float((np.abs(factors - factors.mean()) ** 2).sum()) / 2
    return _Told(spread, float((1 / told).mean()), len(group) - 1)
