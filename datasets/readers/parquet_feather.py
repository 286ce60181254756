"""Parquet and Feather tables: one column a channel, rate from the table's metadata or a time column."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UnreadableFileError
from ..file_content import FileContent
from ._names import is_index, is_label, is_rate, is_speed, is_time, positive, seconds_per, split_header_cell
from ._series import Header, StoredSeries, gather, starts_with
from ._time_axis import epoch_scale, is_row_count, rate_from_times

NAME = "Parquet or Feather"
SUFFIXES = (".parquet", ".feather", ".arrow")

_STAMPS_CHECKED = 1_000_000


def recognises(path: Path, head: bytes) -> bool:
    """Whether the file starts with Parquet's, Arrow's or Feather's magic bytes."""
    return head[:4] in (b"PAR1", b"FEA1") or head.startswith(b"ARROW1")


def read(path: Path, *, start: int = 0, stop: int | None = None) -> FileContent:
    """Return samples ``start`` to ``stop``; of a Parquet file only the row groups that hold them are read.

    Raises
    ------
    UnreadableFileError
        When a column holds text or lists (a data set of recordings is a table of another kind).
    """
    table = _parquet(path) if starts_with(path, b"PAR1") else _feather(path)
    with table:
        columns = [_Column(table, index, field) for index, field in enumerate(table.schema)]
        wrong = [one.name for one in columns if one.kind == "other"]
        if wrong:
            raise UnreadableFileError(
                f"{path}: columns {', '.join(wrong[:6])} hold text or lists, so these are not waveforms "
                "with one "
                "sample a row. Export one recording a file, numbers only."
            )
        metadata = {
            key.decode(): value.decode("utf-8", "replace") for key, value in (table.schema.metadata or {}).items()
        }
        header, used = _header(metadata, columns, table.rows)
        series = [one.series() for one in columns if one not in used and one.kind == "number"]
        return gather(series, header, path, start=start, stop=stop)


class _Column:
    def __init__(self, table: _Table, index: int, field: Any) -> None:
        import pyarrow.types as types

        self.table, self.index = table, index
        self.name, self.unit = split_header_cell(field.name)
        metadata = {
            key.decode().casefold(): value.decode("utf-8", "replace") for key, value in (field.metadata or {}).items()
        }
        self.unit = metadata.get("unit") or metadata.get("units") or self.unit
        self.kind = "other"
        if types.is_floating(field.type) or types.is_integer(field.type):
            self.kind = "number"
        elif types.is_timestamp(field.type) or types.is_duration(field.type):
            self.kind = "stamp"

    def load(self, start: int, stop: int) -> np.ndarray:
        values = self.table.column(self.index, start, stop).to_numpy(zero_copy_only=False)
        return values.astype("timedelta64[ns]").astype(np.int64) * 1e-9 if values.dtype.kind == "m" else values

    def seconds(self, start: int, stop: int) -> np.ndarray:
        values = self.load(start, stop)
        if values.dtype.kind == "M":
            return values.astype("datetime64[ns]").astype(np.int64) * 1e-9
        values = np.asarray(values, dtype=np.float64)
        scale = seconds_per(self.unit) or (epoch_scale(float(values[0])) if values.size else 1.0)
        return values * (scale if self.kind == "number" else 1.0)

    def series(self) -> StoredSeries:
        return StoredSeries(self.name, self.table.rows, self.load, self.unit)


def _header(metadata: dict[str, str], columns: list[_Column], rows: int) -> tuple[Header, list[_Column]]:
    rate = next((positive(value) for key, value in metadata.items() if is_rate(key) or key == "rate"), None)
    speed = next((positive(value) for key, value in metadata.items() if is_speed(key)), None)
    label = next((value for key, value in metadata.items() if is_label(key)), None)
    warnings: tuple[str, ...] = ()
    used = [one for one in columns if one.kind == "stamp" or is_time(one.name)]
    notes = {key: value[:200] for key, value in metadata.items() if key not in ("pandas", "ARROW:schema")}
    for one in columns:
        if one not in used and is_index(one.name) and is_row_count(np.asarray(one.load(0, min(rows, 1000)))):
            used.append(one)
    times = [one for one in used if one.kind == "stamp" or is_time(one.name)]
    if times and rows > 1:
        head = times[0].seconds(0, min(rows, _STAMPS_CHECKED))
        found, warnings = rate_from_times(head)
        if rows > head.size and found is not None:
            found = (rows - 1) / float(times[0].seconds(rows - 1, rows)[0] - head[0])
        if rate is not None and found is not None and abs(found - rate) > 0.01 * rate:
            warnings = (
                *warnings,
                f"The file states {rate:g} Hz but its time column gives {found:g} Hz; {rate:g} Hz is used.",
            )
        rate = rate or found
    return Header(rate_hz=rate, speed_rpm=speed, label=label, warnings=warnings, notes=notes), used


class _Table:
    """Columns of an open table by row range; subclasses say how a range is fetched."""

    schema: Any
    rows: int

    def column(self, index: int, start: int, stop: int) -> Any:
        raise NotImplementedError

    def __enter__(self) -> _Table:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        raise NotImplementedError


def _parquet(path: Path) -> _Table:
    import pyarrow as pa
    import pyarrow.parquet as pq

    class Parquet(_Table):
        def __init__(self) -> None:
            self.file = pq.ParquetFile(path)
            self.schema = self.file.schema_arrow
            self.rows = self.file.metadata.num_rows
            sizes = [self.file.metadata.row_group(index).num_rows for index in range(self.file.num_row_groups)]
            self.edges = np.concatenate([[0], np.cumsum(sizes)]).astype(int)

        def column(self, index: int, start: int, stop: int) -> Any:
            groups = [g for g in range(len(self.edges) - 1) if self.edges[g] < stop and self.edges[g + 1] > start]
            field = self.schema.field(index)
            if not groups:
                return pa.array([], type=field.type)
            values = self.file.read_row_groups(groups, columns=[field.name]).column(0)
            offset = start - int(self.edges[groups[0]])
            return values.slice(offset, stop - start)

        def close(self) -> None:
            self.file.close()

    return Parquet()


def _feather(path: Path) -> _Table:
    from pyarrow import feather

    class Feather(_Table):
        def __init__(self) -> None:
            self.table = feather.read_table(path, memory_map=True)
            self.schema = self.table.schema
            self.rows = self.table.num_rows

        def column(self, index: int, start: int, stop: int) -> Any:
            return self.table.column(index).slice(start, stop - start)

        def close(self) -> None:
            del self.table

    return Feather()
