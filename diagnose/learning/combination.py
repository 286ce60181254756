"""One probability from two: what the evidence rules state and what the classifier states of the same fault.

log-odds = constant + rules * log-odds of the rules + model * log-odds of the classifier, the weights from simulated
machines that the classifier was not fitted on. A weight below zero would mean that evidence speaks against itself: it
is set to zero and the other is fitted alone. What is stated is never above what the rules state: the model may doubt a
hint, but has seen too few machines to make an alarm of one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..evidence import LEAST_PROBABILITY

if TYPE_CHECKING:
    from .fault_classifier import FaultClassifier
    from .learning_set import LearningSet

#: Faults of which rules and model are combined, in recordings without a baseline. All else is left to the rules: they
#: judge the change against a baseline, and no rule was asked on simulated pairs, so that the weights do not know what
#: such an answer is worth. A damaged ball shares its rhythm with the cage, and the simulated cage defects show too
#: seldom to be taught.
COMBINED = ("bearing_outer_race", "bearing_inner_race")
#: A probability nearer to 0 or 1 says no more than this.
_NEAREST = 0.01


@dataclass(frozen=True)
class Weights:
    """Of the combination; see the module."""

    constant: float
    rules: float
    model: float

    def combined(self, rules: float | np.ndarray, model: float | np.ndarray) -> Any:
        """Return the probability from those of the rules and of the model."""
        odds = self.constant + self.rules * log_odds(rules) + self.model * log_odds(model)
        return 1 / (1 + np.exp(-odds))

    def doubted(self, rules: float | np.ndarray, model: float | np.ndarray) -> Any:
        """Return the combined probability where it is below that of the rules, else theirs."""
        return np.minimum(rules, self.combined(rules, model))

    def data(self) -> dict[str, float]:
        """Return the weights by name."""
        return asdict(self)


def log_odds(probability: float | np.ndarray) -> Any:
    """Return ln(p / (1 - p)), p kept between 0.01 and 0.99."""
    kept = np.clip(probability, _NEAREST, 1 - _NEAREST)
    return np.log(kept / (1 - kept))


def fit_weights(rules: np.ndarray, model: np.ndarray, present: np.ndarray) -> Weights:
    """Return the weights under which the combination is best calibrated (largest likelihood).

    Parameters
    ----------
    rules, model : array (n,)
        Probabilities of a fault, one for each recording and fault.
    present : array of bool (n,)
        Whether the fault was there and showed.
    """
    # Fitting needs scikit-learn, which takes two seconds to load; using the weights does not.
    from sklearn.linear_model import LogisticRegression

    columns = {"rules": log_odds(rules), "model": log_odds(model)}
    while True:
        found = LogisticRegression(C=1e6, max_iter=1000).fit(np.column_stack(list(columns.values())), present)
        sizes = dict(zip(columns, found.coef_[0].tolist(), strict=True))
        negative = [name for name, size in sizes.items() if size < 0]
        if not negative or len(columns) == 1:
            weights = {"rules": 0.0, "model": 0.0} | {name: max(size, 0.0) for name, size in sizes.items()}
            return Weights(float(found.intercept_[0]), **weights)
        del columns[min(negative, key=lambda name: sizes[name])]


def race_weights(rules: Mapping[str, np.ndarray], rows: LearningSet, classifier: FaultClassifier) -> Weights | None:
    """Return the weights for the faults of `COMBINED`, from predictions for machines that were not fitted.

    Parameters
    ----------
    rules : mapping of str to array (rows,)
        What the rules state without a baseline, by fault, for each of the rows.
    rows : LearningSet
        Recordings alone.
    classifier : FaultClassifier
        Copies of it are fitted.

    Returns
    -------
    Weights or None
        None where the rules found none of the faults, or were always right.
    """
    from .fault_classifier import out_of_group

    classes = [str(one) for one in np.unique(rows.labels)]
    faults = [fault for fault in COMBINED if fault in classes and fault in rules]
    if not faults or len(classes) < 2:
        return None
    probability, _ = out_of_group(classifier, rows.values, rows.labels, rows.groups, folds=4)
    model = probability[:, [classes.index(fault) for fault in faults]]
    present = (rows.labels[:, None] == np.array(faults)).ravel()
    stated = np.column_stack([rules[fault] for fault in faults]).ravel()
    # Fitted on what they are used on: the model changes what the rules found, and adds nothing.
    found = stated >= LEAST_PROBABILITY
    if np.unique(present[found]).size < 2:
        return None
    return fit_weights(stated[found], model.ravel()[found], present[found])
