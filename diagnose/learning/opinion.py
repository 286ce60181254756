"""What the default model says of a recording, and the findings with it: rules and model in one ranking.

The model is asked through its arrays (`plain_model`): loading scikit-learn would take longer than the analysis.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..compare import comparable
from ..observe import Observation
from ..result import Finding, Opinion
from .fault_names import HEALTHY

if TYPE_CHECKING:
    from .combination import Weights
    from .model_file import Model


def opinion_of(
    now: Observation, baseline: Observation | None, *, measured: Mapping[str, float] | None = None
) -> Opinion | None:
    """Return what the default model says; None where it was not asked: no turning machine, no bearing known, or gears.

    Parameters
    ----------
    now : Observation
    baseline : Observation or None
    measured : mapping, optional
        `features` of the recording, where they are at hand.
    """
    plate = now.recording.nameplate
    # It learned from machines without gears, whose meshes shake bearings at many orders.
    if now.speed is None or not now.turning or not plate.bearings or plate.gears:
        return None
    from .changes import model_features
    from .default_model import plain_default_model
    from .relative_features import levels, relative_features

    own = relative_features(now, measured=measured) | levels(now)
    before = None
    if baseline is not None and comparable(now, baseline):
        before = relative_features(baseline) | levels(baseline)
    return stated(plain_default_model(), model_features(own, before), combine=before is None)


def stated(model: Model, values: np.ndarray, *, combine: bool = True) -> Opinion:
    """Return what a model says of one feature vector; ``combine`` gives the weights along."""
    probability = model.classifier.predict_proba(values[None])[0]
    p_value = float(model.classifier.novelty_p_value(values[None])[0])
    classes = [str(one) for one in model.classifier.classes_]
    return Opinion(
        {name: float(one) for name, one in zip(classes, probability, strict=True)},
        p_value,
        known=p_value >= model.card["unknown_below"],
        weights=model.card.get("combination") if combine else None,
    )


def with_opinion(findings: tuple[Finding, ...], opinion: Opinion | None, *, least: float) -> tuple[Finding, ...]:
    """Return the findings with one probability from rules and model, likeliest first.

    Only faults of `COMBINED` change; the model never adds a finding, as a finding needs lines that carry it. A
    recording unlike the training changes nothing.

    Parameters
    ----------
    findings : tuple of Finding
        Of the rules.
    opinion : Opinion or None
    least : float
        Findings below are dropped.
    """
    if opinion is None or not opinion.known or opinion.weights is None:
        return findings
    from .combination import COMBINED, Weights

    weights = Weights(**opinion.weights)
    changed = [_combined(one, opinion, weights) if one.fault in COMBINED else one for one in findings]
    kept = [one for one in changed if one.probability >= least]
    return tuple(sorted(kept, key=lambda one: -one.probability))


def _combined(finding: Finding, opinion: Opinion, weights: Weights) -> Finding:
    model = opinion.probabilities.get(finding.fault)
    if model is None:
        return finding
    probability = float(weights.doubted(finding.probability, model))
    words = f" Rules alone {finding.probability:.0%}, trained model {model:.0%}."
    return replace(finding, probability=min(probability, 0.99), summary=finding.summary + words)


def words_of(opinion: Opinion) -> str:
    """Return what the model said, in a sentence."""
    ranked = sorted(opinion.probabilities.items(), key=lambda one: -one[1])[:2]
    names = [(name.replace("_", " ") if name != HEALTHY else "nothing evident", one) for name, one in ranked]
    said = ", ".join(f"{name} {one:.0%}" for name, one in names if one >= 0.05)
    if not opinion.known:
        unlike = f"The model trained on simulated machines knows none like this one (p-value {opinion.p_value:.3f})"
        return f"{unlike} and does not count. It would say: {said}."
    return f"The model trained on simulated machines says: {said}."
