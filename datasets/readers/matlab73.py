"""MATLAB files of version 7.3 (``save -v7.3``), which are HDF5 inside; slices are read alone."""

from __future__ import annotations

from pathlib import Path

from ..file_content import FileContent
from ._hdf5_tree import is_matlab73, variables_of
from ._variables import content_of

NAME = "MATLAB 7.3"
SUFFIXES = (".mat",)


def recognises(path: Path, head: bytes) -> bool:
    """Whether the file starts with MATLAB's version 7.3 text in front of an HDF5 signature."""
    return is_matlab73(head)


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop``; names are understood as in older MATLAB files."""
    import h5py

    with h5py.File(path, "r") as file:
        return content_of(variables_of(file), path, start=start, stop=stop)
