"""HDF5: a dataset a channel with name and unit, rate, speed and label as attributes of the file."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

from ..recording import Recording

NAME = "hdf5"
SUFFIXES = (".h5", ".hdf5", ".hdf")


def write(recording: Recording, path: Path, *, notes: Mapping[str, str]) -> None:
    """Write the datasets, numbered so that their order is the channels'."""
    import h5py

    width = len(str(len(recording.channels)))
    # Through memory: on a full disk the library itself fails when it closes the file, and takes Python with it.
    whole = io.BytesIO()
    with h5py.File(whole, "w") as file:
        file.attrs["rate_hz"] = recording.rate_hz
        if recording.condition.speed_rpm is not None:
            file.attrs["speed_rpm"] = recording.condition.speed_rpm
        if recording.label:
            file.attrs["label"] = recording.label
        for number, (one, row) in enumerate(zip(recording.channels, recording.signals, strict=True), start=1):
            dataset = file.create_dataset(f"channel_{number:0{width}d}", data=row, compression="gzip", shuffle=True)
            dataset.attrs["name"] = one.name
            if one.unit:
                dataset.attrs["unit"] = one.unit
        for key, text in notes.items():
            # Not attributes: those hold 64 KiB only.
            file.create_dataset(key, data=text)
    path.write_bytes(whole.getbuffer())
