"""What ``rotorwise papers`` does: compute what the source papers claim, say what comes out, write it where asked."""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from .cli_options import option

if TYPE_CHECKING:
    from rich.console import Console

    from ..simulators.papers.claim import Claim

_DONE, _USAGE, _OUTPUT_FAILED = 0, 2, 4
#: Titles as short as a heading needs them.
TITLES = {
    "000": "Magnetic-bearing rotor with a misaligned coupling",
    "001": "Bearings, rotors and gears behind a misaligned coupling",
    "002": "Rigidly coupled, misaligned rotors",
}
_COLOURS = {
    "reproduced": "green",
    "partly": "yellow",
    "only with an extra effect": "cyan",
    "not reproduced": "red",
    "cannot be checked": "dim",
}

Names = Annotated[
    list[str] | None, typer.Argument(help="000, 001, 002; all when left out.", metavar="[PAPER]...", show_default=False)
]
AsJson = Annotated[bool, option("--json", text="Print JSON: a list with one object a claim.")]
Report = Annotated[Path | None, option("--report", value="FILE", text="Write an HTML page with the curves here.")]
Table = Annotated[
    Path | None, option("--table", value="FILE", text="Write a Markdown table here, between two marker lines.")
]
Force = Annotated[bool, option("--force", text="Replace an existing HTML page.")]


def papers(
    names: Names = None, as_json: AsJson = False, report: Report = None, table: Table = None, force: Force = False
) -> None:
    """Compute anew what the simulators' source papers claim; takes about two minutes."""
    raise typer.Exit(run(names or [], as_json=as_json, report=report, table=table, force=force))


def run(names: Sequence[str], *, as_json: bool, report: Path | None, table: Path | None, force: bool) -> int:
    """Compute the claims of the named papers (all for none), print them, write the files; return the exit code."""
    from .papers_files import check_table, write_table
    from .report.write import check_free

    try:
        chosen = choose(names)
    except RotorwiseError as problem:
        return _say(problem, _USAGE)
    try:
        # Before the work, not after: nobody wants to wait two minutes for a refusal.
        if report is not None:
            check_free(report, force=force)
        if table is not None:
            check_table(table)
    except RotorwiseError as problem:
        return _say(problem, _OUTPUT_FAILED)
    claims = compute(chosen)
    if as_json:
        print(json.dumps([asdict(claim) for claim in claims], indent=2))
    else:
        from rich.console import Console

        show(claims, Console(highlight=False))
    told = sys.stderr if as_json else sys.stdout
    try:
        if table is not None:
            write_table(claims, table)
            print(f"table: {table}", file=told)
        if report is not None:
            from .report.papers_page import write_page

            with _progress() as tell:
                tell("curves of the report")
                write_page(claims, report, force=force)
            print(f"report: {report}", file=told)
    except RotorwiseError as problem:
        return _say(problem, _OUTPUT_FAILED)
    return _DONE


def choose(names: Sequence[str]) -> list[str]:
    """Return the numbers of the papers asked for, in order and once each; all when none is named.

    Raises
    ------
    InvalidValueError
        For a number that no paper has.
    """
    from ..simulators.papers.claim import paper_modules

    known = [module.removeprefix("paper_") for module in paper_modules()]
    asked = {name.strip().removeprefix("paper_").zfill(3) for name in names}
    for name in sorted(asked - set(known)):
        raise InvalidValueError(f"Paper {name!r} is unknown; allowed: {', '.join(known)}. Correct the number.")
    return [number for number in known if not asked or number in asked]


def compute(numbers: Sequence[str]) -> list[Claim]:
    """Return the claims of these papers, computed one paper after the other."""
    from importlib import import_module

    found: list[Claim] = []
    with _progress() as tell:
        for done, number in enumerate(numbers):
            tell(f"paper {number} ({done + 1} of {len(numbers)})")
            found += import_module(f"...simulators.papers.paper_{number}", f"{__package__}.papers").claims()
    return found


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """Yield a function that says on stderr what is being computed; on a terminal, with the seconds it has taken."""
    if not sys.stderr.isatty():
        yield lambda what: print(f"rotorwise: computing {what}", file=sys.stderr, flush=True)
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = SpinnerColumn(), TextColumn("computing {task.description}"), TimeElapsedColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("")
        yield lambda what: bar.update(task, description=what)


def rows(claim: Claim) -> list[tuple[str, str]]:
    """Return what there is to say of a claim as (label, text), without the empty ones."""
    named = (
        ("paper says", claim.says),
        ("as printed", claim.as_printed),
        ("corrected", claim.corrected),
        ("extra effect", claim.with_effect),
    )
    return [(label, text) for label, text in named if text]


def count(claims: Sequence[Claim]) -> str:
    """Return how many claims have each verdict, in words."""
    from ..simulators.papers.claim import VERDICTS

    seen = Counter(claim.verdict for claim in claims)
    parts = ", ".join(f"{seen[verdict]} {verdict}" for verdict in VERDICTS if seen[verdict])
    return f"{len(claims)} claims: {parts}."


def show(claims: Sequence[Claim], console: Console) -> None:
    """Print one block a claim and the count at the end; fits 80 columns."""
    from rich.markup import escape
    from rich.table import Table as Grid

    paper = ""
    for claim in claims:
        if claim.paper != paper:
            paper = claim.paper
            console.print(f"\n[bold underline]Paper {paper}: {TITLES.get(paper, '')}[/]")
        colour = _COLOURS.get(claim.verdict, "white")
        console.print(f"\n[bold]{escape(claim.place)}[/]  [{colour}]{claim.verdict}[/]")
        grid = Grid(box=None, show_header=False, padding=(0, 2, 0, 0), show_edge=False)
        grid.add_column(style="dim", no_wrap=True, min_width=12)
        grid.add_column(ratio=1)
        for label, text in rows(claim):
            grid.add_row(label, escape(text))
        console.print(grid)
    console.print(f"\n[bold]{count(claims)}[/]")


def _say(problem: Exception, code: int) -> int:
    print(f"rotorwise: {problem}", file=sys.stderr)
    return code
