"""``rotorwise train``: a classifier of faults from a simulated dataset, with its card."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError
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
    from .learning.model_file import Model

_MOST_ITERATIONS = 10_000

Location = Annotated[
    str,
    typer.Argument(
        help="Dataset, or features that --features wrote.", metavar="STORE|FILE.parquet", show_default=False
    ),
]
Output = Annotated[Path, option("--output", "-o", value="FILE.skops", text="The model goes here.")]
Kind = Annotated[str, option("--model", value="boosting|linear", text="Gradient boosting, or the linear baseline.")]
Iterations = Annotated[int, option("--iterations", value="N", text="Trees a fault; 60 when left out.")]
Features = Annotated[
    Path | None, option("--features", value="FILE.parquet", text="Write the table of features too; train takes it.")
]
AsJson = Annotated[bool, option("--json", text="Print the model's card as JSON.")]
Force = Annotated[bool, option("--force", text="Replace an earlier model or table of features.")]


def train(
    store: Location,
    output: Output,
    model: Kind = "boosting",
    seed: Seed = 0,
    iterations: Iterations = 60,
    no_machine_noise: NoNoise = False,
    features: Features = None,
    jobs: Jobs = None,
    as_json: AsJson = False,
    force: Force = False,
) -> None:
    """Train a classifier of faults on simulated machines, and judge it on machines that it did not see."""
    from .learning.feature_file import FeaturePlaceError, write_features
    from .learning.model_file import ModelFileError, save_model
    from .learning.sources import rows_to_learn
    from .learning.training import train as fit

    with exit_codes(ModelFileError, FeaturePlaceError):
        check_whole_numbers(
            seed=(seed, 0, HIGHEST_SEED), iterations=(iterations, 1, _MOST_ITERATIONS), jobs=(jobs, 1, MOST_JOBS)
        )
        _check_places(output, features, force=force)
        with measuring("features") as tell:
            table, origin = rows_to_learn(
                store, seed=seed, workers=jobs or cores(), noise=not no_machine_noise, tell=tell
            )
        if features is not None:
            write_features(table, features, origin, force=force)
        made = fit(table, origin=origin, model=model, seed=seed, iterations=iterations)
        save_model(made, output, force=force)
    if as_json:
        print(json.dumps(made.card, indent=2))
        return
    _show(made, output, features)


def _check_places(output: Path, features: Path | None, *, force: bool) -> None:
    from .learning import feature_file, model_file

    model_file.check_place(output, force=force)
    if features is None:
        return
    feature_file.check_place(features, force=force)
    if features.resolve() == output.resolve():
        raise InvalidValueError(f"--features {features} is the model's own file; allowed: another one. Correct it.")


def _show(made: Model, output: Path, features: Path | None) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False)
    card = made.card
    console.print(f"[bold]{card['model']} classifier of {', '.join(card['rows_taught'])}[/]")
    facts = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    facts.add_row("learned from", f"{sum(card['rows_taught'].values())} rows, {len(card['machines_fitted'])} machines")
    facts.add_row("taught as healthy", f"{card['not_evident']} rows whose fault does not show")
    console.print(facts)
    held = Table(box=None, padding=(0, 2, 0, 0), title="Judged on machines that it did not see", title_justify="left")
    for head in ("split", "rows", "right", "mean recall", "false alarms", "unknown", "calibration error"):
        held.add_column(head, justify="left" if head == "split" else "right")
    for name, found in card["judged_on_held_out_machines"].items():
        held.add_row(*_row(name, found))
    console.print(held)
    for path in (output, features):
        if path is not None:
            console.print(f"{path}, {path.stat().st_size / 1e3:.0f} kB", markup=False)


def _row(name: str, found: dict[str, Any] | None) -> tuple[str, ...]:
    words = {"severity": "mildest third of faults unseen", "condition": "faster half of records unseen"}
    label = f"machine, {words[name]}" if name in words else name
    if found is None:
        return label, "none held out", "", "", "", "", ""
    error = found["calibration_error"]
    shares = (_percent(found[key]) for key in ("right", "balanced_recall", "false_alarms", "unknown"))
    return label, str(found["rows"]), *shares, "-" if error is None else f"{error:.3f}"


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:.1%}"
