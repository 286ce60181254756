"""Builds a dataset: computes the parts that are missing, on this computer's cores or a Dask cluster, and writes them.

Parts are computed anywhere and written by this process, which alone holds the store's lock; only a location that
every computer reaches under the same name is written to by the workers themselves.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Generator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .card import card_text
from .errors import BuildError, InvalidValueError
from .generate_part import Part, make_part
from .generate_table import channels_of
from .recipe import Recipe
from .recipe_file import load_recipe
from .recipe_parts import Parts, part_name
from .store import CARD, DATA, MANIFEST, Store, check_free, create_store, totals
from .store_folder import Say, StoreError, folder_of, quiet

#: Parts that are computed or wait to be written, for each worker: more would only fill the memory.
AHEAD = 2


@dataclass(frozen=True)
class Progress:
    """How far a build is.

    Attributes
    ----------
    signals, wanted : int
        Signals done, refused ones included, and asked for.
    refused : int
    at_start : int
        Signals that were there before.
    """

    signals: int
    wanted: int
    refused: int
    at_start: int


Tell = Callable[[Progress], None]


def build(
    recipe: Recipe | str | Path,
    location: str | Path,
    *,
    workers: int | None = None,
    cluster: str | None = None,
    limit: int | None = None,
    tell: Tell = lambda _progress: None,
    say: Say = quiet,
) -> Store:
    """Build a dataset, or go on with it where it was stopped.

    More than one worker means new processes, which read the script that calls this again: call it below
    ``if __name__ == "__main__":``.

    Parameters
    ----------
    recipe : Recipe, or name of a shipped recipe, or path of a TOML file
    location : str or Path
        Folder, or an address that fsspec knows.
    workers : int, optional
        Processes; one for every core when left out.
    cluster : str, optional
        Address of a Dask scheduler; its workers compute instead.
    limit : int, optional
        Only the first so many signals. A later build without it goes on.
    tell : callable
        Called with the `Progress` at the start and after every part.
    say : callable
        Called with a line of text when the build waits for another one, or takes over from one that has ended.

    Raises
    ------
    InvalidValueError
        For a recipe or an option that is not allowed.
    StoreError
        When the location cannot be written to, holds something else, or another process builds there.
    BuildError
        When a worker failed.
    """
    recipe = recipe if isinstance(recipe, Recipe) else load_recipe(recipe)
    for name, value in (("workers", workers), ("limit", limit)):
        if value is not None and value < 1:
            raise InvalidValueError(f"{name} = {value}; allowed: 1 or more. Correct it.")
    folder = folder_of(location)
    check_free(folder)
    with folder.alone(say) as check:
        store = create_store(folder, recipe)
        try:
            _build(store, Parts(recipe, limit), workers or _cores(), cluster, tell, check)
        except (BuildError, KeyboardInterrupt):
            with suppress(StoreError):
                summarise(store)
            raise
        summarise(store)
    return store


def _build(
    store: Store, parts: Parts, workers: int, cluster: str | None, tell: Tell, check: Callable[[], None]
) -> None:
    there = store.parts()
    whole = {number: facts for number, facts in there.items() if _is_whole(parts, number, facts)}
    missing = [number for number in range(parts.count) if number not in whole]
    done = sum(facts["signals"] for facts in whole.values())
    refused = sum(len(facts["refused"]) for facts in whole.values())
    wanted, at_start = max(parts.signals, done), done
    tell(Progress(done, wanted, refused, at_start))
    if cluster is not None:
        from .generate_cluster import computed_on_cluster

        results = computed_on_cluster(store, missing, parts.limit, address=cluster)
    elif workers == 1 or len(missing) < 2:
        results = _computed_here(store, missing, parts.limit)
    else:
        from .generate_local import computed_by_processes

        results = computed_by_processes(store, missing, parts.limit, workers=workers, ahead=AHEAD)
    with closing(results):
        for part in results:
            check()
            if part.content:
                store.write_part(part.name, part.content)
            done, refused = done + part.facts["signals"], refused + len(part.facts["refused"])
            tell(Progress(done, wanted, refused, at_start))


def _is_whole(parts: Parts, number: int, facts: dict[str, Any]) -> bool:
    """Return whether a part holds what it should; one of an earlier, lower limit is shorter and is made again."""
    if number >= parts.count:
        return True
    numbers = parts.numbers(number)
    return facts["first"] == numbers.start and facts["signals"] >= len(numbers)


def _computed_here(store: Store, missing: Sequence[int], limit: int | None) -> Generator[Part, None, None]:
    for number in missing:
        yield make_part(store.recipe.source, number, limit=limit)


def _cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def summarise(store: Store) -> None:
    """Write manifest and card from the parts that are there."""
    parts, sizes = store.parts(), store.folder.sizes(DATA)
    found = _summary(store, parts, sizes)
    files = [
        {key: facts[key] for key in ("part", "first", "signals", "rows")}
        | {"name": part_name(number), "bytes": sizes[part_name(number)], "refused": len(facts["refused"])}
        for number, facts in parts.items()
    ]
    store.folder.write(MANIFEST, (json.dumps({**found, "files": files}, indent=1) + "\n").encode())
    store.folder.write(CARD, card_text(store.recipe, found).encode())


def summary_of(store: Store) -> dict[str, Any]:
    """Return what a dataset is and holds, as its parts say: counts, refused draws, versions, size."""
    return _summary(store, store.parts(), store.folder.sizes(DATA))


def _summary(store: Store, parts: dict[int, dict[str, Any]], sizes: dict[str, int]) -> dict[str, Any]:
    recipe, names = store.recipe, {part_name(number) for number in parts}
    return {
        "name": recipe.name,
        "meaning": recipe.meaning,
        "fingerprint": recipe.fingerprint,
        "seed": recipe.seed,
        "signals_wanted": recipe.signals,
        "parts_wanted": Parts(recipe).count,
        **totals(parts.values()),
        "bytes": sum(size for name, size in sizes.items() if name in names),
        "unreadable": sorted(set(sizes) - names),
        "channels": {name: said["unit"] for name, said in channels_of(recipe).items()},
        "splits": dict(recipe.splits),
    }


__all__ = ["BuildError", "Progress", "StoreError", "build", "summarise", "summary_of"]
