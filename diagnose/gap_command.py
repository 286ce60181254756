"""``rotorwise gap``: what a simulated machine gets wrong about measured recordings, and why."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from . import cli_options as options
from .cli_options import option

if TYPE_CHECKING:
    from ..datasets.metadata import Metadata
    from ..datasets.recording import Recording
    from ..simulators.machine import Machine
    from .gap.campaign import ReadCampaign, Sources
    from .gap.result import GapResult

_DONE, _BUG, _USAGE, _FILE_FAILED, _OUTPUT_FAILED = 0, 1, 2, 3, 4
#: Without a terminal, what is being done is told this often.
_TOLD_EVERY_S, _QUIET_S = 10.0, 2.0

Files = Annotated[
    list[Path],
    typer.Argument(
        help="Folder of recordings at several speeds or loads, or the recordings.",
        metavar="CAMPAIGN...",
        show_default=False,
    ),
]
MachineName = Annotated[
    str, option("--machine", value="NAME|FILE.toml", text="The machine: a shipped one, or a machine file.")
]
Preset = Annotated[str, option("--preset", value="NAME", text="Preset; what a machine file states goes before it.")]
Settings = Annotated[
    list[str] | None, option("--set", value="NAME=VALUE", text="Parameter of the machine, SI units; repeat.")
]
Baseline = Annotated[
    list[Path] | None,
    option(
        "--baseline",
        value="FILE|FOLDER",
        text="Recordings of the healthy machine; the sub-folder baseline when left out; repeat.",
    ),
]
Probes = Annotated[
    list[str] | None,
    option("--probe", value="CHANNEL=PROBE", text="Which channel, by name or number, is which probe; repeat."),
]
Loads = Annotated[
    list[str] | None,
    option("--load", value="[PATTERN=]VALUE", text="Load in the machine's unit, of all files or those named; repeat."),
]
Without = Annotated[
    list[str] | None, option("--without", value="EFFECT", text="Effect that is not to be considered; repeat.")
]
AsGiven = Annotated[bool, option("--as-given", text="Do not add what healthy recordings say that the model lacks.")]
Output = Annotated[
    Path | None, option("--output", "-o", value="FILE.toml", text="Write the extended machine here; it simulates.")
]
AsJson = Annotated[bool, option("--json", text="Print JSON.")]
Check = Annotated[bool, option("--check", text="Only read: print speeds, loads and which channel is which probe.")]
Force = Annotated[bool, option("--force", text="Replace an earlier report or extended machine.")]


@dataclass(frozen=True)
class Work:
    """What is to be done, checked as far as possible before any file is read."""

    machine: Machine
    sources: Sources
    metadata: Metadata
    sidecar: Path | None
    probes: tuple[str, ...]
    loads: tuple[str, ...]
    without: frozenset[str]
    as_given: bool


def gap(
    files: Files,
    machine: MachineName,
    preset: Preset = "",
    settings: Settings = None,
    baseline: Baseline = None,
    probes: Probes = None,
    loads: Loads = None,
    rate: options.Rate = None,
    unit: options.Unit = None,
    sensitivity: options.Sensitivity = None,
    channel_name: options.ChannelName = None,
    direction: options.Direction = None,
    skip: options.Skip = None,
    speed: options.Speed = None,
    tacho: options.Tacho = None,
    pulses_per_revolution: options.Pulses = None,
    sidecar: options.Sidecar = None,
    without: Without = None,
    as_given: AsGiven = False,
    report: options.Report = None,
    output: Output = None,
    check: Check = False,
    as_json: AsJson = False,
    force: Force = False,
) -> None:
    """Show what a simulated machine gets wrong about recordings, name the cause, extend the machine.

    What a file lacks comes from these options or from a recording.toml beside it.
    """
    from .gap.asked import known_effects

    try:
        if check and (report or output):
            raise InvalidValueError(
                f"--check only reads; allowed: no {'--report' if report else '--output'} beside it. Leave it out."
            )
        record = options.record_metadata(rate, speed, tacho, pulses_per_revolution)
        channels = options.channel_metadata(unit, sensitivity, channel_name, direction, skip)
        work = Work(
            machine=_machine(machine, preset, settings or []),
            sources=_sources(files, baseline or []),
            metadata=record.merged_over(channels),
            sidecar=sidecar,
            probes=tuple(probes or ()),
            loads=tuple(loads or ()),
            without=known_effects(without or [], "--without"),
            as_given=as_given,
        )
    except RotorwiseError as problem:
        raise _leave(problem, _USAGE) from None
    if check:
        taken = _checked(work, as_json=as_json)
    else:
        taken, _ = run(work, machine, report=report, output=output, as_json=as_json, force=force)
    if taken.unreadable:
        raise typer.Exit(_FILE_FAILED)


def run(
    work: Work, machine: str, *, report: Path | None, output: Path | None, as_json: bool, force: bool
) -> tuple[ReadCampaign, GapResult]:
    """Explain the gap, print the answer and write the files; ``machine`` is what the user called it.

    Raises
    ------
    typer.Exit
        With a message printed, when there is no answer or a file cannot be written.
    """
    try:
        _check_places(work, report, output, machine, force=force)
    except RotorwiseError as problem:
        raise _leave(problem, _OUTPUT_FAILED) from None
    taken, result = _worked(work)
    _print(taken, result, as_json=as_json)
    _write(work, taken, result, report, output, force=force, quiet=as_json)
    return taken, result


def _machine(name: str, preset: str, settings: list[str]) -> Machine:
    from .simulate_options import parse_machine

    return parse_machine(name, preset=preset, settings=settings, load=None)


def _sources(files: list[Path], baseline: list[Path]) -> Sources:
    from .gap.campaign import find_sources

    return find_sources(files, baseline=baseline)


def _check_places(work: Work, report: Path | None, output: Path | None, machine: str, *, force: bool) -> None:
    """Find places that cannot be written to before the work: nobody wants to wait for a refusal."""
    if report is not None:
        from .report.write import check_free

        check_free(report.resolve(), force=force)
    if output is not None:
        from .gap.extended_file import check_extended_place

        recordings = (*work.sources.recordings, *work.sources.baseline)
        check_extended_place(output, force=force, recordings=recordings, machine=machine)


def _checked(work: Work, *, as_json: bool) -> ReadCampaign:
    """Read the files, print what was understood of them, and explain nothing."""
    from .gap.campaign_table import campaign_data, show_campaign

    with _progress() as tell:
        taken = _read(work, tell)
    if as_json:
        print(json.dumps(campaign_data(taken), indent=2))
        return taken
    from rich.console import Console

    show_campaign(taken, Console(highlight=False))
    return taken


def _read(work: Work, tell: Callable[[str], None]) -> ReadCampaign:
    from .gap.campaign import read_campaign
    from .gap.campaign_table import lacking_words
    from .gap.observe import shaft_speed_rpm
    from .gap.stable import unstable_words

    try:
        taken = read_campaign(
            work.sources,
            work.machine,
            metadata=work.metadata,
            sidecar=work.sidecar,
            probes=work.probes,
            loads=work.loads,
            tell=tell,
        )
    except RotorwiseError as problem:
        raise _leave(problem, _USAGE if isinstance(problem, InvalidValueError) else _FILE_FAILED) from None
    for message in taken.unreadable:
        print(f"rotorwise: left out: {message}", file=sys.stderr)
    speeds = [shaft_speed_rpm(one) for one in taken.campaign.recordings]
    return replace(taken, notes=(*taken.notes, *lacking_words(taken), *unstable_words(work.machine, speeds)))


def _worked(work: Work) -> tuple[ReadCampaign, GapResult]:
    from ..simulators.solvers.blas import single_blas_thread
    from .gap import explain
    from .gap.campaign_table import ONE_SPEED, read_words

    with _progress() as tell:
        taken = _read(work, tell)
        print(f"rotorwise: {read_words(taken)}", file=sys.stderr, flush=True)
        try:
            explained = single_blas_thread(explain.explain_gap)
            options = {"without": work.without, "as_given": work.as_given}
            result = explained(taken.campaign, work.machine, **options, tell=tell)
            # What to record next is computed then, and may be a place instead of a speed.
            notes = [note for note in taken.notes if note != ONE_SPEED or not result.next_measurement]
            return replace(taken, notes=tuple(notes)), result
        except RotorwiseError as problem:
            raise _leave(problem, _FILE_FAILED) from None
        except (ArithmeticError, AttributeError, LookupError, MemoryError, TypeError, ValueError) as bug:
            if os.environ.get("ROTORWISE_DEBUG"):
                raise
            what = f"{type(bug).__name__}: {bug}".strip()[:200]
            message = (
                f"not explained, a mistake of rotorwise ({what}). Please report it; ROTORWISE_DEBUG=1 shows where."
            )
            raise _leave(message, _BUG) from None


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """Yield a function that tells on stderr what is being done, once it has taken two seconds."""
    begun = told = time.monotonic()
    if not sys.stderr.isatty():

        def say(what: str) -> None:
            nonlocal told
            now = time.monotonic()
            if now - begun > _QUIET_S and (now - told > _TOLD_EVERY_S or told == begun):
                told = now
                print(f"rotorwise: {what} ({now - begun:.0f} s) ...", file=sys.stderr, flush=True)

        yield say
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn()
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task("")
    shown = False

    def tell(what: str) -> None:
        nonlocal shown
        bar.update(task, description=what[:60])
        if not shown and time.monotonic() - begun > _QUIET_S:
            shown = True
            bar.start()

    try:
        yield tell
    finally:
        if shown:
            bar.stop()


def _print(taken: ReadCampaign, result: GapResult, *, as_json: bool) -> None:
    if as_json:
        from .gap.json_form import as_json as formed

        content: dict[str, Any] = {**formed(result), "notes": list(taken.notes), "unreadable": list(taken.unreadable)}
        print(json.dumps(content, indent=2))
        return
    from rich.console import Console

    from .gap.terminal import show

    show(result, Console(highlight=False), notes=taken.notes)


def _write(
    work: Work,
    taken: ReadCampaign,
    result: GapResult,
    report: Path | None,
    output: Path | None,
    *,
    force: bool,
    quiet: bool,
) -> None:
    to = sys.stderr if quiet else sys.stdout
    try:
        if output is not None:
            from .gap.extended_file import write_extended

            recordings, healthy = (_paths(one) for one in (taken.campaign.recordings, taken.campaign.baseline))
            write_extended(result, output, force=force, recordings=recordings, healthy=healthy, notes=taken.notes)
            what = "extended machine" if result.causes or result.empirical else "calibrated machine, nothing added"
            print(f"{what}: {output}", file=to)
        if report is not None:
            from .report.gap_page import write_gap_page

            notes = (*taken.notes, *taken.unreadable)
            write_gap_page(result, report, title=taken.campaign.name or "", notes=notes, force=force)
            print(f"report: {report}", file=to)
    except RotorwiseError as problem:
        raise _leave(problem, _OUTPUT_FAILED) from None


def _paths(recordings: Sequence[Recording]) -> list[Path]:
    return [Path(one.provenance.path or "") for one in recordings]


def _leave(problem: object, code: int) -> typer.Exit:
    print(f"rotorwise: {problem}", file=sys.stderr)
    return typer.Exit(code)
