"""What a candidate does at all: whether its lines can be seen, and the most that it could explain.

One or two responses say so; only candidates that pass are looked at on a grid (`screen`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...simulators.machine import Machine
from .evidence import Comparison
from .hypotheses import Candidate
from .predict import Predictor, UnpredictableError
from .responses import Responses, with_candidates

#: An effect whose lines stay below this share of their deviation, at its median and far above it, is not looked at.
INVISIBLE, STRONG = 0.3, 2.0


def in_the_middle(candidate: Candidate, machine: Machine, *, level: float = 0.0) -> Machine:
    """Return the machine with the candidate's effect at the middle of its prior, its strengths at a ``level``."""
    return with_candidates(machine, [candidate], _at_level(candidate, level))


def _at_level(candidate: Candidate, level: float) -> np.ndarray:
    return moved_to(np.zeros(len(candidate.coordinates)), candidate.strengths, [level] * len(candidate.strengths))


def explainable(
    candidate: Candidate, machine: Machine, predictor: Predictor, compared: Comparison, *, level: float = 0.0
) -> float:
    """Return the most of the squared residual that a candidate can explain, whatever its strength, angles and law.

    Its response at the prior's middle, strengths at a ``level`` in standard deviations, with a complex factor of its
    own at each order. -1 where it has none.
    """
    try:
        made = Responses([candidate], machine, predictor)(_at_level(candidate, level))
    except UnpredictableError:
        return -1.0
    present = np.flatnonzero(np.abs(made).max(axis=(0, 1)) > 0)
    if not present.size:
        return -1.0
    single = np.zeros((present.size, *made.shape), dtype=complex)
    for row, order in enumerate(present):
        single[row, :, :, order] = made[:, :, order]
    white = compared.whitened(np.concatenate([single, 1j * single]))
    size = np.linalg.norm(white, axis=1)
    basis = np.linalg.qr(white[size > 1e-9 * size.max()].T)[0]
    return float(((basis.T @ compared.residual) ** 2).sum())


def reach(candidate: Candidate, machine: Machine, predictor: Predictor, deviations: np.ndarray) -> float:
    """Return how far a candidate with one strength moves any line at its median, in standard deviations of noise.

    0 when it stays invisible even far above its median; infinite when it cannot be computed.
    """
    response = Responses([candidate], machine, predictor)
    centre = np.zeros(len(candidate.coordinates))
    try:
        first = response(centre)
        if not np.abs(first).max() > 0 or is_invisible(response, centre, first, candidate.strengths, deviations):
            return 0.0
        return float((np.abs(first) / deviations).max())
    except UnpredictableError:
        return math.inf


def is_invisible(
    response: Responses, centre: np.ndarray, first: np.ndarray, moving: tuple[int, ...], deviations: np.ndarray | None
) -> bool:
    """Return whether the lines stay far below their noise at the median, where they are ``first``, and far above it."""
    if deviations is None or (np.abs(first) > INVISIBLE * deviations).any():
        return False
    strong = response(moved_to(centre, moving, [STRONG] * len(moving)))
    return not (np.abs(strong) > INVISIBLE * deviations).any()


def moved_to(position: np.ndarray, numbers: Sequence[int], values: Sequence[float]) -> np.ndarray:
    """Return the position with some coordinates at other values."""
    changed = position.copy()
    changed[list(numbers)] = values
    return changed
