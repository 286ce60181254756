"""From stored series of one file to one recording: equal rate, equal length, only the samples asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..errors import UnreadableFileError
from ..file_content import FileContent
from ._names import unique_names


@dataclass(frozen=True, eq=False)
class StoredSeries:
    """One series of a file; ``load(start, stop)`` fetches samples of it, and nothing is fetched before."""

    name: str
    samples: int
    load: Callable[[int, int], np.ndarray]
    unit: str | None = None
    rate_hz: float | None = None


@dataclass(frozen=True)
class Header:
    """What a file says beside its samples."""

    rate_hz: float | None = None
    speed_rpm: float | None = None
    load: float | None = None
    load_unit: str | None = None
    label: str | None = None
    warnings: tuple[str, ...] = ()
    notes: Mapping[str, str] = field(default_factory=dict)


def starts_with(path: Path, magic: bytes) -> bool:
    """Whether a file begins with these bytes."""
    with path.open("rb") as handle:
        return handle.read(len(magic)) == magic


def gather(
    series: list[StoredSeries], header: Header, path: Path, *, start: int = 0, stop: int | None = None
) -> FileContent:
    """Return the largest group of series that share rate and length; the others are named in a warning.

    Raises
    ------
    UnreadableFileError
        When no series holds a sample.
    """
    chosen = largest_group([one for one in series if one.samples > 0])
    if not chosen:
        raise UnreadableFileError(
            f"{path} holds no numeric samples. Check that the export contains the signals, not only its header."
        )
    warnings = list(header.warnings)
    left_out = [one for one in series if one not in chosen]
    if left_out:
        names = ", ".join(f"{one.name} ({one.samples} samples)" for one in left_out[:8])
        more = f" and {len(left_out) - 8} more" if len(left_out) > 8 else ""
        warnings.append(f"Channels of another rate or length were left out: {names}{more}.")
    total = chosen[0].samples
    stop = total if stop is None else min(stop, total)
    start = min(start, total)
    signals = np.stack([as_float(one.load(start, max(start, stop))) for one in chosen])
    return FileContent(
        signals=signals,
        channel_names=unique_names([one.name for one in chosen]),
        units=tuple(one.unit for one in chosen),
        rate_hz=chosen[0].rate_hz or header.rate_hz,
        speed_rpm=header.speed_rpm,
        load=header.load,
        load_unit=header.load_unit,
        label=header.label,
        total_samples=total,
        start_sample=start,
        warnings=tuple(warnings),
        notes=header.notes,
    )


def largest_group(series: list[StoredSeries]) -> list[StoredSeries]:
    """Return the series of the (rate, length) that holds the most samples."""
    groups: dict[tuple[str, int], list[StoredSeries]] = {}
    for one in series:
        groups.setdefault((f"{one.rate_hz or 0:.9g}", one.samples), []).append(one)
    return max(groups.values(), key=lambda group: sum(one.samples for one in group), default=[])


def as_float(values: np.ndarray) -> np.ndarray:
    """Return float32 and float64 in native byte order as they are, anything else as float64."""
    values = np.asarray(values)
    return np.asarray(
        values, dtype=np.float32 if values.dtype.kind == "f" and values.dtype.itemsize <= 4 else np.float64
    )


def split_blocks(content: FileContent, block_samples: int) -> Iterator[FileContent]:
    """Yield a file that had to be loaded whole, block by block."""
    for start in range(0, content.samples, block_samples):
        yield replace(content, signals=content.signals[:, start : start + block_samples], start_sample=start)
