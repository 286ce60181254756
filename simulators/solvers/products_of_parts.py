"""Products without the zeros: parts of a machine that do not act on each other need no common product.

In a gearbox the shafts' horizontal motions are linked by nothing but interface forces: more than half of the numbers in
the matrices of a step are zero.

What is left out are zeros only, and each piece begins in an even column, as `product` sums even and odd columns apart:
no piece changes the bits of a sum.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..system import System
from .block_form import separate_parts

#: A product of its own costs a single lane as much as so many numbers of a matrix; more lanes share that.
COST_OF_PRODUCT = 150.0
#: More pieces than this are not looked for.
MOST_PIECES = 40


def in_order_of_parts(system: System) -> System:
    """Return the system with the motions and the forces of each part of its core side by side."""
    part_of = np.zeros(system.states, dtype=np.int64)
    for number, states in enumerate(separate_parts(system.core)):
        part_of[states] = number
    reads = _order(system.motion_rows, part_of)
    acts = _order(system.force_columns.T, part_of)
    place_of_read, place_of_act = np.argsort(reads), np.argsort(acts)
    return replace(
        system,
        motion_rows=np.ascontiguousarray(system.motion_rows[reads]),
        force_columns=np.ascontiguousarray(system.force_columns[:, acts]),
        probe_columns=np.ascontiguousarray(system.probe_columns[:, acts]),
        force_directions=system.force_directions[:, acts],
        inputs=tuple(place_of_read[rows] for rows in system.inputs),
        outputs=tuple(place_of_act[columns] for columns in system.outputs),
    )


def _order(vectors: np.ndarray, part_of: np.ndarray) -> np.ndarray:
    if not vectors.size:
        return np.arange(vectors.shape[0])
    return np.argsort(part_of[np.argmax(vectors != 0, axis=1)], kind="stable")


def pieces(matrix: np.ndarray, *, rows: int, lanes: int) -> list[tuple[int, int, int, int]]:
    """Return the pieces of a matrix that hold all that is not zero and cost least: first and last row and column.

    Parameters
    ----------
    matrix : ndarray
    rows : int
        A piece costs as if its height were a multiple of this.
    lanes : int
        Runs side by side.
    """
    runs = _runs(matrix) if matrix.size else []
    if not 1 < len(runs) <= MOST_PIECES:
        return [] if not runs else [(0, matrix.shape[0], 0, matrix.shape[1])]
    each = COST_OF_PRODUCT / lanes
    best: list[tuple[float, list[tuple[int, int, int, int]]]] = [(0.0, [])]
    for stop in range(1, len(runs) + 1):
        found = []
        for start in range(stop):
            some = runs[start:stop]
            piece = some[0][0], some[-1][1], min(run[2] for run in some), max(run[3] for run in some)
            cost = -(-(piece[1] - piece[0]) // rows) * rows * (piece[3] - piece[2]) + each
            found.append((best[start][0] + cost, [*best[start][1], piece]))
        best.append(min(found, key=lambda one: one[0]))
    return best[-1][1]


def _runs(matrix: np.ndarray) -> list[tuple[int, int, int, int]]:
    """Return runs of rows that begin and end in the same column; rows of zeros are left out."""
    there = matrix != 0
    first = np.argmax(there, axis=1) // 2 * 2
    last = matrix.shape[1] - np.argmax(there[:, ::-1], axis=1)
    found: list[tuple[int, int, int, int]] = []
    for row in np.flatnonzero(there.any(axis=1)).tolist():
        own = int(first[row]), int(last[row])
        if found and found[-1][1] == row and found[-1][2:] == own:
            found[-1] = (found[-1][0], row + 1, *own)
        else:
            found.append((row, row + 1, *own))
    return found
