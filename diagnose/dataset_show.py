"""What ``rotorwise dataset`` shows on the terminal: progress, what was built, what is there."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..datasets.generate import Progress
    from ..datasets.recipe import Recipe

#: Without a terminal, a line every so many seconds.
_EVERY_S = 10.0
_MOST_REASONS = 5


@contextmanager
def building(recipe: Recipe) -> Iterator[Callable[[Progress], None]]:
    """Give what shows the progress: a bar on a terminal, else a line now and then; both with rate and time left."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
    from rich.progress import Progress as Bar

    begun = time.monotonic()
    columns = TextColumn(recipe.name), BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}")
    console = Console(stderr=True)
    with Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("starting", total=None)
        last = begun

        def tell(now: Progress) -> None:
            nonlocal last
            seconds = time.monotonic() - begun
            text = pace(now, seconds)
            bar.update(task, completed=now.signals, total=now.wanted, description=text)
            due = time.monotonic() - last > _EVERY_S or now.signals in (now.at_start, now.wanted)
            if due and not bar.console.is_terminal:
                last = time.monotonic()
                print(f"rotorwise: {now.signals} of {now.wanted} signals, {text}", file=sys.stderr, flush=True)

        yield tell


def pace(now: Progress, seconds: float) -> str:
    """Return rate and time left in words.

    Examples
    --------
    >>> from rotorwise.datasets.generate import Progress
    >>> pace(Progress(signals=30, wanted=90, refused=1, at_start=10), 2.0)
    '10.0 a second, 6 s left, 1 refused'
    """
    done = now.signals - now.at_start
    refused = f", {now.refused} refused" if now.refused else ""
    if now.signals >= now.wanted:
        rate = f"{done / seconds:.1f} a second" if done and seconds > 0 else "nothing left to build"
        return rate + refused
    if not done:
        return "starting" + (f", {now.at_start} are there" if now.at_start else "") + refused
    rate = done / seconds
    return f"{rate:.1f} a second, {duration((now.wanted - now.signals) / rate)} left{refused}"


def duration(seconds: float) -> str:
    """Return a duration in the two units that matter.

    Examples
    --------
    >>> duration(59.4), duration(125), duration(7300), duration(200000)
    ('59 s', '2 min 5 s', '2 h 1 min', '2 d 7 h')
    """
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    if whole < 86400:
        return f"{whole // 3600} h {whole % 3600 // 60} min"
    return f"{whole // 86400} d {whole % 86400 // 3600} h"


def show_built(location: str, found: Mapping[str, Any]) -> None:
    """Say what is there after a build."""
    print(f"{location}: {_state(found)}")
    _show_refused(found["refused"])
    if found["unreadable"]:
        print(f"not read: {_unread(found['unreadable'])}")
    print(f"data: {location}/data/*.parquet, described in {location}/card.md")


def show_info(location: str, found: Mapping[str, Any]) -> None:
    """Say what a dataset holds."""
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, markup=False)
    console.print(f"{found['name']}: {_state(found)}", soft_wrap=True)
    if found["meaning"]:
        console.print(found["meaning"])
    table = Table(box=None, padding=(0, 2, 0, 0))
    splits = sorted({row[2] for row in found["counts"]})
    for heading in ("machine", "case", *splits):
        table.add_column(heading, justify="right" if heading in splits else "left")
    counts = {(machine, case, split): number for machine, case, split, number in found["counts"]}
    for machine, case in dict.fromkeys((row[0], row[1]) for row in found["counts"]):
        table.add_row(machine, case, *(str(counts.get((machine, case, split), 0)) for split in splits))
    console.print(table)
    for word, text in _facts(location, found):
        console.print(f"{word:9} {text}", soft_wrap=True)
    _show_refused(found["refused"])


def _facts(location: str, found: Mapping[str, Any]) -> list[tuple[str, str]]:
    channels = ", ".join(f"{name} ({unit})" if unit else name for name, unit in found["channels"].items())
    versions = ", ".join(f"{name} {' and '.join(texts)}" for name, texts in found["versions"].items())
    facts = [
        ("channels", channels),
        ("size", f"{found['bytes'] / 1e6:.1f} MB in {found['parts']} of {found['parts_wanted']} parts"),
        ("seed", f"{found['seed']}, fingerprint {found['fingerprint']}"),
        ("made with", versions),
        ("files", f"{location}/data/*.parquet, described in {location}/card.md"),
    ]
    if found["unreadable"]:
        facts.append(("not read", _unread(found["unreadable"])))
    return [fact for fact in facts if fact[1]]


def _unread(names: Sequence[str]) -> str:
    more = f" and {len(names) - 5} more" if len(names) > 5 else ""
    return (
        ", ".join(names[:5]) + f"{more}: no whole parts of this dataset. Build again; then remove what is still named "
        "here, as programs that read data/*.parquet take it for a part"
    )


def _state(found: Mapping[str, Any]) -> str:
    refused = f", {len(found['refused'])} draws refused" if found["refused"] else ""
    missing = found["signals_wanted"] - found["signals"]
    return f"{found['rows']} signals{refused}, " + (f"{missing} to be built" if missing > 0 else "complete")


def _show_refused(refused: Sequence[Mapping[str, Any]]) -> None:
    for one in refused[:_MOST_REASONS]:
        print(f"refused   signal {one['signal']} ({one['group']}, {one['case']}): {one['reason']}")
    if len(refused) > _MOST_REASONS:
        print(f"refused   {len(refused) - _MOST_REASONS} more, in manifest.json")


def show_recipes(found: Sequence[Mapping[str, Any]]) -> None:
    """List recipes."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("recipe", "signals", "machines", "what"):
        table.add_column(heading, justify="right" if heading == "signals" else "left", no_wrap=heading == "recipe")
    for one in found:
        table.add_row(one["name"], str(one["signals"]), ", ".join(one["machines"]), one["meaning"])
    Console(highlight=False, markup=False).print(table)
