"""Where classifiers get their rows from: a dataset, a feature file, or recordings with labels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...datasets.metadata import Metadata
from ...datasets.reading import read_blocks
from ...datasets.store import IDENTITY, open_store
from ...simulators.errors import InvalidValueError
from ..compare import comparable
from ..observe import Observation, observe
from ..result import FAULTS
from .changes import model_features
from .fault_names import HEALTHY
from .feature_file import is_feature_file, read_features
from .feature_table import FeatureTable, feature_table
from .machine_noise import MachineNoise
from .relative_features import levels, relative_features

#: Relative error of nominal speeds in training: nameplates of induction motors are off by their slip.
HINT_ERROR = 0.03
_BLOCK_SAMPLES = 1 << 19


def is_dataset(location: str) -> bool:
    """Return whether a location is a dataset rather than recordings."""
    return "://" in location or (Path(location) / IDENTITY).is_file()


def holds_rows(location: str) -> bool:
    """Return whether a location is a dataset or a feature file, not recordings, of which some are Parquet too."""
    if is_dataset(location):
        return True
    path = Path(location)
    # What is missing or cannot be opened is told when it is read.
    with suppress(OSError):
        return path.suffix == ".parquet" and path.is_file() and is_feature_file(path)
    return False


def rows_to_learn(
    location: str, *, seed: int, workers: int, noise: bool, tell: Callable[[int, int], None]
) -> tuple[FeatureTable, dict[str, Any]]:
    """Return relative features, levels and the rules' answers for a dataset or a feature file, and their origin.

    Parameters
    ----------
    location : str
        Dataset (folder or address), or a Parquet file that `write_features` made.
    seed : int
        Of the machines' noise; a feature file has its own.
    workers : int
    noise : bool
        Whether the noise of machines is added to the simulated signals.
    tell : callable
        Called with pieces done and in all.
    """
    if location.endswith(".parquet"):
        return read_features(Path(location))
    store = open_store(location)
    table = feature_table(
        store,
        kinds=("relative", "levels", "rules"),
        workers=workers,
        hint_error=HINT_ERROR,
        tacho=False,
        noise=MachineNoise(seed) if noise else None,
        tell=tell,
    )
    recipe = store.recipe
    return table, {
        "recipe": recipe.name,
        "meaning": recipe.meaning,
        "fingerprint": recipe.fingerprint,
        "recipe_seed": recipe.seed,
        "noise_seed": seed if noise else None,
        "hint_error": HINT_ERROR,
        "signals": len(table),
        "left_out": len(table.left_out),
        "limits": list(recipe.limits),
        "rotorwise": store.version,
    }


@dataclass(frozen=True, eq=False)
class FileRow:
    """A recording as a classifier takes it.

    Attributes
    ----------
    path : str
    values : array (features,)
        None where it does not turn or has no speed; ``reason`` says so.
    label : str or None
        Its fault, where the file, its sidecar or the user says it.
    speed_rpm, load : float
        NaN where unknown.
    """

    path: str
    values: np.ndarray | None
    label: str | None
    speed_rpm: float
    load: float
    reason: str = ""


def file_row(
    path: Path,
    *,
    metadata: Metadata | None = None,
    sidecar: Path | None = None,
    baseline: Sequence[Observation] = (),
    label: str | None = None,
) -> FileRow:
    """Return one recording, its first 20 s or so, as a row.

    Raises
    ------
    RotorwiseError
        When the file cannot be read or lacks what is never guessed.
    """
    now = observation_of(path, metadata=metadata, sidecar=sidecar)
    said = label_of(label if label is not None else now.recording.label)
    load = now.recording.condition.load
    if now.speed is None or not now.turning:
        return FileRow(str(path), None, said, np.nan, np.nan, "not turning, or no speed found")
    before = next((one for one in baseline if comparable(now, one)), None)
    values = model_features(described(now), None if before is None else described(before))
    return FileRow(str(path), values, said, now.speed.speed_rpm, np.nan if load is None else load)


def described(observation: Observation) -> dict[str, float]:
    """Return what `model_features` needs of a recording."""
    return relative_features(observation) | levels(observation)


def observation_of(path: Path, *, metadata: Metadata | None = None, sidecar: Path | None = None) -> Observation:
    """Return the first block of a file, measured."""
    return observe(next(iter(read_blocks(path, metadata=metadata, sidecar=sidecar, block_samples=_BLOCK_SAMPLES))))


def label_of(text: str | None) -> str | None:
    """Return the fault that a label names, or None where it names none.

    Examples
    --------
    >>> label_of("Bearing outer race")
    'bearing_outer_race'
    >>> label_of("test 17") is None
    True
    """
    name = (text or "").strip().lower().replace(" ", "_").replace("-", "_")
    return name if name in (*FAULTS, HEALTHY) else None


def check_label(text: str | None) -> str | None:
    """Return a label that the user gave.

    Raises
    ------
    InvalidValueError
        When it is no fault.
    """
    found = label_of(text)
    if text is not None and found is None:
        raise InvalidValueError(f"Label {text!r}; allowed: {', '.join((HEALTHY, *FAULTS))}. Correct it.")
    return found
