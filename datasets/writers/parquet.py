"""Parquet: one column a channel with its unit, the rest as metadata of the table."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..recording import Recording
from ._names import safe_names

NAME = "parquet"
SUFFIXES = (".parquet",)


def write(recording: Recording, path: Path, *, notes: Mapping[str, str]) -> None:
    """Write the table."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    said = {"rate_hz": repr(recording.rate_hz), **notes}
    if recording.condition.speed_rpm is not None:
        said["speed_rpm"] = repr(recording.condition.speed_rpm)
    if recording.label:
        said["label"] = recording.label
    names = safe_names([one.name for one in recording.channels])
    fields = [
        pa.field(name, pa.from_numpy_dtype(row.dtype), metadata={"unit": one.unit} if one.unit else None)
        for name, one, row in zip(names, recording.channels, recording.signals, strict=True)
    ]
    arrays = [pa.array(row) for row in recording.signals]
    pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields, metadata=said)), path)
