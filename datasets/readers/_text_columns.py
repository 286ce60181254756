"""Columns of a text file: which is time, which only counts rows, which are signals; and the sampling rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import UnreadableFileError
from ..units import parse_unit
from ._names import (
    is_index,
    is_label,
    is_other_axis,
    is_rate,
    is_speed,
    is_step,
    is_time,
    key_of,
    number_in,
    positive,
    seconds_per,
    split_header_cell,
)
from ._text_layout import TextLayout
from ._text_rows import Rows
from ._time_axis import epoch_scale, is_row_count, is_steady_rise, rate_from_times


@dataclass(frozen=True)
class Columns:
    """Signal columns of a file and what its preamble says."""

    signals: tuple[int, ...]
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    speed_rpm: float | None = None
    label: str | None = None
    promised_rows: int | None = None
    notes: Mapping[str, str] = field(default_factory=dict)


class TimeStamps:
    """The time column over the chunks read so far."""

    def __init__(self, column: int | None, scale: float = 1.0) -> None:
        self.column = column
        self.scale = scale
        self._parts: list[np.ndarray] = []

    def add(self, rows: Rows) -> None:
        """Remember the stamps of the next rows."""
        if self.column is not None:
            self._parts.append(rows.values[:, self.column] * self.scale)

    def restart(self) -> None:
        """Forget the stamps but the last one, which the next block's first step starts from."""
        self._parts = [self._parts[-1][-1:]] if self._parts else []

    @property
    def seconds(self) -> np.ndarray:
        """All remembered stamps."""
        return np.concatenate(self._parts) if self._parts else np.empty(0)


def sampling_rate(
    stamps: TimeStamps, layout: TextLayout, *, peek: Rows | None = None
) -> tuple[float | None, tuple[str, ...]]:
    """Return the rate (the preamble's before the time column's) and warnings, of ``peek`` if given."""
    stated = next((positive(value) for key, value in layout.fields if is_rate(key) and positive(value)), None)
    if stated is None:
        step = next((positive(value) for key, value in layout.fields if is_step(key) and positive(value)), None)
        stated = None if step is None else 1.0 / step
    seconds = stamps.seconds if peek is None or stamps.column is None else peek.values[:, stamps.column] * stamps.scale
    if seconds.size < 2:
        return stated, ()
    found, warnings = rate_from_times(seconds)
    if stated is None:
        return found, warnings
    if found is not None and abs(found - stated) > 0.01 * stated:
        text = f"The header states {stated:g} Hz but the time column gives {found:g} Hz; {stated:g} Hz is used."
        warnings = (*warnings, text)
    return stated, warnings


def choose_columns(rows: Rows, layout: TextLayout, path: Path) -> tuple[Columns, TimeStamps, tuple[str, ...]]:
    """Return the signal columns, the time column and warnings, judging by the first rows and the header.

    Raises
    ------
    UnreadableFileError
        When the first column is speed or frequency, or no signal column is left.
    """
    titles = [split_header_cell(cell) for cell in layout.header] if layout.header else None
    if titles and len(titles) > 1 and is_other_axis(titles[0][0]) and _is_other_table(rows, layout, titles):
        raise UnreadableFileError(
            f"{path}: its first column is {titles[0][0]!r}, so this is a spectrum or a run-up table, not a "
            "waveform over "
            "time. Give the file with the sampled signal."
        )
    time, scale, dropped, warnings = _time_column(rows, layout, titles)
    empty = {c for c in range(layout.columns) if np.isnan(rows.values[:, c]).all() and not (titles and titles[c][0])}
    signals = tuple(c for c in range(layout.columns) if c != time and c not in dropped | empty | layout.stamp_columns)
    if not signals:
        raise UnreadableFileError(f"{path}: no signal column beside time or row number. Export the signals with it.")
    fields = dict(layout.fields)
    named = [_title(c, position, titles, fields, len(signals)) for position, c in enumerate(signals)]
    units = _units(signals, titles, layout, fields)
    notes = {key: value for key, value in layout.fields if value}
    if layout.extra_first_row:
        notes["extra cells of the first row"] = " ".join(layout.extra_first_row)
    if dropped:
        notes["left out"] = "row-number column"
    columns = Columns(
        signals=signals,
        names=tuple(named),
        units=units,
        speed_rpm=next((positive(value) for key, value in fields.items() if is_speed(key)), None),
        label=next((value for key, value in fields.items() if is_label(key) and value), None),
        promised_rows=_promised(fields),
        notes=notes,
    )
    return columns, TimeStamps(time, scale), tuple(warnings)


def _is_other_table(rows: Rows, layout: TextLayout, titles: list[tuple[str, str | None]]) -> bool:
    """A speed signal recorded over time also has such a title, but then there is a rate or a time column."""
    timed = any(is_rate(key) or is_step(key) for key, _ in layout.fields) or any(is_time(name) for name, _ in titles)
    return not timed and bool(np.mean(np.diff(rows.values[:, 0]) > 0) > 0.9)


def _promised(fields: Mapping[str, str]) -> int | None:
    for key, value in fields.items():
        if key_of(key) in ("block_size", "samples", "number_of_samples", "total_samples", "num_samples"):
            number = number_in(value)
            return None if number is None else int(number)
    return None


def _time_column(
    rows: Rows, layout: TextLayout, titles: list[tuple[str, str | None]] | None
) -> tuple[int | None, float, set[int], list[str]]:
    """Return (time column, seconds per unit, row-number columns, warnings)."""
    values = rows.values
    if layout.stamp_columns:
        return max(layout.stamp_columns), 1.0, set(), []
    if titles is None:
        return _unnamed_time(values, layout)
    dropped = {c for c, (name, _) in enumerate(titles) if is_index(name) and is_row_count(values[:, c])}
    for column, (name, unit) in enumerate(titles):
        unit = unit or (layout.units[column] if layout.units else None)
        if not is_time(name) and seconds_per(unit) is None:
            continue
        if seconds_per(unit) is None and is_row_count(values[:, column]):
            text = f"Column {name!r} counts 0, 1, 2, ... without a unit: a row number, not time; it was left out."
            return None, 1.0, dropped | {column}, [text]
        return column, seconds_per(unit) or epoch_scale(float(values[0, column])), dropped, []
    return None, 1.0, dropped, []


def _unnamed_time(values: np.ndarray, layout: TextLayout) -> tuple[int | None, float, set[int], list[str]]:
    first = values[:, 0]
    if layout.columns < 2:
        return None, 1.0, set(), []
    if is_row_count(first):
        return None, 1.0, {0}, []
    if is_steady_rise(first):
        return 0, epoch_scale(float(first[0])), set(), []
    return None, 1.0, set(), []


def _title(
    column: int,
    position: int,
    titles: list[tuple[str, str | None]] | None,
    fields: Mapping[str, str],
    count: int,
) -> str:
    if count == 1:
        stated = next(
            (value for key, value in fields.items() if key_of(key) in ("signal_name", "channel_name", "channel")),
            "",
        )
        if stated:
            return stated
    if titles and titles[column][0]:
        return titles[column][0]
    return f"column {position + 1}" if titles is None else f"column {column + 1}"


def _units(
    signals: tuple[int, ...],
    titles: list[tuple[str, str | None]] | None,
    layout: TextLayout,
    fields: Mapping[str, str],
) -> tuple[str | None, ...]:
    common = next(
        (
            value.strip("()[] ")
            for key, value in fields.items()
            if key_of(key) in ("unit", "units", "y_unit", "y_axis_unit")
        ),
        None,
    )
    common = common if parse_unit(common) is not None else None
    out: list[str | None] = []
    for column in signals:
        unit = titles[column][1] if titles else None
        if unit is None and layout.units and layout.units[column] not in ("", "-", "()"):
            unit = layout.units[column].strip("()[] ")
        out.append(unit or common)
    return tuple(out)
