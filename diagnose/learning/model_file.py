"""Classifiers as files, with a card; see `archive`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...simulators.errors import RotorwiseError
from .. import output_file
from .archive import ArchiveKind, model_versions, other_versions, packed, read_bytes, unpacked, unreadable

#: Everything beyond numbers and texts that a model file may hold. skops itself knows scikit-learn's own estimators.
TRUSTED = (
    "numpy.dtype",
    "rotorwise.diagnose.learning.fault_classifier.FaultClassifier",
    "rotorwise.diagnose.learning.novelty.Novelty",
    "sklearn._loss.link.LogitLink",
    "sklearn._loss.link.Interval",
    "sklearn._loss.link.MultinomialLogit",
    "sklearn._loss.loss.HalfBinomialLoss",
    "sklearn._loss.loss.HalfMultinomialLoss",
    "sklearn._loss._loss.CyHalfBinomialLoss",
    "sklearn._loss._loss.CyHalfMultinomialLoss",
    "sklearn.calibration._CalibratedClassifier",
    "sklearn.calibration._SigmoidCalibration",
    "sklearn.ensemble._hist_gradient_boosting.binning._BinMapper",
    "sklearn.ensemble._hist_gradient_boosting.predictor.TreePredictor",
)


class ModelFileError(RotorwiseError):
    """A model file cannot be written, or is not one that may be read."""


@dataclass(frozen=True, eq=False)
class Model:
    """A fitted classifier with what must be known of it.

    Attributes
    ----------
    classifier : FaultClassifier
    features : tuple of str
        What its columns are.
    card : dict
        JSON types only: what it learned from, how it was judged, limits, versions.
    remarks : tuple of str
        What is worth saying when it is used, such as other versions than it was made with.
    """

    classifier: Any
    features: tuple[str, ...]
    card: dict[str, Any]
    remarks: tuple[str, ...] = ()


KIND = ArchiveKind(
    name="model",
    mark=b"rotorwise model ",
    make="rotorwise train STORE -o model.skops",
    error=ModelFileError,
)


def save_model(model: Model, path: str | Path, *, force: bool = False) -> None:
    """Write a model file, whole or not at all.

    Raises
    ------
    ModelFileError
        When the file exists and ``force`` is not set, is no model, or the place cannot be written to.
    """
    output_file.write_checked(Path(path), model_bytes(model), KIND.output, force=force)


def check_place(target: Path, *, force: bool) -> None:
    """Raise ModelFileError where a model cannot go: a folder, a missing folder, a file not to be replaced."""
    output_file.check_place(target, KIND.output, force=force)


def model_bytes(model: Model) -> bytes:
    """Return a model as the bytes of its file."""
    card = json.dumps(model.card, sort_keys=True)
    return packed({"features": list(model.features), "card": card, "classifier": model.classifier}, KIND)


def load_model(path: str | Path) -> Model:
    """Return the model in a file.

    Raises
    ------
    ModelFileError
        When the file is missing, damaged, was edited, or is no model of rotorwise; when it holds a type that is not
        trusted; when these versions cannot read it.
    """
    return model_from_bytes(read_bytes(path, KIND), name=str(path))


def model_from_bytes(content: bytes, *, name: str) -> Model:
    """Return the model in the bytes of a file; ``name`` is what messages call it. Raises as `load_model`."""
    here = model_versions()
    found = unpacked(content, KIND, trusted=TRUSTED, name=name, here=here)
    try:
        card = json.loads(found["card"])
        model = Model(found["classifier"], tuple(found["features"]), card, other_versions(card, here))
    except Exception as problem:
        raise unreadable(problem, KIND, name=name, here=here) from None
    wrong = _wrong(model)
    if wrong:
        raise ModelFileError(f"{name} is no model that can answer: {wrong}. Train it again (rotorwise train).")
    return model


def _wrong(model: Model) -> str:
    """Return why a model would answer with a traceback, or to features that it never learned; empty when sound."""
    from .changes import model_feature_names
    from .fault_classifier import FaultClassifier

    if not isinstance(model.classifier, FaultClassifier):
        return f"a {type(model.classifier).__name__} instead of a classifier of faults"
    if not hasattr(model.classifier, "classes_"):
        return "it was not fitted"
    names = model_feature_names()
    if model.features != names or getattr(model.classifier, "n_features_in_", 0) != len(names):
        return f"it takes other features than the {len(names)} of this rotorwise"
    unknown_below = model.card.get("unknown_below") if isinstance(model.card, dict) else None
    if not (isinstance(unknown_below, int | float) and 0 <= unknown_below < 1):
        return f"its limit of unknown is {unknown_below!r}"
    return ""
