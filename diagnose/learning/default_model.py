"""The model that `rotorwise analyse` uses: shipped as simulated features, fitted at first use, kept in a cache.

The cached files, the model of scikit-learn and its arrays (`plain_model`), are named after the version of rotorwise, of
what else decides their numbers, and the content of the features: another one is another file. A cache that cannot be
read or written costs the fit again, nothing else.
"""

from __future__ import annotations

import hashlib
import os
import sys
from contextlib import suppress
from functools import cache
from importlib.resources import files
from pathlib import Path

from .model_file import Model, ModelFileError, load_model, model_bytes, model_versions
from .plain_model import plain, plain_bytes, plain_from_bytes

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
    content = _content()
    place = _place(content, "skops")
    with suppress(ModelFileError, OSError):
        return load_model(place)
    # Loaded here, as fitting needs scikit-learn and reading tables pyarrow.
    from .feature_file import read_features
    from .training import train

    table, origin = read_features(content)
    made = train(table, origin=origin, model=MODEL, seed=SEED, iterations=ITERATIONS, judge=False)
    with suppress(OSError):
        _keep(place, model_bytes(made))
    return made


@cache
def plain_default_model() -> Model:
    """Return the default model as arrays: the same answers, without loading scikit-learn once they are cached."""
    place = _place(_content(), "npz")
    with suppress(OSError, ModelFileError):
        return plain_from_bytes(place.read_bytes())
    fitted = default_model()
    made = Model(plain(fitted.classifier), fitted.features, fitted.card)
    with suppress(OSError):
        _keep(place, plain_bytes(made))
    return made


def _content() -> bytes:
    return files(__package__ or "rotorwise.diagnose.learning").joinpath(FEATURES).read_bytes()


def _place(content: bytes, ending: str) -> Path:
    return cache_folder() / f"default-{_key(content)}.{ending}"


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
