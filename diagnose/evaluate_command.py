"""``rotorwise evaluate``: how good a classifier is, on a simulated dataset or on labelled recordings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..simulators.errors import InvalidValueError
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
    from ..datasets.metadata import Metadata
    from .learning.evaluated_sources import Evaluated
    from .learning.model_file import Model

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
    from .learning.evaluated_sources import on_dataset, on_files
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
            with measuring("features") as tell:
                found = on_dataset(
                    used,
                    sources,
                    split=split,
                    seed=seed,
                    noise=not no_machine_noise,
                    workers=jobs or cores(),
                    tell=tell,
                )
        else:
            _check_unused("recordings", split=split)
            metadata = _metadata(rate, unit, speed, bearing)
            found = on_files(used, sources, label=label, baseline=baseline or [], metadata=metadata, sidecar=sidecar)
        for message in found.unreadable:
            typer.echo(f"rotorwise: {message}", err=True)
        if report is not None:
            _write(found, used, report, force=force)
    _say(found, report, as_json=as_json)
    if found.unreadable:
        raise typer.Exit(_FAILED)


def _say(found: Evaluated, report: Path | None, *, as_json: bool) -> None:
    if as_json:
        print(json.dumps({**found.data, "files": list(found.files), "remarks": list(found.remarks)}, indent=2))
    else:
        _show(found, report)


def _metadata(rate: options.Rate, unit: options.Unit, speed: options.Speed, bearing: options.Bearing) -> Metadata:
    record = options.record_metadata(rate, speed, None, None)
    machine = options.machine_metadata(bearing, None, None, None, None, None, None)
    return record.merged_over(options.channel_metadata(unit, None, None, None, None)).merged_over(machine)


def _check_unused(what: str, **given: object) -> None:
    for name, value in given.items():
        if value is not None:
            raise InvalidValueError(f"--{name} says nothing to {what}; allowed: leave it out.")


def _default() -> Model:
    from .learning.default_model import default_model

    return default_model()


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
