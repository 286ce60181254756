"""``rotorwise evaluate``: how good a classifier is, on a simulated dataset or on labelled recordings."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from . import cli_options as options
from .cli_options import option
from .learning_command import (
    HIGHEST_SEED,
    MOST_JOBS,
    Jobs,
    NoNoise,
    Seed,
    check_whole_numbers,
    cores,
    exit_codes,
    measuring,
)

if TYPE_CHECKING:
    from .learning.evaluation import Judged
    from .learning.model_file import Model
    from .learning.sources import FileRow

_FAILED = 3

ModelFile = Annotated[
    Path, typer.Argument(help="What rotorwise train wrote, or default.", metavar="MODEL", show_default=False)
]
Sources = Annotated[
    list[str],
    typer.Argument(help="A dataset, a feature file, or recordings.", metavar="STORE|FILE...", show_default=False),
]
Label = Annotated[
    str | None, option("--label", value="FAULT", text="What is wrong with all recordings given: a fault, or healthy.")
]
Split = Annotated[str | None, option("--split", value="NAME", text="Of the dataset, only this split.")]
AsJson = Annotated[bool, option("--json", text="Print JSON.")]
Force = Annotated[bool, option("--force", text="Replace an existing report.")]


@dataclass(frozen=True, eq=False)
class Evaluated:
    """What an evaluation gave: its numbers as JSON types, and the answer for each recording, if any were given."""

    data: dict[str, Any]
    files: tuple[dict[str, Any], ...]
    remarks: tuple[str, ...]
    unreadable: int = 0


def evaluate(
    model: ModelFile,
    sources: Sources,
    label: Label = None,
    baseline: options.Baseline = None,
    split: Split = None,
    seed: Seed = 0,
    no_machine_noise: NoNoise = False,
    rate: options.Rate = None,
    unit: options.Unit = None,
    speed: options.Speed = None,
    bearing: options.Bearing = None,
    sidecar: options.Sidecar = None,
    jobs: Jobs = None,
    report: options.Report = None,
    as_json: AsJson = False,
    force: Force = False,
) -> None:
    """Judge a classifier: confusion matrix, recall, calibration, share of "unknown", by speed and load.

    The truth of a recording comes from --label or from `label` in its recording.toml.
    """
    from .learning.model_file import load_model
    from .learning.sources import holds_rows
    from .papers_files import TableFileError
    from .report.write import ReportFileError, check_free

    with exit_codes(ReportFileError, TableFileError):
        check_whole_numbers(seed=(seed, 0, HIGHEST_SEED), jobs=(jobs, 1, MOST_JOBS))
        if report is not None:
            check_free(report.resolve(), force=force)
        used = _default() if str(model) == "default" else load_model(model)
        if holds_rows(sources[0]):
            _check_unused(
                "a dataset", label=label, baseline=baseline, sidecar=sidecar, rate=rate, unit=unit, speed=speed
            )
            found = _on_dataset(used, sources, split=split, seed=seed, noise=not no_machine_noise, jobs=jobs)
        else:
            _check_unused("recordings", split=split)
            record = options.record_metadata(rate, speed, None, None)
            machine = options.machine_metadata(bearing, None, None, None, None, None, None)
            metadata = record.merged_over(options.channel_metadata(unit, None, None, None, None)).merged_over(machine)
            found = _on_files(used, sources, label=label, baseline=baseline or [], metadata=metadata, sidecar=sidecar)
        if report is not None:
            _write(found, used, report, force=force)
    if as_json:
        print(json.dumps({**found.data, "files": list(found.files), "remarks": list(found.remarks)}, indent=2))
    else:
        _show(found, report)
    if found.unreadable:
        raise typer.Exit(_FAILED)


def _check_unused(what: str, **given: object) -> None:
    for name, value in given.items():
        if value is not None:
            raise InvalidValueError(f"--{name} says nothing to {what}; allowed: leave it out.")


def _default() -> Model:
    from .learning.default_model import default_model

    return default_model()


def _on_dataset(
    model: Model, sources: list[str], *, split: str | None, seed: int, noise: bool, jobs: int | None
) -> Evaluated:
    from .learning.evaluation import evaluated, judged
    from .learning.learning_set import learning_set
    from .learning.sources import rows_to_learn

    if len(sources) > 1:
        raise InvalidValueError(f"{len(sources)} datasets; allowed: one, or recordings. Evaluate one after the other.")
    with measuring("features") as tell:
        table, origin = rows_to_learn(sources[0], seed=seed, workers=jobs or cores(), noise=noise, tell=tell)
    seen = set(model.card.get("machines_fitted", ())) if _same_machines(model, origin) else set()
    if split is not None:
        known = sorted(set(table.columns["split"].tolist()))
        if split not in known:
            raise InvalidValueError(f"--split {split!r}; allowed: {', '.join(known)}. Correct it.")
        table = table.where(table.columns["split"] == split)
    rows = learning_set(table, seed=seed)
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
    machines = {f"{kind}/{group}" for kind, group in zip(table.columns["machine"], table.columns["group"], strict=True)}
    if seen & machines:
        remarks.append(
            f"{len(seen & machines)} of {len(machines)} machines of this dataset were learned: such rows flatter. Give "
            "--split test."
        )
    return Evaluated(data, (), tuple(remarks))


def _same_machines(model: Model, origin: dict[str, Any]) -> bool:
    return model.card.get("origin", {}).get("fingerprint") == origin.get("fingerprint")


def _brief(part: Judged) -> dict[str, Any]:
    from .learning.evaluation import scores

    found = scores(part)
    return {key: found[key] for key in ("rows", "right", "balanced_recall", "false_alarms", "unknown")}


def _on_files(
    model: Model, sources: list[str], *, label: str | None, baseline: list[Path], metadata: Any, sidecar: Path | None
) -> Evaluated:
    import numpy as np

    from ..datasets.reading import find_recordings
    from .learning.evaluation import evaluated, judged
    from .learning.sources import FileRow, check_label, file_row, observation_of

    check_label(label)
    paths, _ = find_recordings([Path(one) for one in sources])
    if not paths:
        raise InvalidValueError(
            f"No recording in {', '.join(sources)}; allowed: files that a reader knows. Check the path."
        )
    healthy = [observation_of(one, metadata=metadata, sidecar=sidecar) for one in baseline]
    own = {one.resolve() for one in baseline}
    rows, unreadable = [], 0
    for one in paths:
        before = () if one.resolve() in own else healthy
        try:
            rows.append(file_row(one, metadata=metadata, sidecar=sidecar, baseline=before, label=label))
        except RotorwiseError as problem:
            said, unreadable = str(problem), unreadable + 1
            typer.echo(f"rotorwise: {said if one.name in said else f'{one}: {said}'}", err=True)
            rows.append(FileRow(str(one), None, None, np.nan, np.nan, said))
    answers = [_answer(model, row) for row in rows]
    known = [row for row in rows if row.label is not None and row.values is not None]
    remarks = [*model.remarks]
    if len(known) < len(rows):
        remarks.append(
            f"{len(rows) - len(known)} of {len(rows)} recordings lack label or speed, or cannot be read: not counted."
        )
    if not known:
        return Evaluated({"source": "recordings", "rows": 0}, tuple(answers), tuple(remarks), unreadable)
    values = np.array([row.values for row in known])
    truth = np.array([row.label for row in known])
    found = judged(model.classifier, values, truth, unknown_below=model.card["unknown_below"])
    conditions = {
        "speed_rpm": np.array([row.speed_rpm for row in known]),
        "load": np.array([row.load for row in known]),
    }
    return Evaluated(
        {"source": "recordings", **evaluated(found, conditions)}, tuple(answers), tuple(remarks), unreadable
    )


def _answer(model: Model, row: FileRow) -> dict[str, Any]:
    said: dict[str, Any] = {"path": row.path, "label": row.label}
    if row.values is None:
        return {**said, "answer": None, "reason": row.reason}
    from .learning.evaluation import UNKNOWN

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


def _write(found: Evaluated, model: Model, report: Path, *, force: bool) -> None:
    from .learning.evaluation_page import evaluation_page
    from .papers_files import write_whole
    from .report.write import check_free

    page = evaluation_page(found.data, found.files, found.remarks, model.card)
    check_free(report.resolve(), force=force)
    write_whole(report, page)


def _show(found: Evaluated, report: Path | None) -> None:
    from rich.console import Console

    from .learning.evaluation_tables import tables

    console = Console(highlight=False)
    for table in tables(found.data, found.files):
        console.print(table)
    for remark in found.remarks:
        console.print(f"[yellow]![/] {remark}")
    if report is not None:
        console.print(str(report), markup=False)
