"""Reports as files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ...simulators.errors import RotorwiseError
from ..output_file import OutputKind, check_place, write_checked
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
    check_free(Path(path), force=force)
    write_checked(Path(path), render_report(analyses, title=title).encode(), _KIND, force=force)


def check_free(target: Path, *, force: bool) -> None:
    """Raise ReportFileError when a report cannot go here: a folder, a missing folder, or an existing file."""
    check_place(target, _KIND, force=force)


def _is_page(target: Path) -> bool:
    with target.open("rb") as file:
        head = file.read(512)
    return head.lstrip().lower().startswith((b"<!doctype html", b"<html"))


_KIND = OutputKind(name="report", content="HTML page", example="report.html", is_ours=_is_page, error=ReportFileError)
