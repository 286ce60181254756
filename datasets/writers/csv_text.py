"""CSV: lines ``# key: value``, a header ``name (unit)``, one row a sample."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..recording import Recording
from ._names import safe_names

NAME = "csv"
SUFFIXES = (".csv",)

#: Separators and brackets in a name would be read back as further columns or as a unit.
_UNWANTED = r"[,;|\t\r\n\"()\[\]#%]"


def write(recording: Recording, path: Path, *, notes: Mapping[str, str]) -> None:
    """Write rate, speed and label as comments, then the samples with digits enough for the same numbers."""
    head = [f"# rate_hz: {recording.rate_hz!r}"]
    if recording.condition.speed_rpm is not None:
        head.append(f"# speed_rpm: {recording.condition.speed_rpm!r}")
    if recording.label:
        head.append(f"# label: {' '.join(recording.label.split())}")
    head += [f"# {key}: {' '.join(text.split())}" for key, text in notes.items()]
    names = safe_names([one.name for one in recording.channels], unwanted=_UNWANTED)
    titles = [f"{name} ({one.unit})" if one.unit else name for name, one in zip(names, recording.channels, strict=True)]
    digits = "%.9g" if recording.signals.dtype == np.float32 else "%.17g"
    with path.open("w", encoding="utf-8", newline="\n") as handle:
        handle.write("\n".join([*head, ",".join(titles)]) + "\n")
        np.savetxt(handle, recording.signals.T, fmt=digits, delimiter=",")
