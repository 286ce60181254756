"""Distances to training rows, with numpy alone: see `novelty`."""

from __future__ import annotations

import numpy as np

_NEIGHBOURS = 5
#: A feature counts at most so many of its own spreads: one absurd value makes a vector far, not infinitely far.
_FARTHEST = 8.0
_ROWS_AT_ONCE = 256


def scaled(X: np.ndarray, centre: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Return features in spreads from the centre, shape (rows, features); NaN becomes the centre."""
    filled = np.where(np.isnan(X), centre, X)
    return np.clip((filled - centre) / spread, -_FARTHEST, _FARTHEST)


def distances(
    rows: np.ndarray,
    training: np.ndarray,
    *,
    groups: np.ndarray | None = None,
    training_groups: np.ndarray | None = None,
) -> np.ndarray:
    """Return the mean distance of each row to its nearest training rows; with groups, to those of other groups.

    Parameters
    ----------
    rows, training : array (rows, features), (training rows, features)
        Scaled.
    groups, training_groups : array of int, optional
        Of the rows and of the training rows.
    """
    found = np.empty(len(rows))
    squares = (training**2).sum(axis=1)
    for start in range(0, len(rows), _ROWS_AT_ONCE):
        part = rows[start : start + _ROWS_AT_ONCE]
        distance = (part**2).sum(axis=1)[:, None] + squares - 2 * part @ training.T
        if groups is not None:
            same = groups[start : start + _ROWS_AT_ONCE, None] == training_groups
            # A single group has no others; its rows are then compared with each other.
            distance = np.where(same & ~same.all(axis=1)[:, None], np.inf, distance)
        count = min(_NEIGHBOURS, distance.shape[1])
        nearest = np.partition(distance, count - 1, axis=1)[:, :count]
        nearest = np.where(np.isfinite(nearest), np.sqrt(np.maximum(nearest, 0.0)), np.nan)
        found[start : start + _ROWS_AT_ONCE] = np.nanmean(nearest, axis=1)
    return found


def share_as_far(own: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Return (1 + number of known distances as large) / (1 + number), shape of ``own``; ``known`` is sorted."""
    beyond = known.size - np.searchsorted(known, own, side="left")
    return (1.0 + beyond) / (1.0 + known.size)
