"""``rotorwise train``: a classifier of faults from a simulated dataset, with its card."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from .cli_options import option

if TYPE_CHECKING:
    from .learning.model_file import Model

_USAGE, _FAILED, _OUTPUT_FAILED = 2, 3, 4

Location = Annotated[
    str,
    typer.Argument(
        help="Dataset, or features that --features wrote.", metavar="STORE|FILE.parquet", show_default=False
    ),
]
Output = Annotated[Path, option("--output", "-o", value="FILE.skops", text="The model goes here.")]
Kind = Annotated[str, option("--model", value="boosting|linear", text="Gradient boosting, or the linear baseline.")]
Seed = Annotated[int, option("--seed", value="N", text="Of the machines' noise and of the classifier.")]
Iterations = Annotated[int, option("--iterations", value="N", text="Trees a fault; 60 when left out.")]
NoNoise = Annotated[bool, option("--no-machine-noise", text="Leave the noise of real machines away.")]
Features = Annotated[
    Path | None, option("--features", value="FILE.parquet", text="Write the table of features too; train takes it.")
]
Jobs = Annotated[int | None, option("--jobs", value="N", text="Processes; one for every core when left out.")]
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
    from .learning.feature_file import FeatureFileError, write_features
    from .learning.model_file import ModelFileError, check_model_place, save_model
    from .learning.sources import rows_to_learn
    from .learning.training import train as fit

    try:
        _check(seed, iterations, jobs)
        check_model_place(output, force=force)
        if features is not None and features.exists() and not force:
            raise FeatureFileError(f"{features} exists already. Choose another name, or allow overwriting (--force).")
        with measuring("features") as tell:
            table, origin = rows_to_learn(
                store, seed=seed, workers=jobs or cores(), noise=not no_machine_noise, tell=tell
            )
        if features is not None:
            write_features(table, features, origin, force=force)
        made = fit(table, origin=origin, model=model, seed=seed, iterations=iterations)
        save_model(made, output, force=force)
    except (ModelFileError, FeatureFileError) as problem:
        raise leave(problem, _OUTPUT_FAILED) from None
    except InvalidValueError as problem:
        raise leave(problem, _USAGE) from None
    except RotorwiseError as problem:
        raise leave(problem, _FAILED) from None
    if as_json:
        print(json.dumps(made.card, indent=2))
        return
    _show(made, output, features)


def _check(seed: int, iterations: int, jobs: int | None) -> None:
    for name, value, least in (("--seed", seed, 0), ("--iterations", iterations, 1), ("--jobs", jobs or 1, 1)):
        if value < least:
            raise InvalidValueError(f"{name} {value}; allowed: {least} or more. Correct it.")


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def leave(problem: Exception, code: int) -> typer.Exit:
    """Return an exit after the message was printed."""
    typer.echo(f"rotorwise: {problem}", err=True)
    return typer.Exit(code)


@contextmanager
def measuring(what: str) -> Iterator[Callable[[int, int], None]]:
    """Give what shows the progress: a bar on a terminal, else a line at every tenth."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None)

        def tell(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)
            if not bar.console.is_terminal and (done * 10) // total != ((done - 1) * 10) // total:
                print(f"rotorwise: {what} {done} of {total}", file=sys.stderr, flush=True)

        yield tell


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
