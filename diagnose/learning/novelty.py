"""How far from its training a feature vector lies, as a p-value: the open-set rule of the classifiers.

The distance is the mean over the nearest neighbours in robustly scaled features; its distribution comes from training
rows against the rows of other groups, so that a machine is judged as a new one (conformal p-value: V. Vovk et al.,
Algorithmic Learning in a Random World, Springer 2005, chapter 4).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from sklearn.base import BaseEstimator

from .nearest import distances, scaled, share_as_far


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
        self.rows_ = scaled(X, self.centre_, self.spread_)
        self.groups_ = np.arange(len(X)) if groups is None else np.unique(groups, return_inverse=True)[1].reshape(-1)
        own = distances(self.rows_, self.rows_, groups=self.groups_, training_groups=self.groups_)
        self.distances_ = np.sort(own)
        return self

    def p_value(self, X: np.ndarray) -> np.ndarray:
        """Return (1 + number of training distances as large) / (1 + number), shape (rows,)."""
        own = distances(scaled(X, self.centre_, self.spread_), self.rows_)
        return share_as_far(own, self.distances_)
