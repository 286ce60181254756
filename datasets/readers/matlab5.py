"""MATLAB files up to version 7 (``save -v7`` and older): arrays and structs, through SciPy."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..errors import UnreadableFileError
from ..file_content import FileContent
from ._series import split_blocks
from ._variables import Variable, content_of

NAME = "MATLAB 5"
SUFFIXES = (".mat",)

#: Unit codes of the NVA analyser that writes Data_n with Head_n; only the one that is known for sure.
_HEAD_UNITS = {12: "m/s2"}


def recognises(path: Path, head: bytes) -> bool:
    """Whether the file starts with MATLAB's version 5 text and byte-order mark."""
    return head.startswith(b"MATLAB 5.0 MAT-file") and head[126:128] in (b"IM", b"MI")


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return the file's signals; the format must be loaded whole, so a slice costs as much.

    Raises
    ------
    UnreadableFileError
        On a truncated or corrupted file, or one without numeric arrays.
    """
    from scipy.io import loadmat

    try:
        with warnings.catch_warnings():
            # A variable stored twice: the later one counts, as in MATLAB itself.
            warnings.simplefilter("ignore")
            found = loadmat(path, squeeze_me=True, struct_as_record=True)
    except Exception as error:
        # SciPy raises many kinds of error on damaged bytes, zlib's and its own among them.
        reason = " ".join(str(error).split())[:150]
        raise UnreadableFileError(
            f"{path}: truncated or corrupted MATLAB file ({reason}). Copy it again, or save it again in MATLAB."
        ) from error
    variables: list[Variable] = []
    for name, value in found.items():
        if not name.startswith("__"):
            _flatten(name, value, variables)
    return content_of(_with_head_units(variables), path, start=start, stop=stop)


def blocks(path: Path, *, block_samples: int) -> Iterator[FileContent]:
    """Yield the file block by block, loading it once."""
    yield from split_blocks(read(path), block_samples)


def _flatten(name: str, value: object, into: list[Variable], depth: int = 0) -> None:
    if isinstance(value, str | int | float):
        into.append(Variable(name, value if isinstance(value, str) else np.asarray(value)))
        return
    if not isinstance(value, np.ndarray | np.generic) or depth > 4:
        return
    array = np.asarray(value)
    if array.dtype.names and array.size == 1:
        for part in array.dtype.names:
            _flatten(f"{name}.{part}", array.reshape(-1)[0][part], into, depth + 1)
    elif array.dtype.kind in "OV" and array.size == 1:
        _flatten(name, array.reshape(-1)[0], into, depth + 1)
    elif array.dtype.kind == "U":
        into.append(Variable(name, "".join(array.reshape(-1).tolist())))
    elif array.dtype.kind in "fiub" and array.size:
        into.append(Variable(name, array))


def _with_head_units(variables: list[Variable]) -> list[Variable]:
    """Give Data<n> the unit and the channel name that the struct Head_<n> beside it states."""
    fields = {one.name: one.scalar for one in variables if one.is_scalar}
    out: list[Variable] = []
    for one in variables:
        match = re.fullmatch(r"Data_?(\d+)", one.name)
        code = fields.get(f"Head_{match.group(1)}.YUnit") if match else None
        if match is None or code is None:
            out.append(one)
            continue
        attributes: dict[str, object] = {}
        unit = _HEAD_UNITS.get(int(float(str(code))))
        if unit is not None:
            attributes["unit"] = unit
        if title := str(fields.get(f"Head_{match.group(1)}.Name") or "").strip():
            attributes["name"] = title
        out.append(Variable(one.name, one.data, attributes))
    return out
