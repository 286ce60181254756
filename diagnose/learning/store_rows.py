"""Rows of a dataset as recordings: channels, tacho, nameplate and speed, as a measured file would have them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...datasets.generate_table import channels_of
from ...datasets.recording import Channel, Nameplate, OperatingCondition, Recording
from ...datasets.simulated import TACHO, nameplate_of
from ...datasets.store import Store
from ...simulators.machine import machine_from_toml

_DIRECTIONS = {"x": "horizontal", "y": "vertical", "axial": "axial"}
_SIGNAL = "signal."


@dataclass(frozen=True)
class RowGroup:
    """A piece of a dataset that is read at once: part and row group within it."""

    part: int
    group: int


def row_groups(store: Store) -> list[RowGroup]:
    """Return the pieces of all parts, in order; a damaged one is a StoreError."""
    return [RowGroup(number, group) for number in store.numbers() for group in range(store.groups(number))]


def rows(store: Store, piece: RowGroup) -> Iterator[dict[str, Any]]:
    """Yield the rows of one piece as mappings, channels as arrays."""
    table = store.group(piece.part, piece.group)
    signals = [name for name in table.column_names if name.startswith(_SIGNAL)]
    labels = table.drop_columns(signals).to_pylist()
    for index, row in enumerate(labels):
        for name in signals:
            value = table.column(name)[index].values  # type: ignore[union-attr]
            row[name] = None if value is None else value.to_numpy(zero_copy_only=False)
        yield row


def recording_of(
    row: Mapping[str, Any], channels: Mapping[str, Mapping[str, str]], *, hint_error: float = 0.0, tacho: bool = True
) -> Recording:
    """Return a row as a recording.

    Parameters
    ----------
    row : mapping
        As `rows` gives it.
    channels : mapping
        What the dataset says of its channels, as `channels_of` gives it.
    hint_error : float
        Relative error of the nominal speed: real nameplates are not exact. Drawn evenly within plus and minus it, from
        the row's own seed.
    tacho : bool
        False leaves the tacho away.
    """
    kept = [name for name in channels if row.get(_SIGNAL + name) is not None and (tacho or name != TACHO)]
    stream = np.random.default_rng([int(row["seed"]), 1])
    hint = row["speed_rpm"] * (1.0 + hint_error * stream.uniform(-1.0, 1.0))
    return Recording(
        np.array([row[_SIGNAL + name] for name in kept], dtype=float),
        float(row["rate_hz"]),
        tuple(_channel(name, channels[name]) for name in kept),
        condition=OperatingCondition(speed_rpm=hint, load=row["load"], load_unit=row["load_unit"]),
        nameplate=_nameplate(row),
        label=row["label"],
        pulses_per_revolution=row["pulses_per_revolution"] or 1.0,
    )


def _channel(name: str, said: Mapping[str, str]) -> Channel:
    if name == TACHO:
        return Channel(TACHO, "tacho", stored_unit="V")
    return Channel(
        name,
        said["quantity"],  # type: ignore[arg-type]
        said["location"],
        _DIRECTIONS.get(said["direction"]),  # type: ignore[arg-type]
        said["unit"],
    )


def _nameplate(row: Mapping[str, Any]) -> Nameplate:
    # Only machines with an electrical fault know a supply in the simulation: it would give the label away.
    return replace(nameplate_of(machine_from_toml(row["machine_toml"])), line_frequency_hz=None)


__all__ = ["RowGroup", "channels_of", "recording_of", "row_groups", "rows"]
