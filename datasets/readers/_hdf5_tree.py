"""Variables of an open HDF5 file: datasets and the attributes that describe them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._names import is_rate, is_step
from ._variables import DESCRIBING, Variable

_HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
_MATLAB_TEXT = b"MATLAB 7.3 MAT-file"


def is_hdf5(head: bytes) -> bool:
    """Whether HDF5's signature is at the start or behind a user block."""
    return any(head[offset : offset + 8] == _HDF5_MAGIC for offset in (0, 512, 1024, 2048))


def is_matlab73(head: bytes) -> bool:
    """Whether the user block in front of the HDF5 part is MATLAB's."""
    return head.startswith(_MATLAB_TEXT) and is_hdf5(head)


def variables_of(file: Any) -> list[Variable]:
    """Return every numeric or text dataset, and every attribute of the groups as a scalar."""
    import h5py

    found: list[Variable] = []
    _attributes(file, "", found)

    def visit(name: str, node: object) -> None:
        dotted = name.replace("/", ".")
        if name.startswith("#"):
            return  # MATLAB's own bookkeeping
        if isinstance(node, h5py.Group):
            _attributes(node, f"{dotted}.", found)
        elif isinstance(node, h5py.Dataset) and node.shape is not None:
            variable = _dataset(dotted, node)
            if variable is not None:
                found.append(variable)

    file.visititems(visit)
    return found


def _attributes(node: Any, prefix: str, found: list[Variable]) -> None:
    for key, value in node.attrs.items():
        if isinstance(value, bytes):
            found.append(Variable(prefix + key, value.decode("utf-8", "replace")))
        elif isinstance(value, str):
            found.append(Variable(prefix + key, value))
        elif np.asarray(value).size == 1 and np.asarray(value).dtype.kind in "fiu":
            found.append(Variable(prefix + key, np.asarray(value)))


def _is_wanted(key: str) -> bool:
    return key.startswith("MATLAB_") or key.casefold() in DESCRIBING or is_rate(key) or is_step(key)


def _dataset(name: str, node: Any) -> Variable | None:
    # Only attributes that mean something here are touched: HDF5 itself can crash on damaged ones.
    attributes = {key: node.attrs[key] for key in node.attrs if _is_wanted(key)}
    if attributes.get("MATLAB_empty") or attributes.get("MATLAB_class") == b"cell":
        return None
    if attributes.get("MATLAB_class") == b"char":
        return Variable(name, "".join(chr(code) for code in np.asarray(node[...]).reshape(-1)[:1000]))
    if node.dtype.kind in "fiu" and node.size:
        return Variable(name, node, attributes)
    if node.dtype.kind in "OS" and node.size == 1:
        value = np.asarray(node[()]).reshape(-1)[0]
        if isinstance(value, bytes | str):
            return Variable(name, value.decode("utf-8", "replace") if isinstance(value, bytes) else value)
    return None
