"""The demonstration: recordings of a rotor whose fault is sealed, explained, and then compared with the truth.

The recordings are shipped with rotorwise (`demo_campaign` makes them); the engine reads those and nothing else.
"""

from __future__ import annotations

import shutil
import tomllib
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from .demo_files import DemoFolderError, prepare_folder, unwritable

if TYPE_CHECKING:
    from .gap.result import Cause, GapResult

__all__ = ["DemoFolderError", "run_demo", "run_pump", "write_demo"]

MACHINE = "amb_rotor"
CAMPAIGN, SEALED, REPORT, EXTENDED = "campaign", "sealed.toml", "report.html", "extended.toml"
# A name that is no module's, or the installer takes the folder for a package.
_SHIPPED = files(__package__ or "rotorwise.diagnose") / "demo-data"
_FILE_FAILED = 3


def run_demo(folder: Path, *, force: bool) -> int:
    """Write the recordings into a folder, explain them, show the truth beside the answer; return the exit code.

    Raises
    ------
    DemoFolderError
        When the folder cannot be written to, or holds files that are not of an earlier demonstration.
    """
    campaign = write_demo(folder, force=force)
    from ..datasets.metadata import Metadata
    from ..simulators.machine import find_machine
    from .gap.campaign import find_sources
    from .gap_command import Work, run

    work = Work(
        machine=find_machine(MACHINE),
        sources=find_sources([campaign]),
        metadata=Metadata(),
        sidecar=None,
        probes=(),
        loads=(),
        without=frozenset(),
        as_given=False,
    )
    taken, result = run(work, MACHINE, report=folder / REPORT, output=folder / EXTENDED, as_json=False, force=force)
    _show_truth(folder / SEALED, result)
    return _FILE_FAILED if taken.unreadable else 0


def write_demo(folder: Path, *, force: bool) -> Path:
    """Copy the shipped recordings and the sealed truth into a folder and return the campaign's folder.

    Parameters
    ----------
    folder : Path
        Made when missing.
    force : bool
        Whether files of an earlier demonstration may be replaced.

    Raises
    ------
    DemoFolderError
        See `run_demo`.
    """
    shipped = Path(str(_SHIPPED))
    names = sorted(str(one.relative_to(shipped)) for one in shipped.rglob("*") if one.is_file())
    head = (shipped / SEALED).read_text(encoding="utf-8").splitlines()[0]
    prepare_folder(folder, [*names, REPORT, EXTENDED], mark=SEALED, head=head, force=force)
    try:
        for name in names:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(shipped / name, folder / name)
    except OSError as problem:
        raise unwritable(folder, problem) from problem
    return folder / CAMPAIGN


def run_pump(folder: Path, *, force: bool) -> int:
    """Make recordings of a pump with three faults, diagnose each, write the report; return the exit code."""
    from ..datasets.metadata import Metadata
    from .demo_pump import write_pump
    from .run import Request, run

    recordings = write_pump(folder, force=force)
    request = Request(
        files=tuple(recordings[1:]),
        metadata=Metadata(),
        baseline=(recordings[0],),
        report=folder / REPORT,
        force=force,
        files_in_full=3,
    )
    return run(request)


def _show_truth(sealed: Path, result: GapResult) -> None:
    from rich.console import Console
    from rich.table import Table

    from .terminal import escape

    truth = tomllib.loads(sealed.read_text(encoding="utf-8"))
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False)
    for heading in ("", "truth", "found"):
        table.add_column(heading)
    effect = str(truth["effect"])
    cause = next((one for one in result.causes if one.effect == effect), None)
    table.add_row("effect", effect, cause.effect if cause else "-")
    for name, value in truth["parameters"].items():
        table.add_row(*(escape(text) for text in _beside(name, float(value), cause)))
    console = Console(highlight=False)
    console.print(f"truth: {escape(str(sealed))}, not read until now", soft_wrap=True)
    console.print()
    console.print(table)


def _beside(name: str, value: float, cause: Cause | None) -> tuple[str, str, str]:
    """Return a parameter's name, its true value and its estimate, in the estimate's unit."""
    from .gap.words import estimate_words, parameter_label, value_words

    found = cause.parameters.get(name) if cause else None
    if found is None:
        return name, f"{value:.4g}", "-"
    return parameter_label(name, found.unit), value_words(value, found), estimate_words(found)
