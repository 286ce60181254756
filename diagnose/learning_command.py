"""What the commands that learn share: options, progress, and the exit code of each kind of error."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from .cli_options import option

_USAGE, _FAILED, _OUTPUT_FAILED = 2, 3, 4
#: What scikit-learn takes as a seed, and more processes than any computer has cores.
HIGHEST_SEED, MOST_JOBS = 2**32 - 1, 4096

Seed = Annotated[int, option("--seed", value="N", text="Of the machines' noise and of the classifier.")]
NoNoise = Annotated[bool, option("--no-machine-noise", text="Leave the noise of real machines away.")]
Jobs = Annotated[int | None, option("--jobs", value="N", text="Processes; one for every core when left out.")]


@contextmanager
def exit_codes(*outputs: type[RotorwiseError]) -> Iterator[None]:
    """Turn errors into a message and an exit: ``outputs`` 4, a wrong value 2, everything else 3."""
    try:
        yield
    except RotorwiseError as problem:
        typer.echo(f"rotorwise: {problem}", err=True)
        if isinstance(problem, outputs):
            raise typer.Exit(_OUTPUT_FAILED) from None
        raise typer.Exit(_USAGE if isinstance(problem, InvalidValueError) else _FAILED) from None


def check_whole_numbers(**given: tuple[int | None, int, int]) -> None:
    """Raise InvalidValueError for a value outside its ends; None is left out. Names are those of the options."""
    for name, (value, lowest, highest) in given.items():
        if value is not None and not lowest <= value <= highest:
            raise InvalidValueError(f"--{name} {value}; allowed: {lowest} to {highest}. Correct it.")


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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
