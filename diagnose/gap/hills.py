"""Effects whose likelihood has many hills: a contact that opens in one condition and not in the next makes them.

Every step of the search ends on the hill that it began on. Places are drawn at random all over the prior, and the best
climbed; then about the end of that climb, about the best of these again, ever nearer. Which hill is the highest the
last bits of rounding and the form of the law decide: how far the others lie that come closest belongs to what the data
leave open.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from .climb import FIRST_STEPS, climbed
from .evidence import Problem
from .hypotheses import Candidate
from .refine import Fit, density, refined
from .responses import Responses

#: Places that are drawn in each round, and how far away. Where each is a simulation, only of contacts and cracks.
DRAWS, REACHES = 24, (0.8, 0.5, 0.3, 0.15)
#: Places that are drawn all over the prior, how many of them are climbed a few steps, and of these to the end.
ANYWHERE, CLIMBED, ENDED = 192, 8, 2
#: Places that come closest, of all rounds, beside the best.
CLOSEST = 6


def looked_about(fit: Fit, problem: Problem) -> Fit:
    """Return the fit of a single effect, or a better one from elsewhere or near by, with how far other hills lie."""
    compared, machine, predictor = problem.plain(), problem.baseline.machine, problem.predictor
    response, generator = Responses(fit.candidates, machine, predictor), np.random.default_rng(0)
    idealised = fit.candidates[0].effect.IDEALISED
    if not idealised and not response.repeats(fit.position):
        return fit
    if idealised:
        fit = _from_anywhere(fit, response, problem, generator)
    at, most = fit.position, density(response, fit.position, compared)
    seen = [(most, at)]
    for reach in REACHES:
        places = at + generator.normal(scale=reach, size=(DRAWS, at.size))
        response.prepare(list(places))
        values = [density(response, place, compared) for place in places]
        seen += zip(values, places, strict=True)
        best = int(np.argmax(values))
        if values[best] > most:
            at, most = places[best], values[best]
    found = None if at is fit.position else refined(fit.candidates, at, compared, machine, predictor)
    best_fit = found if found and found.log_evidence > fit.log_evidence else fit
    if not idealised:
        return best_fit
    closest = sorted((one for one in seen if np.isfinite(one[0])), key=lambda one: -one[0])[: CLOSEST + 1]
    away = np.array([place for _, place in closest]) - best_fit.position
    return replace(best_fit, hills=away.T @ away / max(len(closest) - 1, 1))


def _from_anywhere(fit: Fit, response: Responses, problem: Problem, generator: np.random.Generator) -> Fit:
    """Return the fit of a single effect, or a better one that began anywhere in its prior where its motion repeats."""
    compared, machine, predictor = problem.plain(), problem.baseline.machine, problem.predictor
    shares = generator.uniform(size=(ANYWHERE, len(fit.coordinates)))
    places = [np.array([c.at_share(s) for c, s in zip(fit.coordinates, row, strict=True)]) for row in shares]
    places = list(itertools.compress(places, response.prepare(places, most_in_time=0)))
    values = np.array([density(response, place, compared) for place in places])
    begin = [places[i] for i in np.argsort(-values)[:CLIMBED]]
    tried = climbed(fit.candidates, begin, compared, machine, predictor, steps=FIRST_STEPS)[:ENDED]
    ended = [refined(fit.candidates, one.position, compared, machine, predictor) for one in tried]
    return max([fit, *(one for one in ended if one)], key=lambda one: one.log_evidence)


def with_hills(fit: Fit, hills: Mapping[Candidate, np.ndarray]) -> Fit:
    """Return the fit, as uncertain as the hills of its effects, (coordinates, coordinates) each, lie apart."""
    covariance = fit.covariance.copy()
    for candidate, own in fit.parts:
        if candidate in hills:
            covariance[own, own] += hills[candidate]
    return replace(fit, covariance=covariance)
