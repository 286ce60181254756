"""How fast datasets are built, where the time goes, how much memory it takes.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/dataset_throughput.py [SIGNALS] [WORKERS]

Builds the beginning of ``gearbox_faults``: one-second signals of three accelerometers and a tacho at 30 kHz. The first
part of a build pays for starting processes; the rate after it is what a long build has.
"""

from __future__ import annotations

import json
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

from rotorwise.datasets import generate_part
from rotorwise.datasets.generate import Progress, build, summary_of
from rotorwise.datasets.recipe_draw import draw_signal, position_of
from rotorwise.datasets.recipe_file import load_recipe
from rotorwise.datasets.recipe_parts import Parts

RECIPE = "gearbox_faults"


def main() -> None:
    """Print all results."""
    signals, workers = (int(word) for word in (sys.argv[1:] + ["1024", "2"][len(sys.argv) - 1 :]))
    planning()
    building(signals, workers)
    stages()


def planning() -> None:
    """Time of loading a recipe of 100 000 signals and drawing its last one."""
    from rotorwise.datasets.recipe_file import recipe_from_json

    source = json.dumps({**json.loads(load_recipe(RECIPE).source), "draws": 87}, sort_keys=True)
    begun = time.process_time()
    recipe = recipe_from_json(source)
    parts = Parts(recipe)
    draw_signal(recipe, position_of(recipe, recipe.signals - 1))
    print(f"plan of {recipe.signals} signals in {parts.count} parts: {time.process_time() - begun:.2f} s CPU")


def building(signals: int, workers: int) -> None:
    """Rate and memory of a build by processes."""
    marks: list[tuple[float, int]] = []

    def tell(now: Progress) -> None:
        marks.append((time.perf_counter(), now.signals))

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        store = build(RECIPE, Path(folder) / "set", workers=workers, limit=signals, tell=tell)
        wall = time.perf_counter() - begun
        found = summary_of(store)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    (first, at_first), (last, at_last) = marks[1], marks[-1]
    print(f"{found['rows']} signals, {len(found['refused'])} refused, {found['bytes'] / 1e6:.0f} MB, {workers} workers")
    print(f"all included: {wall:.1f} s wall, {found['rows'] / wall:.1f} a second; workers' CPU {cpu:.1f} s")
    print(f"after the first part: {(at_last - at_first) / (last - first):.1f} a second")
    print(f"largest memory: {own:.0f} MiB in the parent, {after.ru_maxrss / 1024:.0f} MiB in a worker")


def stages() -> None:
    """CPU time of one part in this process, by stage."""
    recipe = load_recipe(RECIPE)
    generate_part.warm_up(recipe.source)
    spent: dict[str, float] = {}
    patches = [mock.patch.object(generate_part, name, timed(name, spent)) for name in (
        "draw_signal", "_motions", "measured", "parquet_bytes"
    )]  # fmt: skip
    best: dict[str, float] = {}
    for _ in range(3):
        spent.clear()
        for patch in patches:
            patch.start()
        begun = time.process_time()
        part = generate_part.make_part(recipe.source, 1)
        total = time.process_time() - begun
        for patch in patches:
            patch.stop()
        if not best or total < best["total"]:
            best = {**spent, "total": total}
    words = {"draw_signal": "drawing", "_motions": "stepping", "measured": "chain", "parquet_bytes": "compression"}
    shares = ", ".join(f"{words.get(name, name)} {1e3 * s / part.facts['rows']:.1f}" for name, s in best.items())
    print(f"ms CPU a signal, best of 3: {shares}")


def timed(name: str, spent: dict[str, float]) -> Callable[..., Any]:
    """Return the function of `generate_part`, its CPU time added up."""
    function = getattr(generate_part, name)

    def measured(*words: Any, **options: Any) -> Any:
        begun = time.process_time()
        try:
            return function(*words, **options)
        finally:
            spent[name] = spent.get(name, 0.0) + time.process_time() - begun

    return measured


if __name__ == "__main__":
    main()
