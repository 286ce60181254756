"""Errors of a model's form for which nothing was added: each shaped like a spring, a force or an unbalance it lacks.

What a model lacks by a little is worth no term of its own, yet it moves all lines together, most near a resonance, and
at a speed between the healthy ones otherwise than there. Such errors join the machine's unknowns, all of one likely
strength, where that makes the healthy lines clearly likelier than errors that are smooth in speed and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...simulators.effect import Effect
from .baseline import Baseline, machine_at, widened_by
from .healthy_evidence import evidence, fitted
from .lacking_terms import Term, lacking_terms, missed_orders, slopes_in
from .lines import OrderLines, different_speeds
from .predict import Predictor, UnpredictableError

#: Strengths that are tried, in standard deviations of a lacking term (each moves some probe's lines by 30 %).
STRENGTHS = tuple(np.geomspace(0.003, 1.0, 8))
#: By how much the logarithm of the evidence of the healthy lines must rise.
LEAST_RISE = 5.0
#: Healthy speeds needed: of two, any shape fits.
LEAST_SPEEDS = 3


@dataclass(frozen=True, eq=False)
class FormErrors:
    """Terms whose shapes the model's errors have.

    Attributes
    ----------
    terms : tuple of Term
    strength : float
        Standard deviation of each of their strengths, in its own.
    change : ndarray (unknowns,)
        What the healthy lines make likeliest: of the machine's unknowns and the gains, then of the terms.
    """

    terms: tuple[Term, ...]
    strength: float
    change: np.ndarray

    def joined_to(self, current: Baseline, predictor: Predictor) -> Baseline:
        """Return the machine, in the predictor's conditions, with these errors among its unknowns.

        A last unknown is by how much the likeliest change of all moves the lines otherwise than its slopes say.

        Raises
        ------
        UnpredictableError
            When the changed machine cannot be computed.
        """
        shapes = np.concatenate(slopes_in(self.terms, current, predictor))
        own, count = len(current.coordinates), len(current.prior)
        moved = machine_at(current.machine, current.coordinates, current.position + self.change[:own])
        moved = moved.with_effects(*_at(self.terms, self.strength * self.change[count:]))
        straight = np.tensordot(self.change[:own], current.slopes[:own], 1)
        straight = straight + np.tensordot(self.strength * self.change[count:], shapes, 1)
        bent = predictor.amplitudes(moved) - current.lines - straight
        return widened_by(current, np.concatenate([self.strength * shapes, bent[None]]))


def form_errors(
    current: Baseline, healthy: OrderLines, predictor: Predictor, *, reference_rpm: float
) -> FormErrors | None:
    """Return the terms whose shapes the model's errors have; None where that explains no more.

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
    if not predictor.repeats(current.machine) or different_speeds(healthy.conditions) < LEAST_SPEEDS:
        return None
    missed = missed_orders(current, healthy)
    terms = tuple(lacking_terms(current, predictor, reference_rpm=reference_rpm, missed=missed))
    if not terms:
        return None
    shapes = np.concatenate([term.slopes for term in terms])
    best = max(STRENGTHS, key=lambda one: evidence(widened_by(current, one * shapes), healthy))
    found = FormErrors(terms, float(best), fitted(widened_by(current, best * shapes), healthy)[0])
    try:
        joined = found.joined_to(current, predictor)
    except UnpredictableError:
        return None
    return found if evidence(joined, healthy) > evidence(current, healthy) + LEAST_RISE else None


def _at(terms: tuple[Term, ...], values: np.ndarray) -> list[Effect]:
    """Return the terms' effects with their strengths at values in standard deviations, (strengths of all,)."""
    found, left = [], iter(values)
    for number, term in enumerate(terms):
        at = {c.parameter.name: c.value(float(next(left))) for c in term.coordinates(number)}
        found.append(term.effect.with_values(**at))
    return found
