"""A regressor with prediction intervals by conformal prediction, grouped by machine.

Every record is predicted by a model that has not seen its machine (folds by group). The errors, divided by a predicted
size of error so that intervals widen where features are weak, give one quantile q; the interval is

    g^-1( m(x) - q s(x) )  to  g^-1( m(x) + q s(x) ),     g(y) = arsinh(y / floor).

g is a logarithm far above the floor and straight below it, so that zero is an ordinary value: a severity too small to
see gives an interval that holds zero.

Records of one machine resemble each other; what is exchangeable is machines. Each machine therefore weighs the same,
and the machine to come weighs as one more with an infinite error (Y. Lee, R. F. Barber, R. Willett, Distribution-free
inference with hierarchical data, arXiv:2306.06342 (2023); R. Dunn, L. Wasserman, A. Ramdas, JASA 118 (2023) 2491). With
errors of machines held out entirely (`calibrate`) the coverage is at least as stated for machines of the same kind;
with errors from the folds it is so as far as the model of all machines errs no more than those of the folds, which is
tested, not proved (R. F. Barber et al., Ann. Stat. 49 (2021) 486).

Records without a fault are easy and many: an average over all records would let the intervals of faulty ones miss. With
strata (faulty or not) the quantile is the largest of theirs, so that the coverage holds in each.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin, clone
from sklearn.ensemble import HistGradientBoostingRegressor
from sklearn.utils.validation import check_is_fitted
from threadpoolctl import threadpool_limits

from ....simulators.errors import InvalidValueError
from ..sklearn_compat import validated

_LEAST_ERROR = 1e-3


class ConformalRegressor(RegressorMixin, BaseEstimator):
    """Regressor whose intervals hold the truth with a stated frequency over machines.

    Parameters
    ----------
    estimator : estimator or None
        Of the value; histogram gradient boosting when None.
    coverage : float
        Frequency with which an interval holds the truth, 0 to 1.
    floor : float or None
        Scale of g, in units of y: about the smallest severity that can be seen. None leaves y as it is.
    least : float or None
        Values below do not exist, such as 0; intervals end there.
    folds : int
    seed : int
        For the folds and the estimators.

    Attributes
    ----------
    quantile_ : float
        q; infinite with too few groups (1 / (1 - coverage) - 1 are needed).
    scores_, score_groups_, score_strata_ : ndarray (rows,)
        Errors over their predicted size, the group and the stratum of each, of the rows that calibrate.
    smallest_ : float or None
        Smallest y above ``least`` of the training. Nothing is known between the two: no interval begins or ends there.
    n_features_in_ : int

    Examples
    --------
    >>> x = np.linspace(0, 1, 400)[:, None]
    >>> noise = np.random.default_rng(0).normal(size=400)
    >>> model = ConformalRegressor(coverage=0.8).fit(x, x[:, 0] + 0.1 * noise, groups=np.arange(400) // 4)
    >>> low, high = model.predict_interval([[0.5]])[0]
    >>> bool(low < 0.5 < high), bool(high - low < 0.6)
    (True, True)
    """

    def __init__(
        self,
        estimator: Any = None,
        *,
        coverage: float = 0.9,
        floor: float | None = None,
        least: float | None = None,
        folds: int = 6,
        seed: int = 0,
    ) -> None:
        self.estimator = estimator
        self.coverage = coverage
        self.floor = floor
        self.least = least
        self.folds = folds
        self.seed = seed

    def fit(self, X: Any, y: Any, groups: Any = None, strata: Any = None) -> ConformalRegressor:
        """Fit, and calibrate on the errors of machines that each fold has not seen.

        Parameters
        ----------
        X : array (rows, features)
        y : array (rows,)
        groups : array (rows,), optional
            The machine of each row; every row is a machine of its own when left out.
        strata : array (rows,), optional
            Kinds of record; the coverage holds in each.

        Raises
        ------
        InvalidValueError
            For a coverage, floor or number of folds that is not allowed, or groups that do not fit.
        """
        self._check()
        X, y = validated(self, X, y, fitting=True)
        y = np.asarray(y, float)
        groups = np.arange(y.size) if groups is None else np.asarray(groups)
        if groups.shape != y.shape:
            raise InvalidValueError(f"{groups.size} groups for {y.size} rows; allowed: one a row. Correct them.")
        above = y[y > self.least] if self.least is not None else y[:0]
        self.smallest_ = float(above.min()) if above.size else None
        # Few rows: threads that wait for each other cost more than they bring.
        with threadpool_limits(limits=1):
            means, sizes = self._fit(X, self._transformed(y), self._folds(groups))
        self._set_scores(np.abs(self._transformed(y) - means) / sizes, groups, strata)
        return self

    def calibrate(self, X: Any, y: Any, groups: Any = None, strata: Any = None) -> ConformalRegressor:
        """Take the quantile from other machines than those of `fit`, for example of another kind; returns self.

        The value predicted stays; the intervals change. Parameters as in `fit`.
        """
        check_is_fitted(self)
        X = validated(self, X)
        y = np.asarray(y, float)
        groups = np.arange(y.size) if groups is None else np.asarray(groups)
        self._set_scores(np.abs(self._transformed(y) - self.mean_.predict(X)) / self._sizes(X), groups, strata)
        return self

    def predict(self, X: Any) -> np.ndarray:
        """Return the value for each row, shape (rows,)."""
        check_is_fitted(self)
        X = validated(self, X)
        return self._back(self.mean_.predict(X))

    def predict_interval(self, X: Any, *, coverage: float | None = None) -> np.ndarray:
        """Return lower and upper end for each row, shape (rows, 2); with another coverage than fitted, if given."""
        check_is_fitted(self)
        X = validated(self, X)
        q = self.quantile_ if coverage is None else self._quantile(coverage)
        middle, half = self.mean_.predict(X), self._sizes(X)
        half = np.where(np.isfinite(q), min(q, 1e300) * half, np.inf)
        ends = self._back(np.stack([middle - half, middle + half], axis=1))
        smallest = self.smallest_
        if smallest is None or self.least is None:
            return ends
        low, high = ends[:, 0], np.maximum(ends[:, 1], smallest)
        return np.stack([np.where(low < smallest, self.least, low), high], axis=1)

    def _fit(self, X: np.ndarray, target: np.ndarray, folds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Fit to all rows; return value and size of error of each row by models that have not seen its machine."""
        means, sizes = np.empty(target.size), np.empty(target.size)
        if folds.max() == 0:
            self._fit_whole(X, target, np.zeros(target.size))
            return self.mean_.predict(X), self._sizes(X)
        parts = [folds == number for number in range(folds.max() + 1)]
        for here in parts:
            means[here] = self._model().fit(X[~here], target[~here]).predict(X[here])
        errors = np.log(np.abs(target - means) + _LEAST_ERROR)
        for here in parts:
            sizes[here] = np.exp(self._size_model().fit(X[~here], errors[~here]).predict(X[here]))
        self._fit_whole(X, target, errors)
        return means, sizes

    def _set_scores(self, scores: np.ndarray, groups: np.ndarray, strata: Any) -> None:
        # Names would need a pickle in a model file; numbers say the same.
        self.scores_, self.score_groups_ = scores, np.unique(groups, return_inverse=True)[1].ravel()
        strata = np.zeros(scores.size) if strata is None else np.asarray(strata)
        self.score_strata_ = np.unique(strata, return_inverse=True)[1].ravel()
        self.quantile_ = self._quantile(self.coverage)

    def _quantile(self, coverage: float) -> float:
        parts = [self.score_strata_ == one for one in range(int(self.score_strata_.max()) + 1)]
        return max(group_quantile(self.scores_[part], self.score_groups_[part], coverage) for part in parts)

    def _check(self) -> None:
        if not 0 < self.coverage < 1:
            raise InvalidValueError(f"coverage = {self.coverage!r}; allowed: above 0, below 1. Correct it.")
        if self.floor is not None and not self.floor > 0:
            raise InvalidValueError(f"floor = {self.floor!r}; allowed: above 0, or None. Correct it.")
        if self.folds < 2:
            raise InvalidValueError(f"folds = {self.folds!r}; allowed: 2 or more. Correct it.")

    def _folds(self, groups: np.ndarray) -> np.ndarray:
        """Return the fold of each row; machines are dealt out in a random order."""
        names, place = np.unique(groups, return_inverse=True)
        order = np.random.default_rng(self.seed).permutation(names.size)
        return (order % min(self.folds, names.size))[place.ravel()]

    def _model(self) -> Any:
        if self.estimator is not None:
            return clone(self.estimator)
        return HistGradientBoostingRegressor(
            max_iter=300, learning_rate=0.06, max_leaf_nodes=15, random_state=self.seed
        )

    def _size_model(self) -> Any:
        """Few and large leaves: a size of error that follows single records would undo the calibration."""
        return HistGradientBoostingRegressor(
            max_iter=60, learning_rate=0.08, max_leaf_nodes=8, min_samples_leaf=40, random_state=self.seed
        )

    def _fit_whole(self, X: np.ndarray, target: np.ndarray, errors: np.ndarray) -> None:
        self.mean_ = self._model().fit(X, target)
        self.size_ = self._size_model().fit(X, errors)

    def _sizes(self, X: np.ndarray) -> np.ndarray:
        return np.exp(self.size_.predict(X))

    def _transformed(self, y: np.ndarray) -> np.ndarray:
        return y if self.floor is None else np.arcsinh(y / self.floor)

    def _back(self, target: np.ndarray) -> np.ndarray:
        # Beyond this, sinh leaves the number range.
        value = target if self.floor is None else self.floor * np.sinh(np.clip(target, -700.0, 700.0))
        if self.floor is not None:
            value = np.where(np.isinf(target), target, value)
        return value if self.least is None else np.maximum(value, self.least)


def group_quantile(scores: np.ndarray, groups: np.ndarray, coverage: float) -> float:
    """Return the smallest q with share ``coverage`` of the weight at or below it, infinite where there is none.

    Each of K groups weighs 1 / (K + 1), shared evenly by its scores; the rest of the weight is at infinity.

    Parameters
    ----------
    scores, groups : ndarray (rows,)
    coverage : float

    Examples
    --------
    >>> group_quantile(np.array([3.0, 1.0, 2.0, 4.0]), np.arange(4), 0.6)
    3.0
    >>> group_quantile(np.array([3.0, 1.0, 2.0, 4.0]), np.arange(4), 0.9)
    inf
    """
    if not 0 < coverage < 1:
        raise InvalidValueError(f"coverage = {coverage!r}; allowed: above 0, below 1. Correct it.")
    _, place, counts = np.unique(groups, return_inverse=True, return_counts=True)
    weights = 1.0 / (counts[place.ravel()] * (counts.size + 1.0))
    order = np.argsort(scores)
    # Sums of shares are exact to rounding only.
    reached = np.flatnonzero(np.cumsum(weights[order]) >= coverage - 1e-12)
    return float(scores[order][reached[0]]) if reached.size else float("inf")
