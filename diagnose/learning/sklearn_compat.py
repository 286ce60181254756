"""The check of inputs under the name that each version of scikit-learn has for it."""

from __future__ import annotations

from typing import Any


def validated(estimator: Any, X: Any, y: Any = None, *, fitting: bool = False) -> Any:
    """Return checked features, when fitting features and targets; NaN is allowed.

    Sets ``n_features_in_`` and ``feature_names_in_`` when fitting, compares with them otherwise.
    """
    try:
        from sklearn.utils.validation import validate_data
    except ImportError:  # before 1.6
        options = {"force_all_finite": "allow-nan", "dtype": float}
        check = estimator._validate_data
        return check(X, y, reset=True, **options) if fitting else check(X, reset=False, **options)
    options = {"ensure_all_finite": "allow-nan", "dtype": float}
    if fitting:
        return validate_data(estimator, X, y, reset=True, **options)
    return validate_data(estimator, X, reset=False, **options)
