"""How good a classifier's answers are: confusion matrix, recall, calibration curve, coverage of "unknown"."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from .fault_classifier import FaultClassifier
from .fault_names import HEALTHY

UNKNOWN, NOT_EVIDENT = "unknown", "not evident"
_BINS = 5


@dataclass(frozen=True, eq=False)
class Judged:
    """Answers beside the truth.

    Attributes
    ----------
    truth, answer : array of str (rows,)
        Truth as simulated or labelled, "not evident" for a fault that does not show. Answers: the likeliest class,
        whatever the p-value.
    probability : array (rows,)
        Stated for the answer.
    p_value : array (rows,)
        Of being like the training.
    unknown_below : float
        p-value under which the answer is "unknown".
    """

    truth: np.ndarray
    answer: np.ndarray
    probability: np.ndarray
    p_value: np.ndarray
    unknown_below: float

    @property
    def right(self) -> np.ndarray:
        """Whether each answer is right; "healthy" is right for a fault that does not show."""
        return self.answer == np.where(self.truth == NOT_EVIDENT, HEALTHY, self.truth)

    @property
    def known(self) -> np.ndarray:
        """Whether each row is like the training."""
        return self.p_value >= self.unknown_below

    def where(self, mask: np.ndarray) -> Judged:
        """Return the rows that a mask chooses."""
        return Judged(
            self.truth[mask], self.answer[mask], self.probability[mask], self.p_value[mask], self.unknown_below
        )


def judged(
    classifier: FaultClassifier, values: np.ndarray, truth: np.ndarray, *, unknown_below: float = 0.02
) -> Judged:
    """Return a classifier's answers beside the truth."""
    probability = classifier.predict_proba(values)
    best = np.argmax(probability, axis=1)
    return Judged(
        np.asarray(truth).astype(str),
        classifier.classes_[best].astype(str),
        probability[np.arange(len(best)), best],
        classifier.novelty_p_value(values),
        unknown_below,
    )


def scores(found: Judged) -> dict[str, Any]:
    """Return all numbers of an evaluation as JSON types.

    ``confusion``: truth -> answer -> rows, "unknown" an answer of its own. ``recall``: share of each truth's known rows
    with the right answer (None where all are unknown). ``balanced_recall``: their mean over the truths.
    ``false_alarms``: share of the known healthy and not evident rows that were called faulty. ``unknown``: share of the
    rows that are unlike the training. ``calibration``: bins of stated probability with mean stated, share right and
    rows; ``calibration_error``: their mean distance, weighted by rows.
    """
    known = found.where(found.known)
    names = sorted(set(found.truth.tolist()))
    recall = {name: _share(known.right[known.truth == name]) for name in names}
    sound = np.isin(known.truth, (HEALTHY, NOT_EVIDENT))
    curve = calibration(known)
    counted = [value for value in recall.values() if value is not None]
    return {
        "rows": len(found.truth),
        "right": _share(known.right),
        "balanced_recall": float(np.mean(counted)) if counted else None,
        "recall": recall,
        "false_alarms": _share(known.answer[sound] != HEALTHY),
        "unknown": _share(~found.known),
        "unknown_by_truth": {name: _share(~found.known[found.truth == name]) for name in names},
        "calibration": curve,
        "calibration_error": _calibration_error(curve),
        "confusion": confusion(found),
    }


def confusion(found: Judged) -> dict[str, dict[str, int]]:
    """Return truth -> answer -> rows; a row unlike the training is answered "unknown"."""
    answers = np.where(found.known, found.answer, UNKNOWN)
    table: dict[str, dict[str, int]] = {}
    for name in sorted(set(found.truth.tolist())):
        kinds, counts = np.unique(answers[found.truth == name], return_counts=True)
        table[name] = {str(kind): int(count) for kind, count in zip(kinds, counts, strict=True)}
    return table


def calibration(found: Judged) -> list[dict[str, float]]:
    """Return bins of equal width of the stated probability that hold any row: stated, right, rows."""
    bins = np.minimum((found.probability * _BINS).astype(int), _BINS - 1)
    return [
        {
            "stated": float(found.probability[bins == one].mean()),
            "right": float(found.right[bins == one].mean()),
            "rows": int((bins == one).sum()),
        }
        for one in np.unique(bins)
    ]


def by_column(found: Judged, column: np.ndarray, *, bins: int = 3) -> dict[str, dict[str, Any]]:
    """Return right, false alarms and unknown by a condition: for each value where these are few, else for ranges.

    Parameters
    ----------
    found : Judged
    column : array (rows,)
        Speed or load; rows without one (NaN) are left out.
    bins : int
        Ranges, and the most values that are kept apart.
    """
    parts = {}
    for label, inside in _ranges(column, bins).items():
        part = scores(found.where(inside))
        keys = ("rows", "right", "balanced_recall", "false_alarms", "unknown")
        parts[label] = {key: part[key] for key in keys}
    return parts


def _ranges(column: np.ndarray, bins: int) -> dict[str, np.ndarray]:
    known = np.isfinite(column)
    values = np.unique(column[known])
    if values.size <= bins:
        # Speeds that read alike are one row.
        labels = np.array([f"{value:.4g}" for value in column])
        return {label: known & (labels == label) for label in dict.fromkeys(f"{value:.4g}" for value in values)}
    edges = np.unique(np.quantile(column[known], np.linspace(0, 1, bins + 1)))
    found = {}
    for low, high in pairwise(edges):
        last = high == edges[-1]
        found[f"{low:.4g} to {high:.4g}"] = known & (column >= low) & ((column <= high) if last else (column < high))
    return found


def _calibration_error(curve: list[dict[str, float]]) -> float | None:
    rows = sum(one["rows"] for one in curve)
    return sum(abs(one["stated"] - one["right"]) * one["rows"] for one in curve) / rows if rows else None


def _share(mask: np.ndarray) -> float | None:
    return float(np.mean(mask)) if mask.size else None


def evaluated(found: Judged, conditions: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Return the scores with those by condition, as the command gives them."""
    return {**scores(found), "by": {name: by_column(found, column) for name, column in conditions.items()}}
