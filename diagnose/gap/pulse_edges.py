"""How far off the shaft's angle may be because the tacho's pulses are known to a sample only.

The edge of a pulse that rises between two samples lies anywhere between them. Where the speed is steady and no whole
number of pulses falls on a whole number of samples, the edges lie differently each time, and together they tell the
angle well. Where it does, each is off by the same part of a sample, and so is the phase of every line.
"""

from __future__ import annotations

import math

import numpy as np

#: Share of a pulse's height within which a sample lies at its foot or its top, and share of the edges without a sample
#: between these from which on they count as steps.
AT_LEVEL, STEPS = 0.1, 0.9
#: Samples over which edges halfway between two samples lie about the true law, and what a law of least squares adds.
LARGEST_SPREAD = 1.1


def between_edges(away_samples: np.ndarray) -> tuple[float, float]:
    """Return by how many samples a law of the angle passes the middle of all edges, and how far that is uncertain.

    A law of least squares lies off the middle where most edges fall to the same side. All shifts that leave every edge
    within half a sample are as likely.

    Parameters
    ----------
    away_samples : ndarray (pulses,)
        By how many samples the law passes each edge, taken as halfway between two samples.

    Returns
    -------
    tuple of float
        What to take from the law, and the standard deviation of what is left, in samples. Both 0 where the edges lie
        further apart: the speed wanders, or the pulses do, and they lie on any part of a sample.
    """
    spread = float(np.ptp(away_samples))
    if spread > LARGEST_SPREAD:
        return 0.0, 0.0
    middle = float(away_samples.max() + away_samples.min()) / 2
    return middle, max(1.0 - spread, 0.0) / math.sqrt(12)


def are_steps(signal: np.ndarray, edges: np.ndarray) -> bool:
    """Return whether most pulses have no sample between foot and top.

    Parameters
    ----------
    signal : ndarray (samples,)
        The tacho.
    edges : ndarray (pulses,)
        Where it rises, in samples.
    """
    low, high = signal.min(), signal.max()
    before = np.clip(np.floor(edges).astype(int), 0, signal.size - 2)
    height = (signal[np.stack([before, before + 1])] - low) / (high - low)
    return float(((height[0] < AT_LEVEL) & (height[1] > 1 - AT_LEVEL)).mean()) >= STEPS
