"""Tables of features as Parquet files: small enough to ship, and readable without us."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...simulators.errors import RotorwiseError
from .. import output_file
from ..output_file import OutputKind
from .feature_table import FeatureTable

if TYPE_CHECKING:
    import pyarrow as pa

FORMAT = 1
_KEY = b"rotorwise features"
#: Columns that learning needs beside features; the rest stays in the dataset.
_KEPT = ("signal", "machine", "group", "split", "case", "speed_rpm", "load", "rate_hz")
#: Without these nothing can be learned or judged.
_WORDS, _NUMBERS = ("label", "machine", "group", "split", "case"), ("speed_rpm", "load")
#: Significant binary digits of a feature: about four decimal ones, below what any repeat reproduces.
_BITS = 12


class FeatureFileError(RotorwiseError):
    """A feature file cannot be read."""


class FeaturePlaceError(FeatureFileError):
    """A feature file cannot be written where it was asked for."""


def features_bytes(table: FeatureTable, origin: Mapping[str, Any]) -> bytes:
    """Return a table as the bytes of a Parquet file, features rounded to four digits; ``origin`` goes along as JSON."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    kept = [name for name in table.columns if name in _KEPT or name.startswith("severity.")]
    columns = {"label": pa.array(table.labels.tolist())}
    for name in kept:
        values = table.columns[name]
        columns[name] = pa.array(values.astype(np.float32) if values.dtype.kind == "f" else values)
    for place, name in enumerate(table.names):
        columns[f"feature.{name}"] = pa.array(_rounded(table.values[:, place]))
    said = {_KEY: json.dumps({"format": FORMAT, "origin": dict(origin)}, sort_keys=True).encode()}
    sink = pa.BufferOutputStream()
    pq.write_table(
        pa.table(columns).replace_schema_metadata(said), sink, compression="zstd", compression_level=19, version="2.6"
    )
    return sink.getvalue().to_pybytes()


def _rounded(values: np.ndarray) -> np.ndarray:
    mantissa, exponent = np.frexp(values.astype(float))
    return np.ldexp(np.round(mantissa * 2**_BITS) / 2**_BITS, exponent).astype(np.float32)


def write_features(table: FeatureTable, path: str | Path, origin: Mapping[str, Any], *, force: bool = False) -> None:
    """Write a table, whole or not at all.

    Raises
    ------
    FeaturePlaceError
        When the file exists and ``force`` is not set, is none of ours, or the place cannot be written to.
    """
    output_file.write_checked(Path(path), features_bytes(table, origin), KIND, force=force)


def check_place(target: Path, *, force: bool) -> None:
    """Raise FeaturePlaceError where a feature file cannot go."""
    output_file.check_place(target, KIND, force=force)


def read_features(source: Path | bytes) -> tuple[FeatureTable, dict[str, Any]]:
    """Return the table in a file, or in the bytes of one, and its origin.

    Raises
    ------
    FeatureFileError
        When it is no feature file.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    name = "The feature file" if isinstance(source, bytes) else str(source)
    try:
        found = pq.read_table(pa.BufferReader(source) if isinstance(source, bytes) else source)
        said = json.loads((found.schema.metadata or {})[_KEY])
    except (pa.ArrowException, OSError, KeyError, ValueError):
        raise FeatureFileError(
            f"{name} is no feature file of rotorwise. Make one: rotorwise train STORE --features FILE.parquet"
        ) from None
    if not isinstance(said, dict) or said.get("format") != FORMAT or not isinstance(said.get("origin"), dict):
        found_format = said.get("format") if isinstance(said, dict) else said
        raise FeatureFileError(f"{name} has format {found_format}; allowed: {FORMAT}, with its origin. Make it again.")
    _check_content(found, name)
    names = [column for column in found.column_names if column.startswith("feature.")]
    values = np.array([found.column(column).to_numpy() for column in names], dtype=float).T
    others = [column for column in found.column_names if column not in names and column != "label"]
    return FeatureTable(
        values,
        tuple(name.removeprefix("feature.") for name in names),
        np.array(found.column("label").to_pylist()),
        {column: _column(found.column(column).to_pylist()) for column in others},
    ), said["origin"]


def _check_content(found: pa.Table, name: str) -> None:
    missing = [column for column in (*_WORDS, *_NUMBERS) if column not in found.column_names]
    if missing or not found.num_rows:
        what = f"lacks {', '.join(missing)}" if missing else "has no row"
        raise FeatureFileError(
            f"{name} {what}; allowed: a file as rotorwise train --features writes it. Make it again."
        )
    for column in _WORDS:
        wrong = [value for value in found.column(column).to_pylist() if not isinstance(value, str) or not value]
        if wrong:
            raise FeatureFileError(f"{name} has {wrong[0]!r} as {column}; allowed: a word. Make it again.")
    for column in found.column_names:
        if column in _NUMBERS or column.startswith("feature."):
            _check_numbers(found.column(column), column, name)


def _check_numbers(values: pa.ChunkedArray, column: str, name: str) -> None:
    import pyarrow as pa

    wrong = (
        f"of type {values.type}" if not (pa.types.is_floating(values.type) or pa.types.is_integer(values.type)) else ""
    )
    if not wrong:
        numbers = values.to_numpy().astype(float)
        bad = numbers[np.isinf(numbers) | ((numbers <= 0) if column == "speed_rpm" else False)]
        wrong = f"= {bad[0]:g}" if bad.size else ""
    if wrong:
        allowed = "speeds above 0" if column == "speed_rpm" else "finite numbers, and NaN where a record cannot say"
        raise FeatureFileError(f"{name} has {column} {wrong}; allowed: {allowed}. Make it again.")


def _column(values: list[Any]) -> np.ndarray:
    if any(isinstance(value, str) for value in values):
        return np.array(["" if value is None else value for value in values])
    return np.array([np.nan if value is None else value for value in values])


def is_feature_file(path: Path) -> bool:
    """Return whether a Parquet file says that it holds features; recordings may be Parquet too.

    Raises
    ------
    OSError
        When it cannot be read.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return _KEY in (pq.read_schema(path).metadata or {})
    except pa.ArrowException:
        return False


KIND = OutputKind(
    name="feature file",
    content="feature file of rotorwise",
    example="features.parquet",
    is_ours=is_feature_file,
    error=FeaturePlaceError,
)
