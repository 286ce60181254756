"""Severity models as files, with a card; see `rotorwise.diagnose.learning.archive`."""

from __future__ import annotations

import json
from pathlib import Path

from ....simulators.errors import RotorwiseError
from ... import output_file
from ..archive import ArchiveKind, model_versions, other_versions, packed, read_bytes, unpacked, unreadable
from .conformal import ConformalRegressor
from .model import SeverityModel, responses_of
from .targets import TARGETS

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


class SeverityFileError(RotorwiseError):
    """A severity model cannot be written, or is not one that may be read."""


KIND = ArchiveKind(
    name="severity model",
    mark=b"rotorwise severity model ",
    make="rotorwise severity train STORE -o model.skops",
    error=SeverityFileError,
)


def save_model(model: SeverityModel, path: str | Path, *, force: bool = False) -> None:
    """Write a model file, whole or not at all.

    Raises
    ------
    SeverityFileError
        When the file exists and ``force`` is not set, is no severity model, or the place cannot be written to.
    """
    output_file.write_checked(Path(path), model_bytes(model), KIND.output, force=force)


def check_place(target: Path, *, force: bool) -> None:
    """Raise SeverityFileError where a model cannot go."""
    output_file.check_place(target, KIND.output, force=force)


def model_bytes(model: SeverityModel) -> bytes:
    """Return a model as the bytes of its file."""
    content = {
        "features": list(model.features),
        "card": json.dumps(model.card, sort_keys=True),
        "targets": list(model.regressors),
        "regressors": list(model.regressors.values()),
    }
    return packed(content, KIND)


def load_model(path: str | Path) -> SeverityModel:
    """Return the model in a file.

    Raises
    ------
    SeverityFileError
        When the file is missing, damaged, was edited, or is no severity model; when it holds a type that is not
        trusted; when these versions cannot read it.
    """
    here, name = model_versions(), str(path)
    found = unpacked(read_bytes(path, KIND), KIND, trusted=TRUSTED, name=name, here=here)
    try:
        card = json.loads(found["card"])
        regressors = dict(zip(found["targets"], found["regressors"], strict=True))
        model = SeverityModel(
            regressors, tuple(found["features"]), card, responses_of(card), other_versions(card, here)
        )
    except Exception as problem:
        raise unreadable(problem, KIND, name=name, here=here) from None
    wrong = _wrong(model)
    if wrong:
        raise SeverityFileError(f"{name} is no model that can answer: {wrong}. Train it again ({KIND.make}).")
    return model


def _wrong(model: SeverityModel) -> str:
    """Return why a model would answer with a traceback; empty when it is sound."""
    known = [target.name for target in TARGETS]
    for name, one in model.regressors.items():
        if name not in known or not isinstance(one, ConformalRegressor) or not hasattr(one, "quantile_"):
            return f"a {type(one).__name__} for {name!r}; allowed: fitted estimators of {', '.join(known)}"
        if getattr(one, "n_features_in_", 0) != len(model.features):
            return f"its estimator of {name} takes other features than the {len(model.features)} that it names"
    return ""
