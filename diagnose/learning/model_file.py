"""Classifiers as files: skops, never pickle, with a card; damaged, changed and foreign files are refused.

A skops file is a zip archive whose parts say which types they hold. Only the types listed here are ever made. A digest
of all parts stands in the archive's comment: it tells a file that was damaged or edited, not one that was forged, and
the list of types is what keeps a forged one harmless.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ...simulators.errors import RotorwiseError

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
FORMAT = 1
_MARK = b"rotorwise model "
_PACKAGES = ("rotorwise", "scikit-learn", "numpy", "skops")


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


def model_versions() -> dict[str, str]:
    """Return the versions of what decides whether a file can be read and what it answers."""
    return {name: version(name) for name in _PACKAGES}


def save_model(model: Model, path: str | Path, *, force: bool = False) -> None:
    """Write a model file, whole or not at all.

    Raises
    ------
    ModelFileError
        When the file exists and ``force`` is not set, is no model, or the place cannot be written to.
    """
    target = Path(path).resolve()
    check_model_place(target, force=force)
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        draft.write_bytes(model_bytes(model))
        check_model_place(target, force=force)
        draft.replace(target)
    except OSError as problem:
        raise ModelFileError(
            f"{target} cannot be written: {problem.strerror or problem}. Choose another place."
        ) from None
    finally:
        draft.unlink(missing_ok=True)


def check_model_place(target: Path, *, force: bool) -> None:
    """Raise ModelFileError where a model cannot go: a folder, a missing folder, a file not to be replaced."""
    if target.is_dir() or not target.resolve().parent.is_dir():
        raise ModelFileError(f"{target} is a folder or lies in none; allowed: a file in a folder that exists.")
    if not target.exists():
        return
    if not force:
        raise ModelFileError(f"{target} exists already. Choose another name, or allow overwriting (--force).")
    try:
        ours = target.is_file() and _comment(target.read_bytes()).startswith(_MARK)
    except (OSError, ModelFileError):
        ours = False
    if not ours:
        raise ModelFileError(f"{target} is no model: a model never replaces other data. Choose another name.")


def model_bytes(model: Model) -> bytes:
    """Return a model as the bytes of its file."""
    from skops.io import dumps

    content = {"format": FORMAT, "features": list(model.features), "card": json.dumps(model.card, sort_keys=True)}
    sink = io.BytesIO(dumps({**content, "classifier": model.classifier}, compression=zipfile.ZIP_DEFLATED))
    with zipfile.ZipFile(sink, "a") as archive:
        archive.comment = _MARK + _digest(archive).encode()
    return sink.getvalue()


def load_model(path: str | Path) -> Model:
    """Return the model in a file.

    Raises
    ------
    ModelFileError
        When the file is missing, damaged, was edited, or is no model of rotorwise; when it holds a type that is not
        trusted; when this version of scikit-learn cannot read it.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as problem:
        raise ModelFileError(f"Model {path}: {problem.strerror or problem}. Check the path.") from None
    return model_from_bytes(content, name=str(path))


def model_from_bytes(content: bytes, *, name: str) -> Model:
    """Return the model in the bytes of a file; ``name`` is what messages call it. Raises as `load_model`."""
    from skops.io import get_untrusted_types, loads

    said = _comment(content, name=name)
    if not said.startswith(_MARK):
        raise ModelFileError(f"{name} is no model of rotorwise. Make one: rotorwise train STORE -o model.skops")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            digest = _digest(archive)
    except Exception as problem:
        raise ModelFileError(f"{name} is damaged: {problem}. Restore it from a copy, or train again.") from None
    if said != _MARK + digest.encode():
        raise ModelFileError(f"{name} was changed after it was written. Do not use it; train again.")
    try:
        unknown = sorted(set(get_untrusted_types(data=content)) - set(TRUSTED))
    except Exception as problem:
        raise ModelFileError(f"{name} cannot be read: {problem}. Train again.") from None
    if unknown:
        raise ModelFileError(
            f"{name} holds {unknown[0]}, which no model of rotorwise holds. Do not use it; train again."
        )
    try:
        # What cannot be loaded safely was refused above.
        found = loads(content, trusted=list(TRUSTED))
        card = json.loads(found["card"])
        model = Model(found["classifier"], tuple(found["features"]), card, _other_versions(card))
    except Exception as problem:
        text = f"{type(problem).__name__}: {problem}"
        raise ModelFileError(
            f"{name} cannot be read by {_here()} ({text}). Train it again with these versions."
        ) from None
    if found["format"] != FORMAT:
        raise ModelFileError(f"{name} has format {found['format']}; allowed: {FORMAT}. Train it again.")
    return model


def _comment(content: bytes, *, name: str = "The file") -> bytes:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return archive.comment
    except (zipfile.BadZipFile, EOFError, ValueError, NotImplementedError):
        raise ModelFileError(
            f"{name} is no model of rotorwise, or a damaged one. Make one: rotorwise train STORE -o model.skops"
        ) from None


def _digest(archive: zipfile.ZipFile) -> str:
    total = hashlib.sha256()
    for name in sorted(archive.namelist()):
        part = archive.read(name)
        total.update(f"{name}\0{len(part)}\0".encode() + part)
    return total.hexdigest()


def _other_versions(card: dict[str, Any]) -> tuple[str, ...]:
    made, here = card.get("versions", {}), model_versions()
    other = [f"{name} {made.get(name, '?')} (here {own})" for name, own in here.items() if made.get(name) != own]
    return (
        (f"The model was made with {', '.join(other)}: its answers may differ a little. Train it again.",)
        if other
        else ()
    )


def _here() -> str:
    return ", ".join(f"{name} {own}" for name, own in model_versions().items())
