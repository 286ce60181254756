"""The folder that a demonstration writes into: files of somebody else's in it stay as they are."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..simulators.errors import RotorwiseError


class DemoFolderError(RotorwiseError):
    """The demonstration cannot be written where it was asked for."""


def prepare_folder(folder: Path, names: Sequence[str], *, mark: str, head: str, force: bool) -> None:
    """Make a folder ready for a demonstration, or say why it cannot be.

    Parameters
    ----------
    folder : Path
        Made when missing.
    names : sequence of str
        Of the files that will be written.
    mark, head : str
        A file whose text begins so was written by an earlier demonstration.
    force : bool
        Whether files of an earlier demonstration may be replaced.

    Raises
    ------
    DemoFolderError
        When files are in the way, or the folder cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        sign = folder / mark
        ours = sign.is_file() and sign.read_text(encoding="utf-8", errors="replace").startswith(head)
        there = [name for name in names if (folder / name).exists()]
    except OSError as problem:
        raise unwritable(folder, problem) from problem
    if there and not (ours and force):
        remedy = "pass --force to replace the demonstration" if ours else "it is not of a demonstration and stays"
        raise DemoFolderError(f"{folder / there[0]} exists: {remedy}, or choose another folder.")


def unwritable(folder: Path, problem: OSError) -> DemoFolderError:
    """Return the error for a folder that cannot be written to."""
    return DemoFolderError(f"{folder}: {problem.strerror or problem}. Choose a folder that can be written.")
