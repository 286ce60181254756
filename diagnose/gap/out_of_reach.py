"""Healthy lines that no values of a machine's uncertain parameters make: marks on a shaft, what a neighbour shakes."""

from __future__ import annotations

import numpy as np

from .baseline import Baseline
from .lines import OrderLines

#: A line that is this many times as large as the machine can make it tells nothing of its parameters.
OUT_OF_REACH = 10.0


def out_of_reach(current: Baseline, healthy: OrderLines) -> np.ndarray:
    """Return the size of those healthy lines, (probes, orders), that no values of the uncertain parameters make.

    A fit would bend all others for them.
    """
    own = len(current.coordinates)
    moved = np.tensordot(current.prior[:own] ** 2, np.abs(current.slopes[:own]) ** 2, 1)
    reach = np.where(healthy.seen, np.abs(current.lines) ** 2 + moved, 0.0).sum(axis=0)
    size = np.where(healthy.seen, np.abs(healthy.amplitudes) ** 2, 0.0).sum(axis=0)
    rms = np.sqrt(size / np.maximum(healthy.seen.sum(axis=0), 1) / 2)
    return np.where(size > OUT_OF_REACH**2 * reach, rms, 0.0)
