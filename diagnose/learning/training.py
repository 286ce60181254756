"""From a table of features to a model with its card: which machines it learned from, which it was judged on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...simulators.errors import InvalidValueError
from .changes import model_feature_names
from .combination import COMBINED, Weights, race_weights
from .evaluation import Judged, calibration, judged, scores
from .fault_classifier import FaultClassifier
from .feature_table import FeatureTable
from .learning_set import LEAST_MACHINES, LearningSet, learnable, learning_set
from .model_file import Model, model_versions
from .not_evident import FALSE_EVIDENCE

#: p-value below which a recording is unlike the training: one in fifty of machines like those of the training.
UNKNOWN_BELOW = 0.02
_MILDEST = 1 / 3


def train(
    table: FeatureTable,
    *,
    origin: Mapping[str, Any],
    model: str = "boosting",
    seed: int = 0,
    iterations: int = 60,
    judge: bool = True,
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
    judge : bool
        False skips the three judgements.

    Raises
    ------
    InvalidValueError
        When the table has no two faults, or no row in the split "train".
    """
    rows = learning_set(table, seed=seed)
    fitted = rows.columns["split"] == "train"
    if not _has_two(rows.where(fitted)):
        shown = ", ".join(np.unique(rows.labels[fitted])) or "nothing"
        raise InvalidValueError(
            f"Split train of the dataset shows {shown}; allowed: two classes or more, each on {LEAST_MACHINES} machine "
            "draws. Build more of it."
        )
    classifier = _fitted(rows.where(fitted), model, seed, iterations)
    judgements: dict[str, Any] = {}
    if judge:
        judgements["machine"] = _judgement(classifier, rows.where(~fitted))
        for name, held in (("severity", _mild(rows)), ("condition", _fast(rows))):
            part, unseen = rows.where(fitted & ~held), rows.where(~fitted & held)
            usable = _has_two(part) and len(unseen.labels)
            judgements[name] = _judgement(_fitted(part, model, seed, iterations), unseen) if usable else None
    card = _card(rows, fitted, classifier, origin, judgements)
    card["combination"] = _combination(table, rows, fitted, classifier)
    if judge and card["combination"]:
        held = rows.where(~fitted & ~rows.with_baseline)
        card["race_faults_on_held_out_machines"] = _ways(table, held, classifier, Weights(**card["combination"]))
    return Model(classifier, model_feature_names(), card)


def _combination(
    table: FeatureTable, rows: LearningSet, fitted: np.ndarray, classifier: FaultClassifier
) -> dict[str, float] | None:
    """Return the weights of rules and model, where the table says what the rules state."""
    if not any(f"rules.{fault}" in table.names for fault in COMBINED):
        return None
    alone = learnable(rows.where(fitted & ~rows.with_baseline))
    stated = {
        fault: table.only([f"rules.{fault}"]).values[alone.index, 0]
        for fault in COMBINED
        if f"rules.{fault}" in table.names
    }
    try:
        weights = race_weights(stated, alone, classifier)
    except InvalidValueError:  # too few machines for folds
        return None
    return None if weights is None else weights.data()


def _ways(table: FeatureTable, rows: LearningSet, classifier: FaultClassifier, weights: Weights) -> dict[str, Any]:
    """Return how right rules, model and both are on race faults without a baseline.

    ``brier``: mean square of probability minus truth; ``calibration``: bins of the stated probability with mean stated,
    share right and number; ``missed`` and ``false``: race faults that are below even odds, others that are above.
    """
    faults = [one for one in COMBINED if one in classifier.classes_ and f"rules.{one}" in table.names]
    if not len(rows.labels) or not faults:
        return {}
    rules = table.only([f"rules.{one}" for one in faults]).values[rows.index].ravel()
    places = [classifier.classes_.tolist().index(one) for one in faults]
    model = classifier.predict_proba(rows.values)[:, places].ravel()
    present = (rows.labels[:, None] == np.array(faults)).ravel()
    found: dict[str, Any] = {"asked": int(present.size), "present": int(present.sum())}
    # As in use: the model changes what the rules found, and adds nothing.
    both = np.where(rules > 0, weights.doubted(rules, model), 0.0)
    for name, stated in (("rules", rules), ("model", model), ("both", both)):
        wrong = {"missed": int((present & (stated <= 0.5)).sum()), "false": int((~present & (stated > 0.5)).sum())}
        answer = np.where(present, "yes", "no")
        judged_so = Judged(answer, np.full(present.size, "yes"), stated, np.ones(present.size), 0.0)
        found[name] = {"brier": float(np.mean((stated - present) ** 2)), **wrong, "calibration": calibration(judged_so)}
    return found


def _has_two(rows: LearningSet) -> bool:
    return np.unique(learnable(rows).labels).size > 1


def _fitted(rows: LearningSet, model: str, seed: int, iterations: int) -> FaultClassifier:
    made = FaultClassifier(model=model, iterations=iterations, random_state=seed)
    used = learnable(rows)
    return made.fit(used.values, used.labels, groups=used.groups)


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
    groups = rows.groups
    used = learnable(rows.where(fitted))
    taught = {str(one): int((used.labels == one).sum()) for one in classifier.classes_}
    return {
        "origin": dict(origin),
        "model": classifier.model,
        "seed": classifier.random_state,
        "iterations": classifier.iterations,
        "calibrated": classifier.calibrated_,
        "unknown_below": UNKNOWN_BELOW,
        "rows_taught": taught,
        "not_taught": sorted(set(rows.labels[fitted].tolist()) - set(taught)),
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


__all__ = ["UNKNOWN_BELOW", "train"]
