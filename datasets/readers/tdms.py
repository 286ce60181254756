"""National Instruments TDMS files: rate from ``wf_increment``, unit from ``unit_string`` and its like."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..file_content import FileContent
from ._names import is_label, is_rate, is_speed, is_time, positive
from ._series import Header, StoredSeries, gather
from ._time_axis import rate_from_times

NAME = "TDMS"
SUFFIXES = (".tdms",)

_LEAD_IN = 28  # tag, flags, version, length of the segment, length of its description
_UNIT_KEYS = ("unit_string", "NI_UnitDescription", "Unit", "unit", "units")


def recognises(path: Path, head: bytes) -> bool:
    """Whether the file starts with TDMS's segment tag."""
    return head.startswith(b"TDSm")


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop`` of the channels that share rate and length."""
    from nptdms import TdmsFile

    # The file is opened here, because the library leaves a damaged one open.
    with _library_log() as messages, path.open("rb") as handle, TdmsFile.open(handle) as file:
        fields = dict(file.properties)
        channels: list[Any] = []
        for group in file.groups():
            fields.update({key: value for key, value in group.properties.items() if key not in fields})
            channels.extend(one for one in group.channels() if one.dtype.kind in "fiu" and len(one))
        times = [_series(one) for one in channels if is_time(one.name)]
        series = [_series(one) for one in channels if not is_time(one.name)]
        content = gather(series, _header(fields, series, times), path, start=start, stop=stop)
    found = (f"The TDMS file looks damaged: {messages[0]}",) if messages else ()
    return replace(content, warnings=(*content.warnings, *found, *_cut_off(path)))


@contextmanager
def _library_log() -> Iterator[list[str]]:
    """Collect what the library would print on the terminal."""
    from nptdms.log import log_manager

    messages: list[str] = []

    def collect(record: logging.LogRecord) -> bool:
        messages.append(record.getMessage()[:150])
        return False

    log_manager.console_handler.addFilter(collect)
    try:
        yield messages
    finally:
        log_manager.console_handler.removeFilter(collect)


def _cut_off(path: Path) -> tuple[str, ...]:
    """Follow the segments' lengths to the end of the file; the library reads a cut segment without a word."""
    size, position = path.stat().st_size, 0
    with path.open("rb") as handle:
        while position < size:
            handle.seek(position)
            lead_in = handle.read(_LEAD_IN)
            # All bits set: the writer died before it closed the segment.
            length = int.from_bytes(lead_in[12:20], "little")
            if len(lead_in) < _LEAD_IN or position + _LEAD_IN + length > size:
                return (f"{path.name} is cut off inside a segment; the samples before are used.",)
            position += _LEAD_IN + length
    return ()


def _series(channel: Any) -> StoredSeries:
    properties = channel.properties
    step = positive(properties.get("wf_increment"))
    rate = next((positive(value) for key, value in properties.items() if is_rate(key)), None)
    unit = next((str(properties[key]) for key in _UNIT_KEYS if properties.get(key)), None)

    def load(start: int, stop: int) -> np.ndarray:
        return np.asarray(channel[start:stop]) if stop > start else np.empty(0)

    return StoredSeries(channel.name, len(channel), load, unit, 1.0 / step if step else rate)


def _header(fields: dict[str, Any], series: list[StoredSeries], times: list[StoredSeries]) -> Header:
    warnings: tuple[str, ...] = ()
    rate = next((positive(value) for key, value in fields.items() if is_rate(key)), None)
    speed = next((positive(value) for key, value in fields.items() if is_speed(key)), None)
    label = next((str(value) for key, value in fields.items() if is_label(key)), None)
    if times and rate is None and not any(one.rate_hz for one in series):
        rate, warnings = rate_from_times(np.asarray(times[0].load(0, times[0].samples), dtype=np.float64))
    notes = {str(key): str(value)[:200] for key, value in fields.items()}
    return Header(rate_hz=rate, speed_rpm=speed, label=label, warnings=warnings, notes=notes)
