"""A classifier of faults: gradient boosting or a linear baseline, calibrated by groups, with an answer "unknown"."""

from __future__ import annotations

from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, ClassifierMixin, clone
from sklearn.calibration import CalibratedClassifierCV
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.impute import SimpleImputer
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import StratifiedGroupKFold, StratifiedKFold
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted
from threadpoolctl import threadpool_limits

from ...simulators.errors import InvalidValueError
from .novelty import Novelty
from .sklearn_compat import validated

MODELS = ("boosting", "linear")


class FaultClassifier(ClassifierMixin, BaseEstimator):
    """Classifier of feature vectors with calibrated probabilities and a p-value of "like the training".

    Probabilities are calibrated on predictions for groups that the model was not fitted on (Platt scaling, one class
    against the rest: J. Platt, Advances in Large Margin Classifiers, 1999, 61-74); the model is then fitted on all.

    Parameters
    ----------
    model : str
        ``"boosting"``: histogram gradient boosting, takes NaN. ``"linear"``: logistic regression on standardised
        features, NaN replaced by the median and marked.
    iterations : int
        Trees a class.
    folds : int
        Of the calibration; fewer where a class has fewer rows or groups.
    random_state : int

    Attributes
    ----------
    classes_ : numpy.ndarray
    novelty_ : Novelty
        How far from the training features a vector is; see `novelty_p_value`.
    calibrated_ : bool
        False when the training was too small for it.

    Examples
    --------
    >>> features = np.r_[np.random.default_rng(0).normal(size=(40, 2)), np.random.default_rng(1).normal(5, 1, (40, 2))]
    >>> model = FaultClassifier(model="linear").fit(features, ["healthy"] * 40 + ["rub"] * 40)
    >>> str(model.predict([[5.0, 5.0]])[0])
    'rub'
    """

    def __init__(self, model: str = "boosting", iterations: int = 60, folds: int = 5, random_state: int = 0):
        self.model = model
        self.iterations = iterations
        self.folds = folds
        self.random_state = random_state

    def fit(self, X: Any, y: Any, groups: Any = None) -> FaultClassifier:
        """Fit the model.

        Parameters
        ----------
        X : array (rows, features)
            NaN where a recording cannot say.
        y : array (rows,)
            Classes.
        groups : array (rows,), optional
            Machine draws. Rows of one group are never on both sides of a fold. Every row by itself when left out.
        """
        if self.model not in MODELS:
            raise InvalidValueError(f"model = {self.model!r}; allowed: {', '.join(MODELS)}. Correct it.")
        X, y = validated(self, X, y, fitting=True)
        check_classification_targets(y)
        self.classes_, counts = np.unique(y, return_counts=True)
        if self.classes_.size < 2:
            # The words are what scikit-learn's own check looks for.
            raise InvalidValueError(f"Classifier can't train when only one class is present: {self.classes_[0]!r}.")
        groups = None if groups is None else np.asarray(groups)
        splits = _splits(X, y, counts, groups, folds=self.folds, seed=self.random_state)
        self.calibrated_ = bool(splits)
        # A feature that some fold has nowhere says nothing there, and trees cannot take it.
        parts = [fit for fit, _ in splits] or [np.arange(len(X))]
        self.usable_ = np.all([~np.isnan(X[part]).all(axis=0) for part in parts], axis=0)
        self.estimator_: Any = self._base()
        if splits:
            whole: Any = False  # one model fitted on all, not one a fold; older annotations know texts only
            self.estimator_ = CalibratedClassifierCV(self._base(), method="sigmoid", cv=splits, ensemble=whole)
        # These tables are small: threads that wait for each other on a busy computer cost more than they bring.
        with threadpool_limits(1):
            self.estimator_.fit(self._used(X), y)
        if splits:
            self.estimator_.cv = None  # the folds' row numbers have done their work
        self.novelty_ = Novelty().fit(X, groups=groups)
        return self

    def predict_proba(self, X: Any) -> np.ndarray:
        """Return the probabilities of the classes, shape (rows, classes)."""
        check_is_fitted(self)
        with threadpool_limits(1):
            return self.estimator_.predict_proba(self._used(validated(self, X)))

    def predict(self, X: Any) -> np.ndarray:
        """Return the likeliest class of each row; look at `novelty_p_value` too before you believe it."""
        check_is_fitted(self)
        return self.classes_[np.argmax(self.predict_proba(X), axis=1)]

    def novelty_p_value(self, X: Any) -> np.ndarray:
        """Return the share of training rows that lie as far from the training of other groups, shape (rows,).

        A recording of a machine like those of the training has a p-value spread evenly from 0 to 1.
        """
        check_is_fitted(self)
        return self.novelty_.p_value(validated(self, X))

    def _used(self, X: np.ndarray) -> np.ndarray:
        return X[:, self.usable_] if self.usable_.any() else np.zeros((len(X), 1))

    def _base(self) -> Any:
        if self.model == "linear":
            steps = (SimpleImputer(strategy="median", keep_empty_features=True), StandardScaler())
            return make_pipeline(*steps, LogisticRegression(max_iter=2000, C=0.1))
        never: Any = False
        return HistGradientBoostingClassifier(
            max_iter=self.iterations,
            learning_rate=0.1,
            max_leaf_nodes=12,
            min_samples_leaf=10,
            l2_regularization=1.0,
            early_stopping=never,
            random_state=self.random_state,
        )

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()  # type: ignore[misc]
        tags.input_tags.allow_nan = True
        return tags

    def _more_tags(self) -> dict[str, bool]:
        return {"allow_nan": True}


def _splits(
    X: np.ndarray, y: np.ndarray, counts: np.ndarray, groups: np.ndarray | None, *, folds: int, seed: int
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the folds of the calibration; none where some class would be missing from a fold's training."""
    if groups is None:
        count = min(folds, int(counts.min()))
        maker: Any = StratifiedKFold(count, shuffle=True, random_state=seed) if count >= 2 else None
    else:
        count = min([folds, *(np.unique(groups[y == one]).size for one in np.unique(y))])
        maker = StratifiedGroupKFold(count, shuffle=True, random_state=seed) if count >= 2 else None
    if maker is None:
        return []
    found = [(fit, held) for fit, held in maker.split(X, y, groups)]
    whole = all(np.unique(y[fit]).size == np.unique(y).size for fit, _ in found)
    return found if whole else []


def out_of_group(
    model: FaultClassifier, X: np.ndarray, y: np.ndarray, groups: np.ndarray, *, folds: int = 5
) -> tuple[np.ndarray, np.ndarray]:
    """Return probabilities and novelty p-values of every row from models that did not see its group.

    Parameters
    ----------
    model : FaultClassifier
        Not fitted, or a fitted one of which copies are fitted.
    X, y, groups : arrays (rows, features), (rows,), (rows,)

    Returns
    -------
    probability : array (rows, classes), the classes sorted
    p_value : array (rows,)
    """
    classes, counts = np.unique(y, return_counts=True)
    splits = _splits(X, y, counts, groups, folds=folds, seed=model.random_state + 1)
    if not splits:
        raise InvalidValueError(
            "Some fault is there in one machine draw only; allowed: two or more draws of each. Use a larger dataset."
        )
    probability, p_value = np.zeros((len(y), classes.size)), np.zeros(len(y))
    for fit, held in splits:
        one: Any = clone(model)
        one.fit(X[fit], y[fit], groups=groups[fit])
        probability[held], p_value[held] = one.predict_proba(X[held]), one.novelty_p_value(X[held])
    return probability, p_value
