"""``rotorwise dataset``: build labelled datasets from recipes, say what a dataset holds, list the recipes."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from .cli_options import option

if TYPE_CHECKING:
    from ..datasets.recipe import Recipe

_USAGE, _FAILED, _OUTPUT_FAILED, _INTERRUPTED, _STOPPED = 2, 3, 4, 130, 143

dataset = typer.Typer(
    no_args_is_help=True, rich_markup_mode=None, help="Make labelled datasets of simulated signals, and look at them."
)

RecipeName = Annotated[
    str, typer.Argument(help="Name of a shipped recipe, or a recipe file.", metavar="RECIPE|FILE.toml")
]
Output = Annotated[
    str, option("--output", "-o", value="FOLDER", text="New or begun dataset: a folder, or an address like s3://...")
]
Workers = Annotated[int | None, option("--workers", value="N", text="Processes; one for every core when left out.")]
Cluster = Annotated[str | None, option("--cluster", value="ADDRESS", text="Dask scheduler whose workers compute.")]
Limit = Annotated[int | None, option("--limit", value="N", text="Only the first N signals; go on later without it.")]
Location = Annotated[str, typer.Argument(help="Folder or address of a dataset.", metavar="FOLDER", show_default=False)]
AsJson = Annotated[bool, option("--json", text="Print JSON.")]


@dataset.command()
def build(
    recipe: RecipeName,
    output: Output,
    workers: Workers = None,
    cluster: Cluster = None,
    limit: Limit = None,
    as_json: AsJson = False,
) -> None:
    """Build a dataset, or go on with one that was stopped. The content depends on the recipe only."""
    from ..datasets.generate import build as build_dataset
    from ..datasets.generate import summary_of
    from ..datasets.recipe_file import load_recipe
    from .dataset_show import building, show_built

    try:
        if workers is not None and cluster is not None:
            raise InvalidValueError("--workers is for this computer, --cluster for others. Give one of them.")
        chosen = load_recipe(recipe)
        with _stopped_in_order(), building(chosen) as tell:
            store = build_dataset(chosen, output, workers=workers, cluster=cluster, limit=limit, tell=tell, say=_say)
        found = summary_of(store)
    except RotorwiseError as problem:
        raise _leave(problem) from None
    except KeyboardInterrupt as stop:
        print(f"rotorwise: stopped. What is in {output} is whole; the same command goes on.", file=sys.stderr)
        raise typer.Exit(_INTERRUPTED if not stop.args else _STOPPED) from None
    if as_json:
        print(json.dumps({"location": store.folder.name, **found}, indent=2))
    else:
        show_built(store.folder.name, found)


@dataset.command()
def info(location: Location, as_json: AsJson = False) -> None:
    """Say what a dataset holds: counts, refused draws, seed, versions, size. Reads no signals."""
    from ..datasets.generate import summary_of
    from ..datasets.store import open_store
    from .dataset_show import show_info

    try:
        store = open_store(location)
        found = summary_of(store)
    except RotorwiseError as problem:
        raise _leave(problem) from None
    if as_json:
        print(json.dumps({"location": store.folder.name, **found}, indent=2))
    else:
        show_info(store.folder.name, found)


@dataset.command()
def recipes(as_json: AsJson = False) -> None:
    """List the shipped recipes."""
    from ..datasets.recipe_file import load_recipe, shipped_recipes

    found = [_recipe_data(load_recipe(name)) for name in shipped_recipes()]
    if as_json:
        print(json.dumps(found, indent=2))
        return
    from .dataset_show import show_recipes

    show_recipes(found)


@contextmanager
def _stopped_in_order() -> Iterator[None]:
    """Let SIGTERM, with which schedulers and containers stop a program, end a build as Ctrl-C does."""

    def stop(number: int, _frame: object) -> None:
        raise KeyboardInterrupt(number)

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _say(text: str) -> None:
    print(f"rotorwise: {text}", file=sys.stderr, flush=True)


def _recipe_data(recipe: Recipe) -> dict[str, Any]:
    return {
        "name": recipe.name,
        "meaning": recipe.meaning,
        "machines": [one.name for one in recipe.machines],
        "signals": recipe.signals,
        "seed": recipe.seed,
        "splits": dict(recipe.splits),
    }


def _leave(problem: RotorwiseError) -> typer.Exit:
    from ..datasets.generate import BuildError
    from ..datasets.store_folder import StoreError

    print(f"rotorwise: {problem}", file=sys.stderr)
    codes = {StoreError: _OUTPUT_FAILED, BuildError: _FAILED}
    return typer.Exit(next((code for kind, code in codes.items() if isinstance(problem, kind)), _USAGE))
