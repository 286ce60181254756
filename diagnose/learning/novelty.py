"""How far from its training a feature vector lies, as a p-value: the open-set rule of the classifiers.

The distance is the mean over the nearest neighbours in robustly scaled features; its distribution comes from training
rows against the rows of other groups, so that a machine is judged as a new one (conformal p-value: V. Vovk et al.,
Algorithmic Learning in a Random World, Springer 2005, chapter 4).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from sklearn.base import BaseEstimator

_NEIGHBOURS = 5
#: A feature counts at most so many of its own spreads: one absurd value makes a vector far, not infinitely far.
_FARTHEST = 8.0
_ROWS_AT_ONCE = 256


class Novelty(BaseEstimator):
    """Distance to the training and its p-value.

    Attributes
    ----------
    centre_, spread_ : numpy.ndarray, shape (features,)
        Median, and half the range from 5 to 95 % (or 1 where that is nothing); NaN in training becomes the median.
    rows_ : numpy.ndarray, shape (rows, features)
        Scaled training rows.
    distances_ : numpy.ndarray, shape (rows,)
        Sorted distances of training rows to other groups.
    """

    def fit(self, X: np.ndarray, y: Any = None, *, groups: np.ndarray | None = None) -> Novelty:
        """Learn centre, spread and the distribution of distances.

        Parameters
        ----------
        X : array (rows, features)
        y : ignored
        groups : array (rows,), optional
        """
        import warnings

        with warnings.catch_warnings():
            # A feature that no training row has says nothing; that is no mishap.
            warnings.simplefilter("ignore", RuntimeWarning)
            centre = np.nanmedian(X, axis=0)
            low, high = np.nanpercentile(X, [5, 95], axis=0)
        self.centre_ = np.where(np.isfinite(centre), centre, 0.0)
        spread = np.where(np.isfinite(high - low), (high - low) / 2, 0.0)
        widest = np.nanmax(np.abs(np.where(np.isnan(X), self.centre_, X) - self.centre_), axis=0)
        self.spread_ = np.where(spread > 0, spread, np.where(widest > 0, widest, 1.0))
        self.rows_ = self._scaled(X)
        self.groups_ = np.arange(len(X)) if groups is None else np.unique(groups, return_inverse=True)[1].reshape(-1)
        self.distances_ = np.sort(self._distances(self.rows_, self.groups_))
        return self

    def p_value(self, X: np.ndarray) -> np.ndarray:
        """Return (1 + number of training distances as large) / (1 + number), shape (rows,)."""
        own = self._distances(self._scaled(X), None)
        beyond = self.distances_.size - np.searchsorted(self.distances_, own, side="left")
        return (1.0 + beyond) / (1.0 + self.distances_.size)

    def _scaled(self, X: np.ndarray) -> np.ndarray:
        filled = np.where(np.isnan(X), self.centre_, X)
        return np.clip((filled - self.centre_) / self.spread_, -_FARTHEST, _FARTHEST)

    def _distances(self, rows: np.ndarray, groups: np.ndarray | None) -> np.ndarray:
        """Return the mean distance to the nearest neighbours; with groups, to those of other groups."""
        found = np.empty(len(rows))
        squares = (self.rows_**2).sum(axis=1)
        for start in range(0, len(rows), _ROWS_AT_ONCE):
            part = rows[start : start + _ROWS_AT_ONCE]
            distance = (part**2).sum(axis=1)[:, None] + squares - 2 * part @ self.rows_.T
            if groups is not None:
                same = groups[start : start + _ROWS_AT_ONCE, None] == self.groups_
                # A single group has no others; its rows are then compared with each other.
                distance = np.where(same & ~same.all(axis=1)[:, None], np.inf, distance)
            count = min(_NEIGHBOURS, distance.shape[1])
            nearest = np.partition(distance, count - 1, axis=1)[:, :count]
            nearest = np.where(np.isfinite(nearest), np.sqrt(np.maximum(nearest, 0.0)), np.nan)
            found[start : start + _ROWS_AT_ONCE] = np.nanmean(nearest, axis=1)
        return found
