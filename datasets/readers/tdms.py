"""National Instruments TDMS files: rate from ``wf_increment``, unit from ``unit_string`` and its like."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..file_content import FileContent
from ._names import is_label, is_rate, is_speed, is_time, positive
from ._series import Header, StoredSeries, gather
from ._time_axis import rate_from_times

NAME = "TDMS"
SUFFIXES = (".tdms",)

_UNIT_KEYS = ("unit_string", "NI_UnitDescription", "Unit", "unit", "units")


def recognises(path: Path, head: bytes) -> bool:
    """Whether the file starts with TDMS's segment tag."""
    return head.startswith(b"TDSm")


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop`` of the channels that share rate and length."""
    import warnings

    from nptdms import TdmsFile

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with TdmsFile.open(path) as file:
            fields = dict(file.properties)
            series: list[StoredSeries] = []
            times: list[Any] = []
            for group in file.groups():
                fields.update({key: value for key, value in group.properties.items() if key not in fields})
                for channel in group.channels():
                    if channel.dtype.kind not in "fiu" or len(channel) == 0:
                        continue
                    (times if is_time(channel.name) else series).append(_series(channel))
            header = _header(fields, series, times, tuple(str(one.message) for one in caught))
            return gather(series, header, path, start=start, stop=stop)


def _series(channel: Any) -> StoredSeries:
    properties = channel.properties
    step = positive(properties.get("wf_increment"))
    rate = next((positive(value) for key, value in properties.items() if is_rate(key)), None)
    unit = next((str(properties[key]) for key in _UNIT_KEYS if properties.get(key)), None)

    def load(start: int, stop: int) -> np.ndarray:
        return np.asarray(channel[start:stop]) if stop > start else np.empty(0)

    return StoredSeries(channel.name, len(channel), load, unit, 1.0 / step if step else rate)


def _header(
    fields: dict[str, Any], series: list[StoredSeries], times: list[Any], warnings: tuple[str, ...]
) -> Header:
    rate = next((positive(value) for key, value in fields.items() if is_rate(key)), None)
    speed = next((positive(value) for key, value in fields.items() if is_speed(key)), None)
    label = next((str(value) for key, value in fields.items() if is_label(key)), None)
    if times and rate is None and not any(one.rate_hz for one in series):
        rate, found = rate_from_times(np.asarray(times[0].load(0, times[0].samples), dtype=np.float64))
        warnings = (*warnings, *found)
    notes = {str(key): str(value)[:200] for key, value in fields.items()}
    return Header(rate_hz=rate, speed_rpm=speed, label=label, warnings=warnings, notes=notes)
