"""The classifier: scikit-learn's contract, calibration on data of known probability, the open-set rule."""

from __future__ import annotations

import numpy as np
import pytest
import sklearn
from rotorwise.diagnose.learning.fault_classifier import FaultClassifier, out_of_group
from rotorwise.diagnose.learning.novelty import Novelty
from rotorwise.simulators.errors import InvalidValueError
from sklearn.utils.estimator_checks import check_estimator

#: Older checks have too few rows for the leaves of boosted trees; scikit-learn's own are given smaller leaves there.
OLD = tuple(int(part) for part in sklearn.__version__.split(".")[:2]) < (1, 6)
TREES = pytest.mark.skipif(OLD, reason="the checks of scikit-learn below 1.6 have too few rows for a leaf of 20")


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "estimator",
    [
        pytest.param(FaultClassifier(model="linear", iterations=2, folds=2), id="linear"),
        pytest.param(FaultClassifier(iterations=2, folds=2), id="boosting", marks=TREES),
    ],
)
def test_keeps_the_contract_of_scikit_learn(estimator) -> None:
    check_estimator(estimator)


def _overlapping(rows: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two normal classes a distance 2 apart: p(b | x) = 1 / (1 + exp(2 - 2 x)) on the first feature."""
    stream = np.random.default_rng(seed)
    labels = stream.integers(0, 2, rows)
    values = stream.normal(0.0, 1.0, (rows, 3))
    values[:, 0] += 2.0 * labels
    return values, np.where(labels == 1, "b", "a"), np.arange(rows) // 10


@pytest.mark.parametrize("model", ["linear", "boosting"])
def test_stated_probabilities_come_true(model: str) -> None:
    training, checking = 2000, 4000
    values, labels, groups = _overlapping(training, 1)
    fitted = FaultClassifier(model=model, iterations=30).fit(values, labels, groups=groups)
    unseen, truth, _ = _overlapping(checking, 2)
    stated = fitted.predict_proba(unseen)[:, 1]
    for low in np.arange(0.0, 1.0, 0.2):
        inside = (stated >= low) & (stated < low + 0.2)
        share, mean = np.mean(truth[inside] == "b"), stated[inside].mean()
        # Both the share and what was learned scatter as counts do; four standard deviations of both.
        counted = inside.sum() / (1 + checking / training)
        assert abs(share - mean) < 4 * np.sqrt(mean * (1 - mean) / counted), (low, share, mean)
    if model == "linear":  # which is the right model here: p(b | x) is a sigmoid of x
        bayes = 1 / (1 + np.exp(2 - 2 * unseen[:, 0]))
        assert np.mean((stated - bayes) ** 2) < 0.003


def test_p_values_are_even_for_the_same_and_small_for_other_machines() -> None:
    values, _, groups = _overlapping(1500, 3)
    novelty = Novelty().fit(values, groups=groups)
    same = novelty.p_value(_overlapping(3000, 4)[0])
    # Kolmogorov-Smirnov at 1e-4 for 1500 and 3000 rows.
    distance = np.max(abs(np.sort(same) - np.arange(1, same.size + 1) / same.size))
    assert distance < 2.2 * np.sqrt(1 / 1500 + 1 / 3000)
    assert np.all(novelty.p_value(values[:50] + 30.0) < 0.001)


def test_a_missing_feature_is_no_novelty_and_no_crash() -> None:
    values, labels, groups = _overlapping(400, 5)
    values[::3, 1] = np.nan
    values[:, 2] = np.nan
    for model in ("linear", "boosting"):
        fitted = FaultClassifier(model=model, iterations=10).fit(values, labels, groups=groups)
        assert np.isfinite(fitted.predict_proba(values[:20])).all()
        assert fitted.novelty_p_value(np.full((1, 3), np.nan))[0] > 0.05


def test_out_of_group_never_sees_its_own_group() -> None:
    # Labels are a coin for each group, and a feature is the group's number: only leakage can tell.
    stream = np.random.default_rng(6)
    groups = np.repeat(np.arange(80), 10)
    labels = np.where(stream.integers(0, 2, 80)[groups] == 1, "b", "a")
    values = np.c_[stream.permutation(80)[groups].astype(float), stream.normal(size=800)]
    probability, _ = out_of_group(FaultClassifier(iterations=20), values, labels, groups)
    right = np.mean((probability[:, 1] > 0.5) == (labels == "b"))
    assert right < 0.5 + 4 * 0.5 / np.sqrt(80)
    fitted = FaultClassifier(iterations=20).fit(values, labels, groups=groups)
    assert np.mean(fitted.estimator_.calibrated_classifiers_[0].estimator.predict(values) == labels) > 0.9


def test_one_class_and_a_wrong_model_are_refused() -> None:
    values, labels, _ = _overlapping(40, 7)
    with pytest.raises(ValueError, match="only one class"):
        FaultClassifier(iterations=2).fit(values, ["a"] * 40)
    with pytest.raises(InvalidValueError, match="boosting, linear"):
        FaultClassifier(model="forest").fit(values, labels)
    with pytest.raises(InvalidValueError, match="two or more draws"):
        out_of_group(FaultClassifier(iterations=2), values, labels, np.where(labels == "a", 1, 2))
