"""The table of a dataset: one row a signal, its labels and its channels, as Parquet. The schema is the recipe's."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .recipe import Recipe
from .recipe_draw import label_columns
from .simulated import TACHO, recordable
from .units import parse_unit

if TYPE_CHECKING:
    import pyarrow as pa

#: Signals in one row group, in bytes: what a reader that streams must hold.
ROW_GROUP_BYTES = 16_000_000
#: Key of the file's metadata under which our facts stand.
KEY = b"rotorwise"

#: Name, Arrow type, unit and meaning of the columns that every dataset has, before the chosen values and the channels.
FIXED = (
    ("signal", "int64", "", "number of the signal in the recipe, from 0"),
    ("machine", "string", "", "kind of machine"),
    ("group", "string", "", "machine draw: split by this, never by row"),
    ("split", "string", "", "of the machine draw"),
    ("case", "string", "", "name of the state in the recipe"),
    ("fault", "int32", "", "number of the fault within the case: same values, other speeds and loads"),
    ("record", "int32", "", "number of the signal within its run; each begins where the one before ends"),
    ("label", "string", "", "effects with place and values, or healthy"),
    ("effects", "list<string>", "", "names of the effects"),
    ("speed_rpm", "double", "rpm", "shaft speed"),
    ("load", "double", "", "load of the machine, in load_unit; null without one"),
    ("load_unit", "string", "", "unit of the load"),
    ("seed", "int64", "", "of the measuring chain"),
    ("rate_hz", "double", "Hz", "sampling rate"),
    ("samples", "int32", "", "length of each channel"),
    ("pulses_per_revolution", "double", "", "of the tacho, a turn of the reference shaft; null without one"),
    ("step_s", "double", "s", "integration step of the simulation"),
    ("notes", "list<string>", "", "limits that the motion passed, shortened steps"),
    ("chain", "string", "", "measuring chain, with all settings"),
    ("machine_toml", "string", "", "machine with all effects; rotorwise simulate reads it"),
)


def channels_of(recipe: Recipe) -> dict[str, dict[str, str]]:
    """Return name and description (unit, quantity, location, direction) of every channel in the table."""
    found: dict[str, dict[str, str]] = {}
    for one in recipe.machines:
        probes = one.machine.assembly(speed_rpm=one.speed_rpm.ends()[0]).probes
        for probe in recordable(probes, one.probes)[0]:
            unit = parse_unit(probe.unit)
            assert unit is not None
            found.setdefault(
                probe.name,
                {
                    "unit": probe.unit,
                    "quantity": unit.quantity,
                    "location": probe.location,
                    "direction": probe.direction,
                },
            )
    if "pulses_per_revolution" in recipe.chain and recipe.chain["pulses_per_revolution"].values[0] > 0:
        found[TACHO] = {"unit": "", "quantity": "tacho", "location": "", "direction": ""}
    return found


def schema_of(recipe: Recipe) -> pa.Schema:
    """Return the schema of a recipe's table; each field carries its unit and meaning."""
    import pyarrow as pa

    kinds = {
        "int32": pa.int32(),
        "int64": pa.int64(),
        "double": pa.float64(),
        "string": pa.string(),
        "list<string>": pa.list_(pa.string()),
    }
    fields = [pa.field(name, kinds[kind], metadata=_said(unit=unit, meaning=text)) for name, kind, unit, text in FIXED]
    fields += [pa.field(f"severity.{name}", pa.float64()) for name in recipe.severity]
    fields += [pa.field(name, pa.float64(), metadata=_said(unit=unit)) for name, unit in label_columns(recipe).items()]
    for name, said in channels_of(recipe).items():
        fields.append(pa.field(f"signal.{name}", pa.list_(pa.float32()), metadata=_said(**said)))
    return pa.schema(fields)


def _said(**words: str) -> dict[str, str] | None:
    return {key: text for key, text in words.items() if text} or None


def parquet_bytes(schema: pa.Schema, rows: Sequence[Mapping[str, Any]], facts: Mapping[str, Any]) -> bytes:
    """Return rows as the bytes of a Parquet file; the same rows give the same bytes.

    Parameters
    ----------
    schema : pyarrow.Schema
    rows : sequence of mapping
        By column; what is missing is null.
    facts : mapping
        Written as JSON into the file's metadata.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = schema.with_metadata({KEY: json.dumps(dict(facts), sort_keys=True)})
    signals = [one.name for one in schema if one.name.startswith("signal.")]
    sink = pa.BufferOutputStream()
    # Bytes of equal weight stand together: floating-point noise then becomes a tenth smaller, and faster.
    others = [one.name for one in schema if one.name not in signals]
    options: dict[str, Any] = {
        "use_dictionary": others,
        "use_byte_stream_split": [f"{name}.list.element" for name in signals],
        "write_statistics": others,
    }
    writer = pq.ParquetWriter(sink, schema, compression="zstd", compression_level=1, **options)
    size = sum(row[name].nbytes for row in rows for name in signals if name in row)
    count = max(1, int(len(rows) * ROW_GROUP_BYTES // size)) if size else max(1, len(rows))
    with writer:
        for start in range(0, len(rows), count):
            writer.write_table(_table(schema, rows[start : start + count]))
    return sink.getvalue().to_pybytes()


def _table(schema: pa.Schema, rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    import pyarrow as pa

    columns = []
    for one in schema:
        found = [row.get(one.name) for row in rows]
        columns.append(_lists(found) if one.name.startswith("signal.") else pa.array(found, one.type))
    return pa.Table.from_arrays(columns, schema=schema)


def _lists(found: Sequence[np.ndarray | None]) -> pa.Array:
    """Return arrays as lists of 32-bit numbers, without a Python object for each number."""
    import pyarrow as pa

    ends = np.cumsum([0, *(0 if one is None else one.size for one in found)])
    flat = np.concatenate([np.zeros(0, np.float32), *(one.astype(np.float32) for one in found if one is not None)])
    missing = np.array([one is None for one in found])
    return pa.ListArray.from_arrays(pa.array(ends, pa.int32()), pa.array(flat), mask=pa.array(missing))
