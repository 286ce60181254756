"""Files to recordings: find the reader, apply the metadata, convert to SI."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ._channels import Described, describe_channels
from .errors import InvalidValueError, MissingMetadataError, UnreadableFileError
from .file_content import FileContent
from .metadata import Metadata
from .readers import all_readers, content_blocks, find_reader, read_content
from .recording import OperatingCondition, Provenance, Recording
from .sidecar import find_sidecar, read_sidecar

#: Difference between two stated rates that is worth a warning.
_RATES_AGREE = 0.01
#: Outside this range a rate is more likely a wrong unit than a vibration measurement.
_USUAL_RATE_HZ = (50.0, 5e6)

_NOT_RECORDINGS = {".toml", ".html", ".htm", ".json", ".md", ".pdf", ".png", ".jpg", ".tdms_index", ".py"}

Paths = Sequence[Path | str]


def read(
    path: Path | str,
    *,
    metadata: Metadata | None = None,
    sidecar: Path | str | None = None,
    start: int = 0,
    stop: int | None = None,
) -> Recording:
    """Read one file as a recording in SI units.

    Parameters
    ----------
    path : path
        File in any format that ``rotorwise.datasets.readers`` knows; its content decides, not its suffix.
    metadata : Metadata, optional
        What the user knows; wins over the sidecar, which wins over the file.
    sidecar : path, optional
        Sidecar file; see :mod:`rotorwise.datasets.sidecar` for where one is looked for otherwise.
    start, stop : int
        First sample and one past the last, per channel.

    Returns
    -------
    Recording
        ``signals`` of shape (channels, samples), in SI units where the unit is known, as stored where not.

    Raises
    ------
    UnreadableFileError
        When the file is missing, foreign, truncated or corrupted.
    MissingMetadataError
        When the sampling rate is neither in the file nor given.
    InvalidValueError
        When the metadata does not fit the file.
    """
    path = Path(path)
    merged = _merged(path, metadata, sidecar)
    reader = find_reader(path).NAME
    content = read_content(path, start=start, stop=stop)
    return _recording(content, merged, path, reader)


def read_blocks(
    path: Path | str,
    *,
    block_samples: int,
    metadata: Metadata | None = None,
    sidecar: Path | str | None = None,
    overlap: int = 0,
) -> Iterator[Recording]:
    """Yield one file as consecutive recordings of ``block_samples`` samples, in bounded memory.

    Parameters
    ----------
    path, metadata, sidecar
        As for :func:`read`.
    block_samples : int
        Samples per channel in a block; the last block may be shorter.
    overlap : int
        Samples that a block repeats from the one before; below ``block_samples``.

    Yields
    ------
    Recording
        ``provenance.total_samples`` is the file's length when the format states it.

    Raises
    ------
    UnreadableFileError, MissingMetadataError, InvalidValueError
        As for :func:`read`, when the first block is asked for.
    """
    path = Path(path)
    if not (block_samples >= 1 and 0 <= overlap < block_samples):
        raise InvalidValueError(
            f"Blocks of {block_samples} samples with overlap {overlap}; allowed: 1 or more samples, 0 <= "
            "overlap < samples."
        )
    merged = _merged(path, metadata, sidecar)
    reader = find_reader(path).NAME
    for content in _regrouped(content_blocks(path, block_samples=block_samples), block_samples, overlap):
        yield _recording(content, merged, path, reader)


def find_recordings(paths: Paths, *, recursive: bool = False) -> tuple[list[Path], list[Path]]:
    """Return (recordings, files left out) for files and folders.

    A file that is named is a recording, whatever it is: reading it then says what is wrong. Of a folder the
    files that a reader recognises are taken, sorted by name, and those with a suffix that only recordings have
    (a damaged WAV), or an empty file with any that they have; sidecars, reports, documents and hidden files are
    passed over, and any other file goes to the second list, for the caller to tell.

    Raises
    ------
    UnreadableFileError
        When a path does not exist.
    """
    found: list[Path] = []
    left_out: list[Path] = []
    for item in map(Path, paths):
        if not item.is_dir():
            if not item.exists():
                raise UnreadableFileError(f"{item}: no such file or folder. Check the name.")
            found.append(item)
            continue
        for file in _files_of(item, recursive=recursive):
            try:
                find_reader(file)
            except UnreadableFileError:
                # An empty file is one that is still being written, or was not copied.
                known = _suffixes() if not file.stat().st_size else _only_recordings()
                (found if file.suffix.casefold() in known else left_out).append(file)
            else:
                found.append(file)
    return found, left_out


def _suffixes() -> set[str]:
    return {suffix for reader in all_readers() for suffix in reader.SUFFIXES}


def _only_recordings() -> set[str]:
    """Return the suffixes that no table of notes has: those of the readers of anything but text."""
    return {suffix for reader in all_readers() if not getattr(reader, "IS_TEXT", False) for suffix in reader.SUFFIXES}


def _files_of(folder: Path, *, recursive: bool) -> Iterator[Path]:
    for root, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if recursive and not name.startswith("."))
        for name in sorted(files):
            file = Path(root) / name
            if not name.startswith(".") and file.suffix.casefold() not in _NOT_RECORDINGS:
                yield file


def _merged(path: Path, metadata: Metadata | None, sidecar: Path | str | None) -> Metadata:
    metadata = metadata or Metadata()
    found = find_sidecar(path, sidecar)
    return metadata if found is None else metadata.merged_over(read_sidecar(found, path))


@dataclass(frozen=True)
class _Rate:
    value: float
    warnings: tuple[str, ...]


def _recording(content: FileContent, metadata: Metadata, path: Path, reader: str) -> Recording:
    rate = _rate(content, metadata, path)
    described: Described = describe_channels(content, metadata, path)
    condition = OperatingCondition(
        speed_rpm=content.speed_rpm if metadata.speed_rpm is None else metadata.speed_rpm,
        load=content.load if metadata.load is None else metadata.load,
        load_unit=metadata.load_unit or (content.load_unit if metadata.load is None else None),
        temperature_celsius=metadata.temperature_celsius,
    )
    return Recording(
        signals=described.signals,
        rate_hz=rate.value,
        channels=described.channels,
        condition=condition,
        nameplate=metadata.nameplate,
        label=metadata.label or content.label,
        provenance=Provenance(str(path), reader, content.start_sample, content.total_samples),
        warnings=(*content.warnings, *rate.warnings, *described.warnings),
        pulses_per_revolution=metadata.pulses_per_revolution or 1.0,
    )


def _rate(content: FileContent, metadata: Metadata, path: Path) -> _Rate:
    rate = metadata.rate_hz or content.rate_hz
    if rate is None:
        raise MissingMetadataError(
            f"{path}: the file holds no sampling rate, and it is never guessed. Give it with --rate HZ, or "
            "as "
            f"rate_hz = HZ under [recording] in {path.parent / 'recording.toml'}."
        )
    warnings: list[str] = []
    if content.rate_hz and abs(rate - content.rate_hz) > _RATES_AGREE * content.rate_hz:
        warnings.append(
            f"The given sampling rate {rate:g} Hz contradicts the file's {content.rate_hz:g} Hz; {rate:g} "
            "Hz is used. "
            "Every frequency scales with it."
        )
    if not _USUAL_RATE_HZ[0] <= rate <= _USUAL_RATE_HZ[1]:
        warnings.append(
            f"A sampling rate of {rate:g} Hz is unusual for vibration. Check it, and the unit of the time "
            "column if there is one."
        )
    return _Rate(float(rate), tuple(warnings))


def _regrouped(blocks: Iterator[FileContent], size: int, overlap: int) -> Iterator[FileContent]:
    """Yield blocks of ``size`` samples of which the first ``overlap`` repeat the end of the block before."""
    if overlap == 0:
        yield from blocks
        return
    held: FileContent | None = None
    fresh = False
    for block in blocks:
        if held is not None:
            joined = np.concatenate([held.signals, block.signals], axis=1)
            block = replace(block, signals=joined, start_sample=held.start_sample)
        held, fresh = block, True
        while held.samples >= size:
            yield replace(held, signals=held.signals[:, :size])
            advance = size - overlap
            held = replace(held, signals=held.signals[:, advance:], start_sample=held.start_sample + advance)
            fresh = held.samples > overlap
    if held is not None and fresh:
        yield held
