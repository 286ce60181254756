"""Writers of measurement files, one format a module, found by scanning this folder.

A writer module defines ``NAME`` (as on the command line), ``SUFFIXES`` and ``write(recording, path, *, notes)``. What
its format has no room for stands in the sidecar that :mod:`rotorwise.datasets.write` puts beside every file. Modules
whose name starts with an underscore are shared helpers.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Protocol, cast

from ..errors import InvalidValueError
from ..recording import Recording


class Writer(Protocol):
    """What a writer module offers."""

    NAME: str
    SUFFIXES: tuple[str, ...]

    def write(self, recording: Recording, path: Path, *, notes: Mapping[str, str]) -> None:
        """Write the signals and as much of the rest as the format holds."""
        ...


@cache
def all_writers() -> tuple[Writer, ...]:
    """Return every writer of this folder, by module name."""
    names = sorted(info.name for info in pkgutil.iter_modules(__path__) if not info.name.startswith("_"))
    return tuple(cast(Writer, importlib.import_module(f"{__name__}.{name}")) for name in names)


def find_writer(path: Path, *, file_format: str = "") -> Writer:
    """Return the writer of a format, or of the path's suffix when no format is named.

    Raises
    ------
    InvalidValueError
        When there is none; the message lists the formats.
    """
    known = ", ".join(f"{writer.NAME} ({' '.join(writer.SUFFIXES)})" for writer in all_writers())
    for writer in all_writers():
        if file_format.casefold() == writer.NAME or (not file_format and path.suffix.casefold() in writer.SUFFIXES):
            return writer
    if file_format:
        raise InvalidValueError(f"Format {file_format!r} cannot be written; allowed: {known}. Name one of them.")
    raise InvalidValueError(
        f"{path} has the suffix {path.suffix!r}, which says no format; allowed: {known}. Change the suffix or name "
        "the format (--format)."
    )
