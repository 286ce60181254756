"""NPZ: ``signals`` (channels, samples), rate, names, units, speed, label, compressed."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..recording import Recording

NAME = "npz"
SUFFIXES = (".npz",)


def write(recording: Recording, path: Path, *, notes: Mapping[str, str]) -> None:
    """Write the arrays; texts become arrays of one text."""
    arrays: dict[str, np.ndarray] = {
        "signals": recording.signals,
        "rate_hz": np.array(recording.rate_hz),
        "channel_names": np.array([one.name for one in recording.channels]),
        "units": np.array([one.unit or "" for one in recording.channels]),
    }
    if recording.condition.speed_rpm is not None:
        arrays["speed_rpm"] = np.array(recording.condition.speed_rpm)
    if recording.label:
        arrays["label"] = np.array(recording.label)
    arrays.update({key: np.array(text) for key, text in notes.items()})
    # Through memory: on a full disk the archive complains once more when it is let go.
    whole = io.BytesIO()
    np.savez_compressed(whole, allow_pickle=False, **arrays)  # pyright: ignore[reportArgumentType]
    path.write_bytes(whole.getbuffer())
