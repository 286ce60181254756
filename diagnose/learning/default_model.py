"""The model that `rotorwise analyse` uses: shipped as simulated features, fitted at first use, its arrays cached.

The cached file (`plain_model`) is named after the version of rotorwise, of what else decides its numbers, and the
content of the features: another one is another file. A cache that cannot be read or written costs the fit again,
nothing else. The model of scikit-learn is not kept: reading it back takes longer than the fit.
"""

from __future__ import annotations

import hashlib
import os
import sys
from contextlib import suppress
from functools import cache
from importlib.resources import files
from pathlib import Path

from .model_file import Model, ModelFileError, model_versions
from .plain_model import plain, plain_bytes, plain_from_bytes

FEATURES = "default_features.parquet"
MODEL, SEED, ITERATIONS = "linear", 0, 60
#: Raised when the same features give another model than before.
TRAINING = 2


@cache
def default_model() -> Model:
    """Return the default model, fitted now (a second or two).

    Raises
    ------
    FeatureFileError
        When the shipped features are damaged.
    """
    # Loaded here, as fitting needs scikit-learn and reading tables pyarrow.
    from .feature_file import read_features
    from .training import train

    table, origin = read_features(_content())
    return train(table, origin=origin, model=MODEL, seed=SEED, iterations=ITERATIONS, judge=False)


@cache
def plain_default_model() -> Model:
    """Return the default model as arrays: the same answers, without loading scikit-learn once they are cached."""
    place = cache_folder() / f"default-{_key(_content())}.npz"
    with suppress(OSError, ModelFileError):
        return plain_from_bytes(place.read_bytes())
    fitted = default_model()
    made = Model(plain(fitted.classifier), fitted.features, fitted.card)
    with suppress(OSError):
        _keep(place, plain_bytes(made))
    return made


def _content() -> bytes:
    return files(__package__ or "rotorwise.diagnose.learning").joinpath(FEATURES).read_bytes()


def cache_folder() -> Path:
    """Return where the fitted model is kept, as the system has it; ``ROTORWISE_CACHE`` overrules it."""
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
