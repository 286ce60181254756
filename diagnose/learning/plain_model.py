"""The linear, calibrated classifier from its arrays alone: the same answers without scikit-learn.

Loading scikit-learn takes longer than all the rest of an analysis, and the default model is a handful of products.
What is kept is the digest of an archive of arrays (`numpy.savez`), then the archive, which holds no objects and runs
nothing when it is read.
"""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...simulators.errors import InvalidValueError
from .model_file import Model, ModelFileError
from .nearest import distances, scaled, share_as_far

_ARRAYS = (
    "classes_",
    "usable",
    "median",
    "mean",
    "scale",
    "weights",
    "constant",
    "slope",
    "offset",
    "centre",
    "spread",
    "rows",
    "known",
)


@dataclass(frozen=True, eq=False)
class PlainClassifier:
    """What a fitted linear `FaultClassifier` knows.

    Attributes
    ----------
    classes_ : numpy.ndarray of str, shape (classes,)
    usable : numpy.ndarray of bool, shape (features,)
        Features that the probabilities come from.
    median, mean, scale : numpy.ndarray, shape (usable features,)
        What replaces NaN, and the standardisation.
    weights, constant : numpy.ndarray, shape (usable features, classes), (classes,)
        Of the logistic regression.
    slope, offset : numpy.ndarray, shape (classes,)
        Of the calibration: 1 / (1 + exp(slope decision + offset)), then the sum is made one.
    centre, spread, rows, known : numpy.ndarray
        Of the novelty: ``centre_``, ``spread_``, ``rows_`` and ``distances_`` there.
    """

    classes_: np.ndarray
    usable: np.ndarray
    median: np.ndarray
    mean: np.ndarray
    scale: np.ndarray
    weights: np.ndarray
    constant: np.ndarray
    slope: np.ndarray
    offset: np.ndarray
    centre: np.ndarray
    spread: np.ndarray
    rows: np.ndarray
    known: np.ndarray

    def predict_proba(self, X: np.ndarray) -> np.ndarray:
        """Return the probabilities of the classes, shape (rows, classes)."""
        used = np.asarray(X, dtype=float)[:, self.usable]
        standard = (np.where(np.isnan(used), self.median, used) - self.mean) / self.scale
        decision = standard @ self.weights + self.constant
        # exp of more than 700 is no number any more; the probability is zero long before.
        each = 1.0 / (1.0 + np.exp(np.minimum(self.slope * decision + self.offset, 700.0)))
        total = each.sum(axis=1, keepdims=True)
        return each / total

    def novelty_p_value(self, X: np.ndarray) -> np.ndarray:
        """Return the share of training rows that lie as far from the training of other groups, shape (rows,)."""
        own = distances(scaled(np.asarray(X, dtype=float), self.centre, self.spread), self.rows)
        return share_as_far(own, self.known)


def plain(classifier: Any) -> PlainClassifier:
    """Return the arrays of a fitted `FaultClassifier`.

    Raises
    ------
    InvalidValueError
        When it is not linear, not calibrated, or has two classes, which scikit-learn treats in a way of their own.
    """
    if classifier.model != "linear" or not classifier.calibrated_ or len(classifier.classes_) < 3:
        raise InvalidValueError(
            f"Model {classifier.model!r}, calibrated: {classifier.calibrated_}, {len(classifier.classes_)} classes; "
            "allowed: linear, calibrated, three classes or more. Ask the classifier itself."
        )
    fitted = classifier.estimator_.calibrated_classifiers_[0]
    imputer, scaler, regression = (step for _, step in fitted.estimator.steps)
    novelty = classifier.novelty_
    return PlainClassifier(
        classes_=np.asarray(classifier.classes_, dtype=str),
        usable=classifier.usable_,
        median=imputer.statistics_,
        mean=scaler.mean_,
        scale=scaler.scale_,
        weights=regression.coef_.T,
        constant=regression.intercept_,
        slope=np.array([one.a_ for one in fitted.calibrators]),
        offset=np.array([one.b_ for one in fitted.calibrators]),
        centre=novelty.centre_,
        spread=novelty.spread_,
        rows=novelty.rows_,
        known=novelty.distances_,
    )


def plain_bytes(model: Model) -> bytes:
    """Return a model with a `PlainClassifier` as the bytes of its file."""
    sink = io.BytesIO()
    said = json.dumps({"features": model.features, "card": model.card})
    np.savez(sink, said=np.array(said), **{name: getattr(model.classifier, name) for name in _ARRAYS})
    content = sink.getvalue()
    return hashlib.sha256(content).digest() + content


def plain_from_bytes(content: bytes) -> Model:
    """Return the model in the bytes of a file; raises ModelFileError when it is damaged."""
    digest, archive = content[:32], content[32:]
    # Looked at first: a damaged archive makes zipfile, zlib and numpy raise whatever they like.
    if hashlib.sha256(archive).digest() != digest:
        raise ModelFileError("The model's arrays are damaged. Delete the file; it is made again.")
    with np.load(io.BytesIO(archive), allow_pickle=False) as found:
        said = json.loads(str(found["said"]))
        classifier = PlainClassifier(**{name: found[name] for name in _ARRAYS})
    return Model(classifier, tuple(said["features"]), said["card"])
