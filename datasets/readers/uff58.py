"""Universal File Format, data set 58, text and binary: time responses with even spacing.

Reference: Structural Dynamics Research Laboratory, University of Cincinnati, "Universal File Formats", data
set 58 (record numbers below are its). Read here and not through pyuff, because a slice then costs a seek and
every length can be checked against the file.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..errors import UnreadableFileError
from ..file_content import FileContent
from ._names import unique_names
from ._series import Header, StoredSeries, gather

NAME = "UFF 58"
SUFFIXES = (".uff", ".unv", ".uf")

_MARK = b"    -1"
_TIME_RESPONSE = (0, 1)  # function type: general or unknown, time response
_NODE = "node "
_DIRECTIONS = {0: "", 1: "+X", -1: "-X", 2: "+Y", -2: "-Y", 3: "+Z", -3: "-Z"}


@dataclass(frozen=True)
class _DataSet:
    name: str
    description: str
    unit: str | None
    points: int
    promised: int
    step_s: float
    offset: int
    binary: bool
    dtype: np.dtype
    refusal: str | None


def recognises(path: Path, head: bytes) -> bool:
    """Whether it starts with the -1 mark on its own line and a data set number."""
    lines = [line.strip() for line in head[:400].splitlines() if line.strip()]
    return len(lines) > 1 and lines[0] == b"-1" and lines[1].split(b" ")[0].rstrip(b"b").isdigit()


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop`` of the time responses that share rate and length.

    Raises
    ------
    UnreadableFileError
        When the file has no evenly spaced time response (spectra and FRFs are no recordings).
    """
    with path.open("rb") as handle:
        found = _scan(handle, path.stat().st_size)
        warnings = [f"{one.name} left out: {one.refusal}." for one in found if one.refusal]
        usable = [one for one in found if one.refusal is None]
        if not usable:
            reason = "; ".join(warnings[:3]) or "no data set 58 in it"
            raise UnreadableFileError(f"{path}: no evenly spaced time response ({reason}). Export time histories.")
        shortest = min(one.points for one in usable)
        for one in usable:
            if one.points < one.promised:
                warnings.append(
                    f"{path.name} is cut off: {one.points} of {one.promised} samples of {one.name} are there."
                )
        if (
            any(one.points < one.promised for one in usable)
            and len({one.promised for one in usable}) == 1
            and shortest == 0
        ):
            usable = [one for one in usable if one.points == one.promised] or usable
        names = unique_names(_names(usable))
        series = [
            StoredSeries(name, one.points, _loader(handle, one), one.unit, 1.0 / one.step_s)
            for name, one in zip(names, usable, strict=True)
        ]
        return gather(_snapped(series), Header(warnings=tuple(warnings)), path, start=start, stop=stop)


def _snapped(series: list[StoredSeries]) -> list[StoredSeries]:
    # Record 7 prints the step with 6 digits: 1.52588E-05 s is 65536 Hz, not 65535.9.
    out: list[StoredSeries] = []
    for one in series:
        rate = one.rate_hz or 0.0
        near = float(round(rate))
        out.append(
            StoredSeries(one.name, one.samples, one.load, one.unit, near if abs(near - rate) < 5e-6 * rate else rate)
        )
    return out


def _scan(handle: BinaryIO, size: int) -> list[_DataSet]:
    found: list[_DataSet] = []
    inside = False
    while line := handle.readline(10_000):
        if not line.strip().endswith(b"-1") or line.strip() != b"-1":
            continue
        if inside:
            inside = False
            continue
        kind = handle.readline(200)
        inside = True
        if kind.strip().startswith(b"58"):
            found.append(_data_set(handle, kind, size))
            inside = False
            _skip_mark(handle)
    return found


def _skip_mark(handle: BinaryIO) -> None:
    # In binary sets the closing mark may follow the last byte directly, without a line of its own.
    while line := handle.readline(10_000):
        if line.strip().endswith(b"-1"):
            return


def _data_set(handle: BinaryIO, kind: bytes, size: int) -> _DataSet:
    records = [handle.readline(500).decode("latin-1").rstrip("\r\n") for _ in range(11)]
    binary = kind.strip().startswith(b"58b")
    fields = kind.decode("latin-1").split()
    big_endian = binary and len(fields) > 1 and fields[1] == "2"
    form = records[6].split()
    data_type, promised, even = int(form[0]), int(form[1]), int(form[2])
    step = float(form[4])
    dtype = np.dtype((">" if big_endian else "<") + ("f8" if data_type in (4, 6) else "f4"))
    unit = records[8][46:].strip()
    offset = handle.tell()
    function_type = int(records[5][:5])
    refusal = None
    if function_type not in _TIME_RESPONSE or data_type not in (2, 4):
        refusal = "not a real time response"
    elif even != 1 or not 0 < step < 1e6:
        refusal = "uneven or missing time spacing"
    elif binary and len(fields) > 2 and fields[2] != "2":
        refusal = "floating-point format other than IEEE 754"
    if binary:
        points = max(0, min(promised, (size - offset) // dtype.itemsize))
        bytes_stated = int(fields[4]) if len(fields) > 4 else promised * dtype.itemsize
        handle.seek(min(size, offset + max(0, bytes_stated)))
    else:
        points = min(promised, _count_text(handle, 20 if data_type in (4, 6) else 13))
    unit_text = None if unit in ("", "NONE") else unit
    return _DataSet(
        _name(records), _said(records[0]), unit_text, points, promised, step, offset, binary, dtype, refusal
    )


def _name(records: list[str]) -> str:
    entity, node, direction = records[5][31:41].strip(), records[5][41:51].strip(), records[5][51:55].strip()
    if entity and entity != "NONE":
        return entity
    if node not in ("", "0"):
        return f"{_NODE}{node}{_DIRECTIONS.get(int(direction or 0), '')}"
    return _said(records[0]) or "channel"


def _said(text: str) -> str:
    return text.strip() if text.strip() != "NONE" else ""


def _names(usable: list[_DataSet]) -> list[str]:
    """Return the channels' names: record 1, where all else are numbers of nodes and it differs for each."""
    said = [one.description for one in usable]
    numbered = all(one.name.startswith(_NODE) for one in usable)
    return said if numbered and all(said) and len(set(said)) == len(said) else [one.name for one in usable]


def _count_text(handle: BinaryIO, width: int) -> int:
    """Count the whole numbers up to the closing mark, and leave the file in front of that mark."""
    points = 0
    while line := handle.readline(10_000):
        if line.strip() == b"-1":
            handle.seek(-len(line), 1)
            return points
        if line.endswith(b"\n"):
            points += len(line.rstrip()) // width
        else:
            points += len(line) // width
    return points


def _loader(handle: BinaryIO, one: _DataSet):
    def load_binary(start: int, stop: int) -> np.ndarray:
        handle.seek(one.offset + start * one.dtype.itemsize)
        return np.frombuffer(handle.read((stop - start) * one.dtype.itemsize), dtype=one.dtype)

    def load_text(start: int, stop: int) -> np.ndarray:
        width = 20 if one.dtype.itemsize == 8 else 13
        handle.seek(one.offset)
        parts: list[bytes] = []
        count = 0
        # Numbers of fixed width may touch each other, so they are cut by column and not at blanks.
        while count < stop and (line := handle.readline(10_000)):
            whole = len(line.rstrip()) // width
            parts.append(line[: whole * width])
            count += whole
        return np.frombuffer(b"".join(parts), dtype=f"S{width}")[start:stop].astype(one.dtype.newbyteorder("="))

    return load_binary if one.binary else load_text
