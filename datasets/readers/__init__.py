"""Readers of measurement files, one format a module, found by scanning this folder.

A reader module defines ``NAME``, ``SUFFIXES``, ``recognises(path, head)`` and
``read(path, *, start=0, stop=None)``; where reading a slice costs as much as reading the whole file it also
defines ``blocks(path, *, block_samples)``. One of plain text, whose suffixes notes have as well, says
``IS_TEXT``. Adding a format is adding a module; nothing here changes.
Modules whose name starts with an underscore are shared helpers.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Protocol, cast

from ..errors import InvalidValueError, RotorwiseError, UnreadableFileError
from ..file_content import FileContent

HEAD_BYTES = 65536


class Reader(Protocol):
    """What a reader module offers."""

    NAME: str
    SUFFIXES: tuple[str, ...]

    def recognises(self, path: Path, head: bytes) -> bool:
        """Return whether the content (not the suffix) is this reader's format."""
        ...

    def read(self, path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
        """Return samples ``start`` to ``stop`` of every channel."""
        ...


@cache
def all_readers() -> tuple[Reader, ...]:
    """Return every reader of this folder, by module name."""
    names = sorted(info.name for info in pkgutil.iter_modules(__path__) if not info.name.startswith("_"))
    return tuple(cast(Reader, importlib.import_module(f"{__name__}.{name}")) for name in names)


def read_head(path: Path) -> bytes:
    """Return the first 64 KiB of a file.

    Raises
    ------
    UnreadableFileError
        When it is missing, a folder, a pipe, not permitted, or empty.
    """
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            # Opening a pipe may wait for ever, and what is read from it once is gone.
            raise UnreadableFileError(f"{path} is a pipe or a device. Save the data to a file first.")
        with path.open("rb") as handle:
            head = handle.read(HEAD_BYTES)
    except FileNotFoundError:
        raise UnreadableFileError(f"{path}: no such file. Check the name and the folder.") from None
    except IsADirectoryError:
        raise UnreadableFileError(f"{path} is a folder; a file is needed here.") from None
    except OSError as error:
        raise UnreadableFileError(f"{path}: cannot be opened ({error.strerror}). Check the permissions.") from error
    if not head:
        raise UnreadableFileError(f"{path} is empty (0 bytes). Export or copy it again.")
    return head


def find_reader(path: Path | str) -> Reader:
    """Return the reader whose format the file's content has.

    Raises
    ------
    UnreadableFileError
        When no reader recognises it; the message lists the formats.
    """
    path = Path(path)
    head = read_head(path)
    for reader in all_readers():
        if reader.recognises(path, head):
            return reader
    own = [reader.NAME for reader in all_readers() if path.suffix.casefold() in reader.SUFFIXES]
    if own and not any(getattr(reader, "IS_TEXT", False) for reader in all_readers() if reader.NAME in own):
        raise UnreadableFileError(
            f"{path}: its content is not {' or '.join(own)}, though its suffix says so: damaged or incomplete. Copy or "
            "export it again."
        )
    formats = "; ".join(f"{reader.NAME} ({' '.join(reader.SUFFIXES)})" for reader in all_readers())
    raise UnreadableFileError(
        f"{path}: its content is in no format known here. Known: {formats}. "
        "A text file needs rows of numbers. Check that the file is complete, or export it in one of these "
        "formats."
    )


def read_content(path: Path | str, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop`` of a file, whatever its format.

    Raises
    ------
    UnreadableFileError
        When the file is missing, foreign, truncated or corrupted.
    InvalidValueError
        When ``start`` or ``stop`` is out of order.
    """
    path = Path(path)
    if start < 0 or (stop is not None and stop < start):
        raise InvalidValueError(f"Samples {start} to {stop}; allowed: 0 <= start <= stop.")
    reader = find_reader(path)
    try:
        return reader.read(path, start=start, stop=stop)
    except Exception as error:
        raise _readable(error, path, reader.NAME) from error


def content_blocks(path: Path | str, *, block_samples: int) -> Iterator[FileContent]:
    """Yield a file in consecutive blocks of at most ``block_samples`` samples, in bounded memory.

    Raises
    ------
    UnreadableFileError, InvalidValueError
        As for :func:`read_content`.
    """
    path = Path(path)
    if block_samples < 1:
        raise InvalidValueError(f"Blocks of {block_samples} samples; allowed: 1 or more.")
    reader = find_reader(path)
    try:
        if hasattr(reader, "blocks"):
            yield from reader.blocks(path, block_samples=block_samples)  # pyright: ignore[reportAttributeAccessIssue]
            return
        start = 0
        while True:
            block = reader.read(path, start=start, stop=start + block_samples)
            if block.samples:
                yield block
            start += block.samples
            if block.samples < block_samples or start == block.total_samples:
                return
    except Exception as error:
        raise _readable(error, path, reader.NAME) from error


def _readable(error: Exception, path: Path, name: str) -> RotorwiseError:
    # Format libraries raise nearly anything on damaged bytes; the user gets one kind of error.
    if isinstance(error, RotorwiseError):
        return error
    reason = " ".join(str(error).split())[:200] or type(error).__name__
    return UnreadableFileError(
        f"{path}: damaged or unusual {name} file ({reason}). Copy or export it again; if another program "
        "opens it, export it from there as CSV or WAV."
    )
