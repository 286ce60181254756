"""Strengths that only sizes of lines tell are known to a factor: what passes from a bearing to a sensor is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .evidence import STRENGTH_TOLERANCE_OF_SIZES, Comparison
from .hypotheses import Candidate
from .responses import STEP


def told_to_a_factor(
    covariance: np.ndarray,
    chosen: Sequence[Candidate],
    position: np.ndarray,
    own: Sequence[np.ndarray],
    compared: Comparison,
) -> np.ndarray:
    """Return the covariance of coordinates, strengths no better known than to the factor of sizes.

    Slopes of simulations scatter and seem to tell more. Effects of the measuring chain are exact.

    Parameters
    ----------
    covariance : ndarray (coordinates, coordinates)
    chosen : sequence of Candidate
    position : ndarray (coordinates,)
    own : sequence of ndarray (conditions, probes, orders)
        What each effect adds.
    compared : Comparison
    """
    phase = np.array([kind.phase for kind in compared.lines.kinds])
    scale, start = np.ones(position.size), 0
    for candidate, added in zip(chosen, own, strict=True):
        with_phase, sizes = (float((compared.whitened(added * part) ** 2).sum()) for part in (phase, ~phase))
        for number in candidate.strengths if sizes > with_phase and candidate.effect.STAGE != "sensor" else ():
            coordinate, z = candidate.coordinates[number], float(position[start + number])
            zero = coordinate.parameter.zero or 0.0
            slope = (coordinate.value(z + STEP) - coordinate.value(z - STEP)) / (2 * STEP)
            if slope:
                least = STRENGTH_TOLERANCE_OF_SIZES * abs((coordinate.value(z) - zero) / slope)
                scale[start + number] = max(least / np.sqrt(covariance[start + number, start + number]), 1.0)
        start += len(candidate.coordinates)
    return covariance * np.outer(scale, scale)
