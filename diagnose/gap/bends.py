"""How a machine's lines bend where its unknowns are uncertain: what its slopes do not tell between healthy speeds.

A resonance that lies between two healthy speeds is where nobody saw it. Lines that rise there by a factor have no slope
that says so. Machines drawn from what the healthy lines leave open are computed; by how much their lines differ from
what the slopes promise joins what is uncertain, in the healthy conditions as well, whose lines then hold it small where
they show it.
"""

from __future__ import annotations

import numpy as np

from .baseline import Baseline, machine_at, widened_by
from .healthy_evidence import fitted
from .lines import OrderLines
from .predict import Predictor, UnpredictableError

#: Machines that are drawn.
DRAWS = 12
SEED = 1


def with_bends(at_healthy: Baseline, healthy: OrderLines, sets: list[tuple[Baseline, Predictor]]) -> list[Baseline]:
    """Return the machine in several sets of conditions, its bends among its unknowns; unchanged where none runs.

    Parameters
    ----------
    at_healthy : Baseline
        Calibrated, in the healthy conditions.
    healthy : OrderLines
    sets : list of (Baseline, Predictor)
        The same machine in each set of conditions.
    """
    own = len(at_healthy.coordinates)
    change, covariance = fitted(at_healthy, healthy)
    lower = np.linalg.cholesky(covariance[:own, :own])
    drawn = np.random.default_rng(SEED).standard_normal((DRAWS, own)) @ lower.T + change[:own]
    bends: list[list[np.ndarray]] = []
    for move in drawn:
        try:
            bends.append([_bend(current, move, predictor) for current, predictor in sets])
        except UnpredictableError:
            continue
    if not bends:
        return [current for current, _ in sets]
    share = 1 / np.sqrt(len(bends))
    return [widened_by(sets[i][0], share * np.stack([one[i] for one in bends])) for i in range(len(sets))]


def _bend(current: Baseline, move: np.ndarray, predictor: Predictor) -> np.ndarray:
    """Return by how much a move changes the lines otherwise than the slopes say."""
    moved = machine_at(current.machine, current.coordinates, current.position + move)
    straight = np.tensordot(move, current.slopes[: move.size], 1)
    return predictor.amplitudes(moved) - current.lines - straight
