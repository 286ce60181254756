"""Files that are written whole or not at all, and never over other data: what reports, models and features share."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..simulators.errors import RotorwiseError


@dataclass(frozen=True)
class OutputKind:
    """A kind of file that is written.

    Attributes
    ----------
    name : str
        As messages call it, such as "report".
    content : str
        What a file of the kind is, such as "HTML page".
    example : str
        A file name.
    is_ours : callable
        Whether an existing file is of the kind, so that it may be replaced when asked; may raise OSError.
    error : type
        Raised by the checks and the writing.
    """

    name: str
    content: str
    example: str
    is_ours: Callable[[Path], bool]
    error: type[RotorwiseError]


def check_place(path: Path, kind: OutputKind, *, force: bool) -> None:
    """Raise the kind's error where no such file can go: a folder, a missing or locked folder, an existing file.

    Parameters
    ----------
    path : Path
        A link is followed.
    kind : OutputKind
    force : bool
        Whether an earlier file of the kind may be replaced.
    """
    title, error = kind.name.capitalize(), kind.error
    try:
        target = path.resolve()
        exists = target.exists()
    except OSError as problem:
        raise error(f"{title} {path}: {problem.strerror or problem}. Choose another name.") from problem
    if target.is_dir():
        raise error(f"{title} {target} is a folder; allowed: a file. Add a file name, for example {kind.example}.")
    if not target.parent.is_dir():
        raise error(
            f"Folder {target.parent} of {kind.name} {target.name} does not exist; allowed: a folder that exists. Make "
            "it first."
        )
    if not os.access(target.parent, os.W_OK):
        raise error(f"Folder {target.parent} of {kind.name} {target.name} may not be written to. Choose another place.")
    if not exists:
        return
    if not target.is_file():
        raise error(f"{title} {target} is no regular file. Choose another name.")
    if not force:
        raise error(f"{title} {target} exists already. Choose another name, or allow overwriting (--force).")
    if not _is_ours(target, kind):
        raise error(
            f"{target} exists and is no {kind.content}: a {kind.name} never replaces other data. Choose another name."
        )


def write_checked(path: Path, content: bytes, kind: OutputKind, *, force: bool) -> None:
    """Write a file whole or not at all, checked once more: making the content may have taken a while.

    Raises
    ------
    RotorwiseError
        Of the kind, as `check_place`, or when the place cannot be written to.
    """
    check_place(path, kind, force=force)
    replace_whole(path, content, error=kind.error)


def replace_whole(path: Path, content: bytes, *, error: type[RotorwiseError]) -> None:
    """Write bytes beside their destination and rename them, so that the file is whole or as before; unchecked.

    Raises
    ------
    RotorwiseError
        ``error``, when the place cannot be written to.
    """
    # A link is followed, so that it stays a link.
    target = path.resolve()
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        draft.write_bytes(content)
        if target.exists():
            shutil.copymode(target, draft)
        draft.replace(target)
    except OSError as problem:
        raise error(f"{target} cannot be written: {problem.strerror or problem}. Choose another place.") from problem
    finally:
        draft.unlink(missing_ok=True)


def _is_ours(target: Path, kind: OutputKind) -> bool:
    try:
        return kind.is_ours(target)
    except OSError:
        return False
