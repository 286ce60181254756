"""From a table of features to a model with its card: which machines it learned from, which it was judged on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...simulators.errors import InvalidValueError
from .changes import learning_rows, model_feature_names
from .evaluation import Judged, judged, scores
from .fault_classifier import FaultClassifier
from .fault_names import HEALTHY
from .feature_table import FeatureTable
from .model_file import Model, model_versions
from .not_evident import FALSE_EVIDENCE, evident

#: p-value below which a recording is unlike the training: one in fifty of machines like those of the training.
UNKNOWN_BELOW = 0.02
_MILDEST = 1 / 3


@dataclass(frozen=True, eq=False)
class LearningSet:
    """Rows as a classifier takes them: each recording alone, and once more against a healthy one of its machine.

    Attributes
    ----------
    values : array (rows, features)
    labels : array (rows,)
        What is taught: "healthy" where the fault does not show.
    truth : array (rows,)
        What was simulated; "not evident" where it does not show.
    with_baseline : array (rows,)
    columns : dict of array (rows,)
        Labels of the table.
    """

    values: np.ndarray
    labels: np.ndarray
    truth: np.ndarray
    with_baseline: np.ndarray
    columns: Mapping[str, np.ndarray]

    def where(self, mask: np.ndarray) -> LearningSet:
        """Return the rows that a mask chooses."""
        columns = {name: column[mask] for name, column in self.columns.items()}
        return LearningSet(self.values[mask], self.labels[mask], self.truth[mask], self.with_baseline[mask], columns)


def learning_set(table: FeatureTable, *, seed: int) -> LearningSet:
    """Return what a classifier learns from, and what it is judged on."""
    values, index = learning_rows(table, seed=seed)
    shown = evident(table)
    labels = np.where(shown, table.labels, HEALTHY)[index]
    truth = np.where(shown, table.labels, "not evident")[index]
    alone = np.arange(len(index)) < len(table)
    return LearningSet(values, labels, truth, ~alone, {name: column[index] for name, column in table.columns.items()})


def train(
    table: FeatureTable, *, origin: Mapping[str, Any], model: str = "boosting", seed: int = 0, iterations: int = 60
) -> Model:
    """Fit a classifier on the split "train" of a dataset and judge it on the machines of all other splits.

    Machines of the other splits are never fitted. On them it is judged three times: as it is; fitted without the
    mildest third of each fault and judged on that third; fitted without the faster half of the records and judged on
    that half. The last two say how it carries over to other severities and conditions; only the first is kept.

    Parameters
    ----------
    table : FeatureTable
        Relative features and levels.
    origin : mapping
        JSON types: dataset, recipe, seed, limits; goes on the card.
    model : str
        ``"boosting"`` or ``"linear"``.
    seed, iterations : int
        Of the classifier.

    Raises
    ------
    InvalidValueError
        When the table has no two faults, or no row in the split "train".
    """
    rows = learning_set(table, seed=seed)
    fitted = rows.columns["split"] == "train"
    if np.unique(rows.labels[fitted]).size < 2:
        raise InvalidValueError(
            f"Split train of the dataset shows {', '.join(np.unique(rows.labels[fitted])) or 'nothing'}; allowed: two "
            "faults or more, healthy among them or not. Build more of it."
        )
    classifier = _fitted(rows.where(fitted), model, seed, iterations)
    judgements = {"machine": _judgement(classifier, rows.where(~fitted))}
    for name, held in (("severity", _mild(rows)), ("condition", _fast(rows))):
        part = rows.where(fitted & ~held)
        usable = np.unique(part.labels).size > 1 and (~fitted & held).any()
        judgements[name] = (
            _judgement(_fitted(part, model, seed, iterations), rows.where(~fitted & held)) if usable else None
        )
    return Model(classifier, model_feature_names(), _card(rows, fitted, classifier, origin, judgements))


def _fitted(rows: LearningSet, model: str, seed: int, iterations: int) -> FaultClassifier:
    made = FaultClassifier(model=model, iterations=iterations, random_state=seed)
    return made.fit(rows.values, rows.labels, groups=_groups(rows))


def _groups(rows: LearningSet) -> np.ndarray:
    return np.char.add(np.char.add(rows.columns["machine"].astype(str), "/"), rows.columns["group"].astype(str))


def _mild(rows: LearningSet) -> np.ndarray:
    """Return which rows are of the mildest third of their fault, by the one severity that the fault has."""
    mild = np.zeros(len(rows.labels), bool)
    fault = np.char.add(rows.columns["case"].astype(str), rows.columns["machine"].astype(str))
    for name, values in rows.columns.items():
        if not name.startswith("severity.") or values.dtype.kind != "f":
            continue
        for one in np.unique(fault):
            inside = (fault == one) & (values > 0)
            if inside.any():
                mild |= inside & (values <= np.quantile(values[inside], _MILDEST))
    return mild


def _fast(rows: LearningSet) -> np.ndarray:
    return rows.columns["speed_rpm"] > np.median(rows.columns["speed_rpm"])


def _judgement(classifier: FaultClassifier, rows: LearningSet) -> dict[str, Any] | None:
    if not len(rows.labels):
        return None
    found: Judged = judged(classifier, rows.values, rows.truth)
    return scores(found)


def _card(
    rows: LearningSet,
    fitted: np.ndarray,
    classifier: FaultClassifier,
    origin: Mapping[str, Any],
    judgements: Mapping[str, Any],
) -> dict[str, Any]:
    groups = _groups(rows)
    taught = {str(one): int((rows.labels[fitted] == one).sum()) for one in classifier.classes_}
    return {
        "origin": dict(origin),
        "model": classifier.model,
        "seed": classifier.random_state,
        "iterations": classifier.iterations,
        "calibrated": classifier.calibrated_,
        "unknown_below": UNKNOWN_BELOW,
        "rows_taught": taught,
        "not_evident": int((rows.truth[fitted] == "not evident").sum()),
        "not_evident_rule": (
            "A fault is taught as healthy where none of its own features lies further above the healthy records of the "
            f"same machine, speed and load than {1 - FALSE_EVIDENCE:.0%} of healthy records do."
        ),
        "machines_fitted": sorted(set(groups[fitted].tolist())),
        "machines_held_out": sorted(set(groups[~fitted].tolist())),
        "judged_on_held_out_machines": dict(judgements),
        "versions": model_versions(),
    }


__all__ = ["UNKNOWN_BELOW", "LearningSet", "learning_set", "train"]
