"""Angles that choose one part of several, a bolt or a tooth: without slopes, they are tried all round."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .evidence import Problem
from .refine import Fit, density_beside
from .responses import Responses

#: Places round the circle; an arc must hold this share of the probability. A place that is at least half as probable as
#: its neighbour at the arc's end does the same as that one.
PLACES, SHARE, ALIKE = 72, 0.9, 0.5


def on_plateaus(fit: Fit, problem: Problem) -> Fit:
    """Return the fit with each angle that chooses in the middle of the arc in which it may lie.

    Where each place is a simulation nothing is tried; such an angle stays unknown.
    """
    problem = fit.problem or problem
    choosing = [n for n, one in enumerate(fit.coordinates) if one.parameter.chooses]
    if fit.compared is None or not choosing:
        return fit
    response = Responses(fit.candidates, problem.baseline.machine, problem.predictor)
    if not response.repeats(fit.position):
        return fit
    position, arcs = fit.position.copy(), dict(fit.arcs)
    for number in choosing:
        step = fit.coordinates[number].parameter.period / PLACES
        places = [position + k * step * np.eye(position.size)[number] for k in range(PLACES)]
        response.prepare(places)
        first, last = arc_of(np.array([density_beside(fit, response, place) for place in places]))
        # A border lies somewhere between the last place of an arc and the first one outside.
        if last - first + 2 < PLACES:
            middle, half = position[number] + step * (first + last) / 2, step * ((last - first) / 2 + 1)
            position[number], arcs[number] = middle, half
    return replace(fit, position=position, arcs=arcs)


def arc_of(densities: np.ndarray) -> tuple[int, int]:
    """Return first and last place of the arc of a circle that holds most of the probability, the last one after 0.

    Parameters
    ----------
    densities : ndarray (places,)
        Logarithms, minus infinity allowed at some.
    """
    count = densities.size
    weights = np.exp(densities - densities.max())
    weights /= weights.sum()
    first = last = int(np.argmax(weights))
    held = float(weights[first])
    while last - first + 1 < count:
        before, after = float(weights[(first - 1) % count]), float(weights[(last + 1) % count])
        if held >= SHARE and before < ALIKE * weights[first % count] and after < ALIKE * weights[last % count]:
            break
        held += max(before, after)
        first, last = (first - 1, last) if before > after else (first, last + 1)
    return first, last
