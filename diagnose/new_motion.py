"""How the new part of 2X and 3X moves: round with the shaft, or to and fro in one direction.

A force that turns with the shaft, as of a misaligned coupling, whirls it forward at its multiples as at 1X. A contact
that stands still pushes in its own direction: forward and backward circles are equal there, and friction turns the
motion backward (A. Muszynska, Rotordynamics, CRC Press 2005, chapter 5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .observe import Observation
from .signal.orbit import Ellipse, ellipse

_ROUND = 0.3  # minor over major axis of 1X below which a support is too unlike in its directions to tell
_HALF, _WIDTH = 0.5, 0.15  # minor over major axis, of that of 1X, at which a contact is as likely as not


@dataclass(frozen=True)
class NewMotion:
    """The largest new part of a multiple of 1X at two probes at right angles.

    Attributes
    ----------
    contact : float
        How surely it is that of a contact which stands still, 0 to 1.
    vertical : bool
        Whether it goes nearer to up and down than to sideways, by 30 degrees or less from the vertical.
    """

    contact: float
    vertical: bool


def new_motion(now: Observation, baseline: Observation, orders: list[float]) -> NewMotion | None:
    """Return how the new part of 2X or 3X moves; None without a tacho, two directions at one place, or a round 1X.

    Parameters
    ----------
    now, baseline : Observation
        Comparable ones.
    orders : list of float
        Those of 2X and 3X that are the shaft's own.
    """
    if now.order_vectors is None or baseline.order_vectors is None:
        return None
    if now.order_vectors.shape != baseline.order_vectors.shape:
        return None
    added = now.order_vectors - baseline.order_vectors
    best: tuple[float, Ellipse, float] | None = None
    for x, y in _pairs(now):
        first = ellipse(now.order_vectors[x, 0], now.order_vectors[y, 0])
        if abs(first.direction) < _ROUND:
            continue
        for order in orders:
            if not any(now.is_significant(now.line(order, channel=channel)) for channel in (x, y)):
                continue
            one = ellipse(added[x, int(order) - 1], added[y, int(order) - 1])
            size = one.major / max(first.major, 1e-300)
            if best is None or size > best[0]:
                best = size, one, one.direction / first.direction
    if best is None:
        return None
    _, one, forward = best
    contact = 1.0 / (1.0 + float(np.exp(np.clip((forward - _HALF) / _WIDTH, -40, 40))))
    return NewMotion(contact, abs(one.inclination_rad) > np.pi / 3)


def _pairs(now: Observation) -> list[tuple[int, int]]:
    """Return the pairs of horizontal and vertical channels of one quantity at one place."""
    channels = now.recording.channels
    return [
        (x, y)
        for x, first in enumerate(channels)
        for y, second in enumerate(channels)
        if (first.direction, second.direction) == ("horizontal", "vertical")
        and first.location is not None
        and (first.location, first.quantity) == (second.location, second.quantity)
    ]
