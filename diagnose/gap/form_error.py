"""Errors of a model's form for which nothing was added: each shaped like a spring, a force or an unbalance it lacks.

What a model lacks by a little is worth no term of its own, yet it moves all lines together, most near a resonance, and
at a speed between the healthy ones otherwise than there. Such errors join the machine's unknowns, all of one likely
strength, where that makes the healthy lines clearly likelier than errors that are smooth in speed and nothing else.
"""

from __future__ import annotations

import numpy as np

from .baseline import Baseline, widened_by
from .healthy_evidence import evidence
from .lacking_terms import Term, lacking_terms, slopes_in
from .lines import OrderLines
from .predict import Predictor

#: Strengths that are tried, in standard deviations of a lacking term (each moves some probe's lines by 30 %).
STRENGTHS = tuple(np.geomspace(0.003, 1.0, 8))
#: By how much the logarithm of the evidence of the healthy lines must rise.
LEAST_RISE = 5.0
#: Healthy conditions needed: of two, any shape fits.
LEAST_CONDITIONS = 3


def form_errors(
    current: Baseline, healthy: OrderLines, predictor: Predictor, *, reference_rpm: float
) -> tuple[tuple[Term, ...], float]:
    """Return the terms whose shapes the model's errors have, and their strength; none where that explains no more.

    Parameters
    ----------
    current : Baseline
        Calibrated, in the healthy conditions.
    healthy : OrderLines
    predictor : Predictor
        For these conditions.
    reference_rpm : float
        Highest speed of all recordings.
    """
    if not predictor.repeats(current.machine) or len(healthy.conditions) < LEAST_CONDITIONS:
        return (), 0.0
    terms = tuple(lacking_terms(current, predictor, reference_rpm=reference_rpm))
    if not terms:
        return (), 0.0
    shapes = np.concatenate([term.slopes for term in terms])
    rises = [evidence(widened_by(current, one * shapes), healthy) for one in STRENGTHS]
    best = int(np.argmax(rises))
    if rises[best] < evidence(current, healthy) + LEAST_RISE:
        return (), 0.0
    return terms, float(STRENGTHS[best])


def with_form_errors(current: Baseline, terms: tuple[Term, ...], strength: float, predictor: Predictor) -> Baseline:
    """Return the machine, in the predictor's conditions, with these errors among its unknowns."""
    if not terms:
        return current
    return widened_by(current, strength * np.concatenate(slopes_in(terms, current, predictor)))
