"""Reports as files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ...simulators.errors import RotorwiseError
from ..result import Analysis
from .page import render_report


class ReportFileError(RotorwiseError):
    """A report cannot be written where it was asked for."""


def write_report(
    analyses: Sequence[Analysis],
    path: str | os.PathLike[str],
    *,
    title: str | None = None,
    force: bool = False,
) -> None:
    """Write a report as one HTML file that needs no network.

    The page is written beside its destination and then renamed, so a report is whole or absent.

    Parameters
    ----------
    analyses : sequence of Analysis
        See ``render_report``.
    path : str or PathLike
        Its folder must exist.
    title : str, optional
        See ``render_report``.
    force : bool
        Whether an existing file may be replaced.

    Raises
    ------
    ReportFileError
        When the file exists and ``force`` is not set, or the place cannot be written to.
    InvalidValueError, MissingAssetError
        See ``render_report``.
    """
    # A link is followed, so that it stays a link.
    target = Path(path).resolve()
    check_free(target, force=force)
    page = render_report(analyses, title=title)
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        draft.write_text(page, encoding="utf-8", newline="\n")
        # Rendering may have taken a while; somebody else's report of the meantime is not to be lost either.
        check_free(target, force=force)
        draft.replace(target)
    except OSError as problem:
        raise ReportFileError(
            f"Report {target} cannot be written: {problem.strerror or problem}. Choose another place."
        ) from problem
    finally:
        draft.unlink(missing_ok=True)


def check_free(target: Path, *, force: bool) -> None:
    """Raise ReportFileError when a report cannot go here: a folder, a missing folder, or an existing file."""
    try:
        exists = target.exists()
    except OSError as problem:
        raise ReportFileError(f"Report {target}: {problem.strerror or problem}. Choose another name.") from problem
    if target.is_dir():
        raise ReportFileError(
            f"Report {target} is a folder; allowed: a file. Add a file name, for example report.html."
        )
    if not target.parent.is_dir():
        raise ReportFileError(f"Folder {target.parent} of report {target.name} does not exist. Make it first.")
    if exists and not target.is_file():
        raise ReportFileError(f"Report {target} is no regular file. Choose another name.")
    if exists and not force:
        raise ReportFileError(f"Report {target} exists already. Choose another name, or allow overwriting (--force).")
    if exists and not _is_page(target):
        raise ReportFileError(
            f"{target} exists and is no HTML page: a report never replaces other data. Choose another name."
        )


def _is_page(target: Path) -> bool:
    try:
        with target.open("rb") as file:
            head = file.read(512)
    except OSError:
        return False
    return head.lstrip().lower().startswith((b"<!doctype html", b"<html"))
