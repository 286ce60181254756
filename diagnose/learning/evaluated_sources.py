"""How a classifier answers a dataset, a feature file or labelled recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.reading import find_recordings
from ...simulators.errors import InvalidValueError, RotorwiseError
from .evaluation import UNKNOWN, Judged, evaluated, judged, scores
from .learning_set import learning_set
from .sources import FileRow, check_label, file_row, observation_of, rows_to_learn

if TYPE_CHECKING:
    from ...datasets.metadata import Metadata
    from .model_file import Model


@dataclass(frozen=True, eq=False)
class Evaluated:
    """What an evaluation gave.

    Attributes
    ----------
    data : dict
        Its numbers as JSON types; ``rows`` 0 where no truth was known.
    files : tuple of dict
        The answer for each recording, if any were given.
    remarks : tuple of str
    unreadable : tuple of str
        One message a recording that could not be read.
    """

    data: dict[str, Any]
    files: tuple[dict[str, Any], ...]
    remarks: tuple[str, ...]
    unreadable: tuple[str, ...] = ()


def on_dataset(
    model: Model,
    sources: Sequence[str],
    *,
    split: str | None,
    seed: int,
    noise: bool,
    workers: int,
    tell: Callable[[int, int], None],
) -> Evaluated:
    """Return how a classifier answers a dataset or feature file, alone and against healthy records.

    Raises
    ------
    RotorwiseError
        For more than one source, an unknown split, and as `rows_to_learn`.
    """
    if len(sources) > 1:
        raise InvalidValueError(f"{len(sources)} datasets; allowed: one, or recordings. Evaluate one after the other.")
    table, origin = rows_to_learn(sources[0], seed=seed, workers=workers, noise=noise, tell=tell)
    seen = set(model.card.get("machines_fitted", ())) if _same_machines(model, origin) else set()
    if split is not None:
        known = sorted(set(table.columns["split"].tolist()))
        if split not in known:
            raise InvalidValueError(f"--split {split!r}; allowed: {', '.join(known)}. Correct it.")
    # What is evident is told by the healthy records of the whole table, as in the training.
    rows = learning_set(table, seed=seed)
    if split is not None:
        rows = rows.where(rows.columns["split"] == split)
    found = judged(model.classifier, rows.values, rows.truth, unknown_below=model.card["unknown_below"])
    conditions = {"speed_rpm": rows.columns["speed_rpm"], "load": rows.columns["load"].astype(float)}
    parts = {
        "alone": found.where(~rows.with_baseline),
        "with a healthy record": found.where(rows.with_baseline),
    }
    data = {
        "source": sources[0],
        **evaluated(found, conditions),
        "situations": {name: _brief(part) for name, part in parts.items() if len(part.truth)},
    }
    remarks = list(model.remarks)
    machines = set(rows.groups.tolist())
    if seen & machines:
        remarks.append(
            f"{len(seen & machines)} of {len(machines)} machines of this dataset were learned: such rows flatter. Give "
            "--split test."
        )
    return Evaluated(data, (), tuple(remarks))


def _same_machines(model: Model, origin: dict[str, Any]) -> bool:
    return model.card.get("origin", {}).get("fingerprint") == origin.get("fingerprint")


def _brief(part: Judged) -> dict[str, Any]:
    found = scores(part)
    return {key: found[key] for key in ("rows", "right", "balanced_recall", "false_alarms", "unknown")}


def on_files(
    model: Model,
    sources: Sequence[str],
    *,
    label: str | None,
    baseline: Sequence[Path],
    metadata: Metadata,
    sidecar: Path | None,
) -> Evaluated:
    """Return how a classifier answers recordings; those with a known truth are counted.

    Raises
    ------
    RotorwiseError
        For a label that is no fault, a source that does not exist or holds no recording, an unreadable baseline.
    """
    check_label(label)
    paths, _ = find_recordings([Path(one) for one in sources])
    if not paths:
        raise InvalidValueError(
            f"No recording in {', '.join(sources)}; allowed: files that a reader knows. Check the path."
        )
    healthy = [observation_of(one, metadata=metadata, sidecar=sidecar) for one in baseline]
    own = {one.resolve() for one in baseline}
    rows, unreadable = [], []
    for one in paths:
        before = () if one.resolve() in own else healthy
        try:
            rows.append(file_row(one, metadata=metadata, sidecar=sidecar, baseline=before, label=label))
        except RotorwiseError as problem:
            said = str(problem)
            unreadable.append(said if one.name in said else f"{one}: {said}")
            rows.append(FileRow(str(one), None, None, np.nan, np.nan, said))
    answers = [_answer(model, row) for row in rows]
    known = [row for row in rows if row.label is not None and row.values is not None]
    remarks = [*model.remarks]
    if len(known) < len(rows):
        remarks.append(
            f"{len(rows) - len(known)} of {len(rows)} recordings lack label or speed, or cannot be read: not counted."
        )
    if not known:
        return Evaluated({"source": "recordings", "rows": 0}, tuple(answers), tuple(remarks), tuple(unreadable))
    values = np.array([row.values for row in known])
    truth = np.array([row.label for row in known])
    found = judged(model.classifier, values, truth, unknown_below=model.card["unknown_below"])
    conditions = {
        "speed_rpm": np.array([row.speed_rpm for row in known]),
        "load": np.array([row.load for row in known]),
    }
    return Evaluated(
        {"source": "recordings", **evaluated(found, conditions)}, tuple(answers), tuple(remarks), tuple(unreadable)
    )


def _answer(model: Model, row: FileRow) -> dict[str, Any]:
    said: dict[str, Any] = {"path": row.path, "label": row.label}
    if row.values is None:
        return {**said, "answer": None, "reason": row.reason}
    probability = model.classifier.predict_proba(row.values[None])[0]
    p_value = float(model.classifier.novelty_p_value(row.values[None])[0])
    best = int(probability.argmax())
    return {
        **said,
        "answer": UNKNOWN if p_value < model.card["unknown_below"] else str(model.classifier.classes_[best]),
        "likeliest": str(model.classifier.classes_[best]),
        "probability": round(float(probability[best]), 4),
        "p_value": round(p_value, 4),
    }
