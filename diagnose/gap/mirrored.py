"""Directions that sizes of lines do not tell from their mirror image: |cos| and |sin| are the same for both."""

from __future__ import annotations

import math
from dataclasses import replace

from ...simulators.parameter import Uniform
from .coordinates import Coordinate
from .evidence import Problem
from .refine import Fit, density_beside
from .responses import Responses

#: Logarithm of the probability that the mirror image may lose, as among hypotheses that cannot be told apart.
ALIKE = math.log(20)


def with_mirror_images(fit: Fit, problem: Problem) -> Fit:
    """Return the fit with those directions marked that may as well be their mirror image about the vertical."""
    problem = fit.problem or problem
    directions = [n for n, one in enumerate(fit.coordinates) if _is_direction(one) and fit.tells(n)]
    if fit.compared is None or not directions:
        return fit
    response = Responses(fit.candidates, problem.baseline.machine, problem.predictor)
    places = []
    for number in directions:
        place = fit.position.copy()
        place[number] = -place[number]
        places.append(place)
    response.prepare([fit.position, *places])
    least = density_beside(fit, response, fit.position) - ALIKE
    alike = [n for n, place in zip(directions, places, strict=True) if density_beside(fit, response, place) > least]
    return replace(fit, mirrored=frozenset(alike))


def _is_direction(one: Coordinate) -> bool:
    """Return whether a coordinate is a direction sideways, from 0 to half a turn, and not a whole circle."""
    prior = one.parameter.prior
    is_half_turn = isinstance(prior, Uniform) and (prior.low, prior.high) == (0.0, math.pi)
    return is_half_turn and one.parameter.unit == "rad" and not one.is_angle
