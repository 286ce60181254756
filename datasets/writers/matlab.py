"""MATLAB 5: a column vector a channel, named after it, with ``rate_hz``, ``speed_rpm`` and ``label``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from ..errors import InvalidValueError
from ..recording import Recording
from ._names import safe_names

NAME = "mat"
SUFFIXES = (".mat",)

#: A version 5 file counts the bytes of a variable in 32 bits, signed.
_VARIABLE_BYTES = 2**31 - 1
_LONGEST_NAME = 31
#: Names of variables that mean something to the readers beside those that mean something in any format.
_MEANS_SOMETHING = re.compile(r"(?i)gs|load|provenance|rate|x\d+.*|data_?\d+|head_?\d+|speed_rpm|rate_hz")


def write(recording: Recording, path: Path, *, notes: Mapping[str, str]) -> None:
    """Write the variables; the format has no units, the sidecar has.

    Raises
    ------
    InvalidValueError
        For a channel longer than the format holds.
    """
    from scipy.io import savemat

    if recording.signals[0].nbytes > _VARIABLE_BYTES:
        raise InvalidValueError(
            f"{recording.samples} samples a channel as MATLAB 5; allowed: 2 GiB a channel. Write HDF5 instead."
        )
    names = variable_names([one.name for one in recording.channels])
    content: dict[str, object] = dict(zip(names, recording.signals, strict=True))
    content["rate_hz"] = recording.rate_hz
    if recording.condition.speed_rpm is not None:
        content["speed_rpm"] = recording.condition.speed_rpm
    if recording.label:
        content["label"] = recording.label
    content.update(notes)
    # A handle, because scipy appends its suffix to any other path.
    with path.open("wb") as handle:
        savemat(handle, content, do_compression=True, oned_as="column")


def variable_names(names: list[str]) -> list[str]:
    """Return a different valid MATLAB name for each channel that no reader takes for a time axis or a rate.

    Examples
    --------
    >>> variable_names(["bearing 1 x", "time", "9 o'clock", "bearing_1_x"])
    ['bearing_1_x', 'channel_2', 'channel_3', 'channel_4']
    """
    made: list[str] = []
    for number, name in enumerate(safe_names(names), start=1):
        plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")[:_LONGEST_NAME]
        fits = re.fullmatch(r"[A-Za-z]\w*", plain, flags=re.ASCII) and not _MEANS_SOMETHING.fullmatch(plain)
        made.append(plain if fits and plain not in made else f"channel_{number}")
    return made
