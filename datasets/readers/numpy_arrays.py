"""NumPy files: NPY of shape (n,), (n, c) or (c, n); NPZ with named arrays and ``fs``. Never pickles."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..errors import UnreadableFileError
from ..file_content import FileContent
from ._series import split_blocks, starts_with
from ._variables import Variable, content_of

NAME = "NumPy"
SUFFIXES = (".npy", ".npz")

_NPY = b"\x93NUMPY"
_ZIP = b"PK\x03\x04"


def recognises(path: Path, head: bytes) -> bool:
    """Whether it is an NPY array, or a zip archive whose first member is one."""
    if head.startswith(_NPY):
        return True
    name_length = int.from_bytes(head[26:28], "little")
    return head.startswith(_ZIP) and head[30 : 30 + name_length].endswith(b".npy")


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop``; an NPY file is mapped, not loaded.

    Raises
    ------
    UnreadableFileError
        On object arrays (they would need pickle), more than two dimensions, truncated or corrupted files.
    """
    if starts_with(path, _NPY):
        array = np.load(path, mmap_mode="r", allow_pickle=False)
        _check(array, path, path.stem)
        return content_of([Variable("channel", array)], path, start=start, stop=stop)
    # Opened here, because NumPy leaves a damaged archive open.
    with path.open("rb") as handle, np.load(handle, allow_pickle=False) as archive:
        variables = [_variable(name, archive[name]) for name in archive.files]
    names = next((one for one in variables if one.name == "channel_names"), None)
    units = next((one for one in variables if one.name == "units"), None)
    variables = [_described(one, names, units) for one in variables if one not in (names, units)]
    return content_of([one for one in variables if not _is_text_array(one)], path, start=start, stop=stop)


def blocks(path: Path, *, block_samples: int) -> Iterator[FileContent]:
    """Yield block by block; a compressed archive is loaded once."""
    if not starts_with(path, _NPY):
        yield from split_blocks(read(path), block_samples)
        return
    start, total = 0, 1
    while start < total:
        block = read(path, start=start, stop=start + block_samples)
        total = block.total_samples or 0
        yield block
        start += block_samples


def _variable(name: str, array: np.ndarray) -> Variable:
    return Variable(name, str(array.reshape(-1)[0]) if array.dtype.kind == "U" and array.size == 1 else array)


def _is_text_array(one: Variable) -> bool:
    return not isinstance(one.data, str) and one.data.dtype.kind not in "fiu"


def _described(one: Variable, names: Variable | None, units: Variable | None) -> Variable:
    if one.is_scalar or one.data.ndim != 2:
        return one
    attributes: dict[str, object] = {}
    for key, source in (("channel_names", names), ("units", units)):
        if source is not None:
            data = source.data
            texts = [data] if isinstance(data, str) else [str(text) for text in data.reshape(-1)]
            if len(texts) == min(one.data.shape):
                attributes[key] = texts if key == "channel_names" else [text or "" for text in texts]
    return Variable(one.name, one.data, attributes)


def _check(array: np.ndarray, path: Path, name: str) -> None:
    if array.dtype.kind not in "fiu" or array.ndim not in (1, 2):
        raise UnreadableFileError(
            f"{path}: array {name!r} has type {array.dtype} and shape {array.shape}; allowed: real numbers "
            "of shape "
            "(samples,), (samples, channels) or (channels, samples). Save it again in that form."
        )
