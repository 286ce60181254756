"""Severity models as files: skops, never pickle, with a card; damaged, changed and foreign files are refused.

Only the types listed here are ever made. A digest of all parts stands in the archive's comment: it tells a file that
was damaged or edited, not one that was forged; the list of types keeps a forged one harmless.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ....simulators.errors import RotorwiseError
from .model import SeverityModel, responses_of

#: Everything beyond numbers and texts that a model file may hold. skops itself knows scikit-learn's own estimators.
TRUSTED = (
    "numpy.dtype",
    "rotorwise.diagnose.learning.severity.conformal.ConformalRegressor",
    "sklearn._loss._loss.CyHalfSquaredError",
    "sklearn._loss.link.IdentityLink",
    "sklearn._loss.link.Interval",
    "sklearn._loss.loss.HalfSquaredError",
    "sklearn.ensemble._hist_gradient_boosting.binning._BinMapper",
    "sklearn.ensemble._hist_gradient_boosting.predictor.TreePredictor",
)
FORMAT = 1
_MARK = b"rotorwise severity model "
_PACKAGES = ("rotorwise", "scikit-learn", "numpy", "skops")
_MAKE = "Make one: rotorwise severity train STORE -o model.skops"


class SeverityFileError(RotorwiseError):
    """A severity model cannot be written, or is not one that may be read."""


def model_versions() -> dict[str, str]:
    """Return the versions of what decides whether a file can be read and what it answers."""
    return {name: version(name) for name in _PACKAGES}


def save_model(model: SeverityModel, path: str | Path, *, force: bool = False) -> None:
    """Write a model file, whole or not at all.

    Raises
    ------
    SeverityFileError
        When the file exists and ``force`` is not set, is no severity model, or the place cannot be written to.
    """
    target = Path(path).resolve()
    check_place(target, force=force)
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        draft.write_bytes(model_bytes(model))
        draft.replace(target)
    except OSError as problem:
        raise SeverityFileError(
            f"{target} cannot be written: {problem.strerror or problem}. Choose another place."
        ) from None
    finally:
        draft.unlink(missing_ok=True)


def check_place(target: Path, *, force: bool) -> None:
    """Raise SeverityFileError where a model cannot go."""
    if target.is_dir() or not target.resolve().parent.is_dir():
        raise SeverityFileError(f"{target} is a folder or lies in none; allowed: a file in a folder that exists.")
    if not target.exists():
        return
    if not force:
        raise SeverityFileError(f"{target} exists already. Choose another name, or allow overwriting (--force).")
    try:
        ours = _comment(target.read_bytes(), str(target)).startswith(_MARK)
    except (OSError, SeverityFileError):
        ours = False
    if not ours:
        raise SeverityFileError(f"{target} is no severity model and is not replaced by one. Choose another name.")


def model_bytes(model: SeverityModel) -> bytes:
    """Return a model as the bytes of its file."""
    from skops.io import dumps

    content = {
        "format": FORMAT,
        "features": list(model.features),
        "card": json.dumps(model.card, sort_keys=True),
        "targets": list(model.regressors),
        "regressors": list(model.regressors.values()),
    }
    sink = io.BytesIO(dumps(content, compression=zipfile.ZIP_DEFLATED))
    with zipfile.ZipFile(sink, "a") as archive:
        archive.comment = _MARK + _digest(archive).encode()
    return sink.getvalue()


def load_model(path: str | Path) -> SeverityModel:
    """Return the model in a file.

    Raises
    ------
    SeverityFileError
        When the file is missing, damaged, was edited, or is no severity model; when it holds a type that is not
        trusted; when these versions cannot read it.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as problem:
        raise SeverityFileError(f"Model {path}: {problem.strerror or problem}. Check the path.") from None
    _check_whole(content, str(path))
    found = _loaded(content, str(path))
    if found.get("format") != FORMAT:
        raise SeverityFileError(f"{path} has format {found.get('format')}; allowed: {FORMAT}. Train it again.")
    card = json.loads(found["card"])
    regressors = dict(zip(found["targets"], found["regressors"], strict=True))
    return SeverityModel(regressors, tuple(found["features"]), card, responses_of(card), _other_versions(card))


def _check_whole(content: bytes, name: str) -> None:
    said = _comment(content, name)
    if not said.startswith(_MARK):
        raise SeverityFileError(f"{name} is no severity model of rotorwise. {_MAKE}")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            digest = _digest(archive)
    except Exception as problem:
        raise SeverityFileError(f"{name} is damaged: {problem}. Restore it from a copy, or train again.") from None
    if said != _MARK + digest.encode():
        raise SeverityFileError(f"{name} was changed after it was written. Do not use it; train again.")


def _loaded(content: bytes, name: str) -> dict[str, Any]:
    from skops.io import get_untrusted_types, loads

    try:
        unknown = sorted(set(get_untrusted_types(data=content)) - set(TRUSTED))
    except Exception as problem:
        raise SeverityFileError(f"{name} cannot be read: {problem}. Train again.") from None
    if unknown:
        raise SeverityFileError(
            f"{name} holds {unknown[0]}, which no severity model of rotorwise holds. Do not use it; train again."
        )
    try:
        return loads(content, trusted=list(TRUSTED))
    except Exception as problem:
        here = ", ".join(f"{package} {own}" for package, own in model_versions().items())
        raise SeverityFileError(
            f"{name} cannot be read by {here} ({type(problem).__name__}: {problem}). Train it again with these."
        ) from None


def _comment(content: bytes, name: str) -> bytes:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return archive.comment
    except (zipfile.BadZipFile, EOFError, ValueError, NotImplementedError):
        raise SeverityFileError(f"{name} is no severity model of rotorwise, or a damaged one. {_MAKE}") from None


def _digest(archive: zipfile.ZipFile) -> str:
    total = hashlib.sha256()
    for name in sorted(archive.namelist()):
        part = archive.read(name)
        total.update(f"{name}\0{len(part)}\0".encode() + part)
    return total.hexdigest()


def _other_versions(card: dict[str, Any]) -> tuple[str, ...]:
    made, here = card.get("versions", {}), model_versions()
    other = [f"{name} {made.get(name, '?')} (here {own})" for name, own in here.items() if made.get(name) != own]
    if not other:
        return ()
    return (f"The model was made with {', '.join(other)}: its answers may differ a little. Train it again.",)
