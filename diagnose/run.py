"""What ``rotorwise analyse`` does: every file in turn, one answer each, a bad file never stops the others."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from ..datasets.metadata import Metadata
from ..datasets.reading import find_recordings
from ..datasets.recording import Channel, OperatingCondition
from ..datasets.units import parse_sensitivity, require_unit
from ..simulators.errors import RotorwiseError
from .pictures import for_folder
from .pipeline import Baseline, analyse, read_baseline
from .result import Analysis
from .zones.table import find_table

_DONE, _USAGE, _FILE_FAILED, _OUTPUT_FAILED = 0, 2, 3, 4
_MANY_FILES = 8
_QUIET_SECONDS = 2.0


@dataclass(frozen=True)
class Request:
    """What the user asked for."""

    files: tuple[Path, ...]
    metadata: Metadata
    sidecar: Path | None = None
    baseline: tuple[Path, ...] = ()
    report: Path | None = None
    as_json: bool = False
    recursive: bool = False
    force: bool = False
    files_in_full: int = 3


def run(request: Request) -> int:
    """Analyse, print, write the report; return the exit code."""
    if request.report is not None:
        from .report.write import check_free

        try:
            # Before the work, not after: nobody wants to wait for a refusal.
            check_free(request.report, force=request.force)
        except RotorwiseError as problem:
            return _say(problem, _OUTPUT_FAILED)
    try:
        _check_options(request.metadata)
    except RotorwiseError as problem:
        return _say(problem, _USAGE)
    try:
        paths, left_out = find_recordings(request.files, recursive=request.recursive)
        baselines = [
            read_baseline(one, metadata=request.metadata, sidecar=request.sidecar) for one in _baselines(request)
        ]
    except (RotorwiseError, OSError) as problem:
        return _say(problem, _FILE_FAILED)
    for path in left_out:
        print(f"rotorwise: {path}: left out, no reader knows it or it cannot be opened.", file=sys.stderr)
    if not paths:
        print("rotorwise: no recording found. Name files, or pass --recursive for sub-folders.", file=sys.stderr)
        return _FILE_FAILED
    analyses, failed = _analyse_all(request, paths, baselines)
    _print(request, analyses)
    code = _FILE_FAILED if failed else _DONE
    if request.report is not None and analyses:
        code = _write_report(request, analyses) or code
    return code


def _check_options(metadata: Metadata) -> None:
    """Find wrong options before any file is read."""
    OperatingCondition(metadata.speed_rpm)
    for unit in filter(None, metadata.units):
        require_unit(unit)
    for text in filter(None, metadata.sensitivities):
        parse_sensitivity(text)
    for direction in filter(None, metadata.directions):
        Channel("option", direction=direction)
    plate = metadata.nameplate
    if metadata.severity_table:
        find_table(metadata.severity_table, mounting=plate.mounting, power_kw=plate.power_kw)


def _baselines(request: Request) -> list[Path]:
    return find_recordings(request.baseline, recursive=request.recursive)[0] if request.baseline else []


def _analyse_all(request: Request, paths: list[Path], baselines: list[Baseline]) -> tuple[list[Analysis], int]:
    analyses: list[Analysis] = []
    failed = 0
    with _progress(len(paths)) as tell:
        for index, path in enumerate(paths):
            try:
                analysis = analyse(
                    path,
                    metadata=request.metadata,
                    sidecar=request.sidecar,
                    baseline=baselines,
                    progress=lambda done, total, at=index, name=path.name: tell(at, name, done, total),
                )
            except RotorwiseError as problem:
                failed += 1
                message = str(problem)
                print(f"rotorwise: {message if str(path) in message else f'{path}: {message}'}", file=sys.stderr)
                continue
            except (ArithmeticError, AttributeError, LookupError, MemoryError, OSError, TypeError, ValueError) as bug:
                # One file that we do not handle must not cost the answers on all the others.
                if os.environ.get("ROTORWISE_DEBUG"):
                    raise
                failed += 1
                what = f"{type(bug).__name__}: {bug}".strip()[:200]
                print(
                    f"rotorwise: {path}: not analysed, a mistake of rotorwise ({what}). Please report it; "
                    "ROTORWISE_DEBUG=1 shows where.",
                    file=sys.stderr,
                )
                continue
            if request.report is None:
                analysis = replace(analysis, pictures=replace(for_folder(analysis.pictures), spectra=(), envelopes=()))
            elif len(paths) > _MANY_FILES:
                analysis = replace(analysis, pictures=for_folder(analysis.pictures))
            analyses.append(analysis)
            tell(index + 1, path.name, 0, None)
    return analyses, failed


Tell = Callable[[int, str, int, int | None], None]


@contextmanager
def _progress(files: int) -> Iterator[Tell]:
    """Yield a function that shows progress on a terminal once the work has taken two seconds."""
    if not sys.stderr.isatty():
        yield lambda index, name, done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    task = bar.add_task("", total=float(files))
    begun = time.monotonic()
    shown = False

    def tell(index: int, name: str, done: int, total: int | None) -> None:
        nonlocal shown
        if not shown and time.monotonic() - begun > _QUIET_SECONDS:
            bar.start()
            shown = True
        part = min(done / total, 1.0) if total else 0.0
        bar.update(task, completed=index + part, description=name[:40])

    try:
        yield tell
    finally:
        if shown:
            bar.stop()


def _print(request: Request, analyses: list[Analysis]) -> None:
    if request.as_json:
        from .json_output import as_json

        print(json.dumps([as_json(analysis) for analysis in analyses], indent=2))
        return
    from rich.console import Console

    from .terminal import show, show_overview

    console = Console(highlight=False)
    if len(analyses) <= request.files_in_full:
        for analysis in analyses:
            show(analysis, console)
    else:
        show_overview(analyses, console)


def _write_report(request: Request, analyses: list[Analysis]) -> int:
    from .report import write_report

    assert request.report is not None
    try:
        write_report(analyses, request.report, force=request.force)
    except RotorwiseError as problem:
        return _say(problem, _OUTPUT_FAILED)
    print(f"report: {request.report}", file=sys.stderr if request.as_json else sys.stdout)
    return _DONE


def _say(problem: Exception, code: int) -> int:
    print(f"rotorwise: {problem}", file=sys.stderr)
    return code
