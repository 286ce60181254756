"""Recordings to files that the readers here read back: CSV with its rate and units, and NPZ."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from .errors import InvalidValueError
from .recording import Recording


def write_csv(recording: Recording, path: Path | str, *, force: bool = False) -> Path:
    """Write a recording as CSV: lines ``# key: value``, a header ``name (unit)``, one row a sample, SI units.

    Digits are enough to read back exactly the same numbers. A tacho channel comes back as one when its name
    says so (tacho, keyphasor).

    Parameters
    ----------
    recording : Recording
        What to write.
    path : path
        File to write.
    force : bool
        Replace an existing file.

    Raises
    ------
    InvalidValueError
        When the file exists and ``force`` is not set, or the folder is missing.
    """
    path = _free(Path(path), force=force)
    head = [f"# rate_hz: {recording.rate_hz!r}"]
    if recording.condition.speed_rpm is not None:
        head.append(f"# speed_rpm: {recording.condition.speed_rpm!r}")
    if recording.label:
        head.append(f"# label: {' '.join(recording.label.split())}")
    titles = [f"{_plain(one.name)} ({one.unit})" if one.unit else _plain(one.name) for one in recording.channels]
    digits = "%.9g" if recording.signals.dtype == np.float32 else "%.17g"
    with path.open("w", encoding="utf-8", newline="\n") as handle:
        handle.write("\n".join([*head, ",".join(titles)]) + "\n")
        np.savetxt(handle, recording.signals.T, fmt=digits, delimiter=",")
    return path


def write_npz(recording: Recording, path: Path | str, *, force: bool = False) -> Path:
    """Write a recording as compressed NPZ: ``signals`` (channels, samples), rate, names, units, speed, label.

    Raises
    ------
    InvalidValueError
        As for :func:`write_csv`.
    """
    path = Path(path)
    path = _free(path if path.suffix == ".npz" else path.with_name(path.name + ".npz"), force=force)
    arrays: dict[str, np.ndarray] = {
        "signals": recording.signals,
        "rate_hz": np.float64(recording.rate_hz),  # pyright: ignore[reportAssignmentType]
        "channel_names": np.array([one.name for one in recording.channels]),
        "units": np.array([one.unit or "" for one in recording.channels]),
    }
    if recording.condition.speed_rpm is not None:
        arrays["speed_rpm"] = np.array(recording.condition.speed_rpm)
    if recording.label:
        arrays["label"] = np.array(recording.label)
    np.savez_compressed(path, allow_pickle=False, **arrays)  # pyright: ignore[reportArgumentType]
    return path


def _plain(name: str) -> str:
    # Separators and brackets in a name would be read back as further columns or as a unit.
    return re.sub(r"[,;|\t\r\n\"()\[\]#%]+", " ", name).strip() or "channel"


def _free(path: Path, *, force: bool) -> Path:
    if path.exists() and not force:
        raise InvalidValueError(f"{path} exists already. Give another name, or force (--force) to replace it.")
    if not path.parent.is_dir():
        raise InvalidValueError(f"Folder {path.parent} does not exist. Make it first, or give another.")
    return path
