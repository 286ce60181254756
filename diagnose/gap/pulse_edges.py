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
#: Samples about a law of least squares over which edges may lie that another law passes within half a sample.
LARGEST_SPREAD = 1.5
#: Parts of a record of which the outermost edges are looked at.
PARTS = 64
#: Samples by which rounding may move an edge.
ROUNDING = 1e-3


def between_edges(
    times_s: np.ndarray, away_samples: np.ndarray, degree: int, *, duration_s: float
) -> tuple[np.polynomial.Polynomial, float] | None:
    """Return what a law of the angle lacks that passes the middle of all edges, and how far it may be shifted still.

    Of the laws that pass every edge within half a sample the one whose largest distance is least (a linear programme);
    a law of least squares lies off where most edges fall to the same side.

    Parameters
    ----------
    times_s : ndarray (pulses,)
        Where rising edges were found, halfway between two samples.
    away_samples : ndarray (pulses,)
        By how many samples the law passes each of them.
    degree : int
        Of the polynomial of time that is returned.
    duration_s : float

    Returns
    -------
    tuple, or None
        Polynomial, in samples, to take from the law, and the standard deviation of what is left, in samples: all shifts
        that leave every edge within half a sample are as likely. None where no law passes them so near: the speed
        wanders, or the pulses do, and the edges lie on any part of a sample.
    """
    from scipy.optimize import linprog

    if float(np.ptp(away_samples)) > LARGEST_SPREAD:
        return None
    # Of a long record only the outermost edges of each part bound the law.
    parts = np.array_split(np.arange(times_s.size), min(PARTS, times_s.size))
    bounding = np.unique([[part[np.argmax(away_samples[part])], part[np.argmin(away_samples[part])]] for part in parts])
    away = away_samples[bounding]
    powers = np.polynomial.polynomial.polyvander(2 * times_s[bounding] / duration_s - 1, degree)
    least = np.full((away.size, 1), -1.0)
    found = linprog(
        np.append(np.zeros(degree + 1), 1.0),
        A_ub=np.block([[powers, least], [-powers, least]]),
        b_ub=np.concatenate([away, -away]),
        bounds=[(None, None)] * (degree + 1) + [(0.0, None)],
    )
    if found.status != 0:
        return None
    lacking = np.polynomial.Polynomial(found.x[:-1], domain=[0.0, duration_s])
    furthest = float(np.abs(away_samples - lacking(times_s)).max())
    return None if furthest > 0.5 + ROUNDING else (lacking, max(1.0 - 2 * furthest, 0.0) / math.sqrt(12))


def are_steps(signal: np.ndarray, edges: np.ndarray) -> bool:
    """Return whether most pulses have no sample between foot and top."""
    low, high = np.percentile(signal, [0.1, 99.9])
    before = np.clip(np.floor(edges).astype(int), 0, signal.size - 2)
    height = (signal[np.stack([before, before + 1])] - low) / (high - low)
    return float(((height[0] < AT_LEVEL) & (height[1] > 1 - AT_LEVEL)).mean()) >= STEPS
