"""HDF5 files: numeric datasets are channels; attributes (``fs``, ``units``) describe them."""

from __future__ import annotations

from pathlib import Path

from ..file_content import FileContent
from ._hdf5_tree import is_hdf5, is_matlab73, variables_of
from ._variables import content_of

NAME = "HDF5"
SUFFIXES = (".h5", ".hdf5", ".hdf")


def recognises(path: Path, head: bytes) -> bool:
    """Whether the file has HDF5's signature and is not MATLAB's."""
    return is_hdf5(head) and not is_matlab73(head)


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop`` of the datasets that share rate and length."""
    import h5py

    with h5py.File(path, "r") as file:
        return content_of(variables_of(file), path, start=start, stop=stop)
