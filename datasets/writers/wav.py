"""WAV in floating point: SI values as they are, so nothing is clipped. Names and units stand in the sidecar."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..errors import InvalidValueError
from ..recording import Recording

NAME = "wav"
SUFFIXES = (".wav",)

#: RIFF counts bytes in 32 bits; beyond, RF64 is written, which readers of long sound files know.
_RIFF_BYTES = 4_000_000_000
_MOST_CHANNELS = 1024


def write(recording: Recording, path: Path, *, notes: Mapping[str, str]) -> None:
    """Write the samples; the header holds a whole number of Hz, the sidecar the exact rate.

    Raises
    ------
    InvalidValueError
        For a rate under 1 Hz, more channels than the format holds, or a file that cannot be written.
    """
    import soundfile

    rate, channels = round(recording.rate_hz), len(recording.channels)
    if rate < 1 or channels > _MOST_CHANNELS:
        raise InvalidValueError(
            f"{channels} channels at {recording.rate_hz:g} Hz as WAV; allowed: up to {_MOST_CHANNELS} channels, 1 Hz "
            "or more. Write HDF5 instead."
        )
    single = recording.signals.dtype == np.float32
    header = "RF64" if recording.signals.nbytes > _RIFF_BYTES else "WAV"
    try:
        with soundfile.SoundFile(
            str(path), "w", rate, channels, subtype="FLOAT" if single else "DOUBLE", format=header
        ) as sound:
            if notes:
                sound.comment = json.dumps(dict(notes))
            sound.write(np.ascontiguousarray(recording.signals.T))
    except (soundfile.LibsndfileError, AssertionError) as problem:
        # A full disk shows as either: the library only counts the samples that it could not write.
        said = str(problem).rstrip(". ") or "not all samples were written"
        raise InvalidValueError(
            f"WAV in {path.parent} cannot be written: {said} (is the disk full?). Choose another place."
        ) from problem
