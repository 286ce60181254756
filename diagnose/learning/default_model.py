"""The model that `rotorwise analyse` uses: shipped as simulated features, fitted at first use, kept in a cache.

The cached file is named after the version of rotorwise, of what else decides its numbers, and the content of the
features: another one is another file. A cache that cannot be read or written costs the fit again, nothing else.
"""

from __future__ import annotations

import hashlib
import os
import sys
from contextlib import suppress
from functools import cache
from importlib.resources import files
from pathlib import Path

from .feature_file import read_features
from .model_file import Model, ModelFileError, load_model, model_bytes, model_versions
from .training import train

FEATURES = "default_features.parquet"
MODEL, SEED, ITERATIONS = "linear", 0, 60
#: Raised when the same features give another model than before.
TRAINING = 2


@cache
def default_model() -> Model:
    """Return the default model, from the cache or fitted now (seconds).

    Raises
    ------
    FeatureFileError
        When the shipped features are damaged.
    """
    content = files(__package__ or "rotorwise.diagnose.learning").joinpath(FEATURES).read_bytes()
    place = cache_folder() / f"default-{_key(content)}.skops"
    with suppress(ModelFileError, OSError):
        return load_model(place)
    table, origin = read_features(content)
    made = train(table, origin=origin, model=MODEL, seed=SEED, iterations=ITERATIONS, judge=False)
    with suppress(OSError):
        _keep(place, model_bytes(made))
    return made


def cache_folder() -> Path:
    """Return where fitted models are kept, as the system has it; ``ROTORWISE_CACHE`` overrules it."""
    if own := os.environ.get("ROTORWISE_CACHE"):
        return Path(own)
    if os.name == "nt":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "rotorwise" / "Cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "rotorwise"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "rotorwise"


def _key(content: bytes) -> str:
    decides = [
        TRAINING,
        *sorted(model_versions().items()),
        MODEL,
        SEED,
        ITERATIONS,
        hashlib.sha256(content).hexdigest(),
    ]
    return hashlib.sha256(repr(decides).encode()).hexdigest()[:20]


def _keep(place: Path, content: bytes) -> None:
    """Write a file whole or not at all; two processes may do it at once."""
    place.parent.mkdir(parents=True, exist_ok=True)
    draft = place.with_name(f".{place.name}.{os.getpid()}")
    try:
        draft.write_bytes(content)
        draft.replace(place)
    finally:
        draft.unlink(missing_ok=True)
