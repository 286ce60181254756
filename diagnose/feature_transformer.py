"""A scikit-learn transformer from recordings to feature vectors."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, TransformerMixin

from ..datasets.recording import Recording
from .features import FEATURES, feature_names, features
from .observe import observe


class RecordingFeatures(TransformerMixin, BaseEstimator):
    """Transformer from recordings to their feature vectors, shape (recordings, features).

    Parameters
    ----------
    missing : float
        What stands where a record cannot say; NaN by default. Estimators that refuse NaN, or a feature that is NaN in
        every record (no gear, no bearing known), need a number here.

    Examples
    --------
    >>> import numpy as np
    >>> from rotorwise.datasets.recording import Channel, Recording
    >>> noise = np.random.default_rng(0).normal(size=(1, 4096))
    >>> RecordingFeatures().fit_transform([Recording(noise, 1000.0, (Channel("x", "acceleration"),))]).shape[0]
    1
    """

    def __init__(self, missing: float = float("nan")):
        self.missing = missing

    def fit(self, recordings: Iterable[Recording], y: Any = None) -> RecordingFeatures:
        """Learn nothing; there for pipelines."""
        self.n_features_out_ = len(FEATURES)
        return self

    def transform(self, recordings: Iterable[Recording]) -> np.ndarray:
        """Return the feature vectors, shape (recordings, features)."""
        rows = [list(features(observe(recording)).values()) for recording in recordings]
        table = np.array(rows, dtype=float).reshape(len(rows), len(FEATURES))
        return np.where(np.isnan(table), self.missing, table)

    def get_feature_names_out(self, input_features: Any = None) -> np.ndarray:
        """Return the feature names."""
        return np.array(feature_names(), dtype=object)

    def __sklearn_is_fitted__(self) -> bool:
        return True
