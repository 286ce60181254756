"""Named variables (MATLAB, HDF5, NPZ) to channels: which are signals, which is the rate, the speed, the time.

Names decide, in this order: a field that is a sampling rate (fs, sr, SampFreq, rate_hz, sampling_rate, ...),
a step (dt, XInc), a time vector. Numeric arrays of equal length become channels.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ._names import is_label, is_rate, is_speed, is_step, is_time, positive
from ._series import Header, StoredSeries, gather
from ._time_axis import rate_from_times

_CWRU = re.compile(r"X(\d+)_?(?:(DE|FE|BA)_time|RPM)")
NAMING = ("channels", "channel_names", "names", "columns", "name")
UNIT_NAMING = ("unit", "units", "unit_string")
#: Attributes of a variable that say something beside those named like a rate or a step.
DESCRIBING = (*NAMING, *UNIT_NAMING, "rate")
#: Stamps inspected for gaps and duplicates; the rate itself uses the first and the last stamp of the file.
_STAMPS_CHECKED = 1_000_000


@dataclass(frozen=True, eq=False)
class Variable:
    """One variable of a file.

    Attributes
    ----------
    name : str
        With the names of the enclosing structs or groups before it, joined by dots.
    data : array-like or str
        Anything with ``shape`` and slicing (an array, an HDF5 dataset), or a text.
    attributes : mapping
        Attributes of the variable itself.
    """

    name: str
    data: Any
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def leaf(self) -> str:
        """Last part of the name."""
        return self.name.rsplit(".", 1)[-1]

    @property
    def is_scalar(self) -> bool:
        """Whether it is a text or one number."""
        return isinstance(self.data, str) or int(np.prod(self.data.shape)) == 1

    @property
    def scalar(self) -> object:
        """The text or the number."""
        return self.data if isinstance(self.data, str) else np.asarray(self.data[...]).reshape(-1)[0]


def content_of(variables: list[Variable], path: Path, *, start: int, stop: int | None):
    """Return the file's content; see the module's text for the rules."""
    variables, record_warnings = _one_record(variables, path)
    scalars = [one for one in variables if one.is_scalar]
    arrays = [one for one in variables if not one.is_scalar and _is_signal(one)]
    header = _header(scalars, arrays)
    times = [one for one in arrays if is_time(one.leaf)]
    signals = [one for one in arrays if one not in times] or times
    series = [part for one in signals for part in _series_of(one)]
    main_length = max((one.samples for one in series), default=0)
    if signals is not times:
        for one in times:
            header = _with_time(header, one, main_length)
    header = replace(header, warnings=(*record_warnings, *header.warnings))
    return gather(series, header, path, start=start, stop=stop)


def _is_signal(one: Variable) -> bool:
    shape = one.data.shape
    # Two long sides are an image or a map, not channels over time; complex numbers are spectra.
    return (
        np.dtype(one.data.dtype).kind in "fiu"
        and len([side for side in shape if side != 1]) <= 2
        and 0 < len(shape) <= 3
        and int(np.prod(shape)) > 0
    )


def _header(scalars: list[Variable], arrays: list[Variable]) -> Header:
    rate = step = speed = load = None
    label = None
    notes: dict[str, str] = {}
    mfpt = any(one.leaf == "gs" for one in arrays) and any(one.leaf == "sr" for one in scalars)
    for one in scalars:
        value, leaf = one.scalar, one.leaf
        if mfpt and leaf == "rate":
            # In MFPT's struct `sr` is the sampling rate and `rate` the shaft speed in Hz.
            speed = None if (turns := positive(value)) is None else turns * 60.0
        elif is_rate(leaf) or leaf.casefold() == "rate":
            rate = rate or positive(value)
        elif is_step(leaf):
            step = step or positive(value)
        elif is_speed(leaf) or _CWRU.fullmatch(leaf):
            speed = speed or positive(value)
        elif leaf.casefold() == "load" and not one.name.startswith("Head_"):
            load = None if not _is_number(value) else float(str(value))
        elif is_label(leaf) and isinstance(value, str):
            label = value
        elif len(notes) < 100:
            notes[one.name] = str(value)[:200]
    if rate is None and step is not None:
        rate = 1.0 / step
    return Header(
        rate_hz=rate, speed_rpm=speed, load=load, load_unit="lb" if mfpt and load is not None else None,
        label=label, notes=notes,
    )  # fmt: skip


def _is_number(value: object) -> bool:
    try:
        return bool(np.isfinite(float(str(value))))
    except ValueError:
        return False


def _series_of(one: Variable) -> list[StoredSeries]:
    shape = tuple(one.data.shape)
    long_axis = int(np.argmax(shape))
    rest = [axis for axis in range(len(shape)) if axis != long_axis]
    columns = [index for index in np.ndindex(*(shape[axis] for axis in rest))]
    names = _column_names(one, len(columns))
    units = _column_units(one, len(columns))
    rate = next((positive(value) for key, value in one.attributes.items() if is_rate(key) or key == "rate"), None)
    if rate is None:
        step = next((positive(value) for key, value in one.attributes.items() if is_step(key)), None)
        rate = None if step is None else 1.0 / step

    def loader(column: tuple[int, ...]):
        def load(start: int, stop: int) -> np.ndarray:
            index: list[Any] = [slice(None)] * len(shape)
            index[long_axis] = slice(start, stop)
            for axis, position in zip(rest, column, strict=True):
                index[axis] = position
            return np.asarray(one.data[tuple(index)]).reshape(-1)

        return load

    return [
        StoredSeries(name, shape[long_axis], loader(column), unit, rate)
        for name, unit, column in zip(names, units, columns, strict=True)
    ]


def _texts(value: object) -> list[str]:
    if isinstance(value, bytes):
        return [value.decode("utf-8", "replace")]
    if isinstance(value, str):
        return [value]
    if isinstance(value, np.ndarray | list | tuple):
        return [text for item in np.asarray(value).reshape(-1).tolist() for text in _texts(item)]
    return []


def _column_names(one: Variable, columns: int) -> list[str]:
    for key, value in one.attributes.items():
        texts = _texts(value)
        if key.casefold() in ("channels", "channel_names", "names", "columns", "name") and len(texts) == columns:
            return texts
    if columns == 1:
        return [one.name]
    return [f"{one.name}[{index}]" for index in range(columns)]


def _column_units(one: Variable, columns: int) -> list[str | None]:
    for key, value in one.attributes.items():
        if key.casefold() in UNIT_NAMING:
            texts = _texts(value)
            if len(texts) == columns:
                return list(texts)
            if len(texts) == 1:
                return [texts[0]] * columns
    # CWRU's and MFPT's files carry no unit field; both archives state g for every file of this naming.
    documented = "g" if _CWRU.fullmatch(one.leaf) or one.leaf == "gs" else None
    return [documented] * columns


def _with_time(header: Header, time: Variable, samples: int) -> Header:
    length = int(max(time.data.shape))
    if length != samples or int(np.prod(time.data.shape)) != length:
        return replace(header, warnings=(*header.warnings, f"Time vector {time.name} has another length; not used."))
    (series,) = _series_of(time)
    head = np.asarray(series.load(0, min(length, _STAMPS_CHECKED)), dtype=np.float64)
    rate, warnings = rate_from_times(head)
    if rate is not None and length > head.size:
        last = float(series.load(length - 1, length)[0])
        rate = (length - 1) / (last - float(head[0])) if last > head[0] else rate
    if header.rate_hz is None:
        return replace(header, rate_hz=rate, warnings=(*header.warnings, *warnings))
    if rate is not None and abs(rate - header.rate_hz) > 0.01 * header.rate_hz:
        text = (
            f"The file states {header.rate_hz:g} Hz but its time vector gives {rate:g} Hz; "
            f"{header.rate_hz:g} Hz is used."
        )
        return replace(header, warnings=(*header.warnings, text))
    return header


def _one_record(variables: list[Variable], path: Path) -> tuple[list[Variable], tuple[str, ...]]:
    """Keep one record number of a CWRU file that holds several (X098 and X099 in normal_2)."""
    numbers = {match.group(1) for one in variables if (match := _CWRU.fullmatch(one.leaf)) and match.group(2)}
    if len(numbers) < 2:
        return variables, ()
    in_name = [text.lstrip("0") for text in re.findall(r"\d+", path.stem)]
    ordered = sorted(numbers)
    chosen = next((number for number in ordered if number.lstrip("0") in in_name[-1:]), ordered[0])
    kept = [one for one in variables if not (m := _CWRU.fullmatch(one.leaf)) or m.group(1) == chosen]
    others = ", ".join(f"X{number}" for number in ordered if number != chosen)
    return kept, (f"The file holds several records; X{chosen} is read, {others} left out.",)
