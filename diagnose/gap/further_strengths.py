"""Strengths that the lines ask for beside those that an effect was fitted with.

Which they are is first seen from responses to small strengths on the machine without the effect. Where a response bends
(without a tacho the phase of all lines is that of one which the effect moves as well), some are missed: they are looked
for again about the fit, until the lines ask for no more.
"""

from __future__ import annotations

import numpy as np

from .evidence import Problem, Widened
from .first_look import moved_to
from .hypotheses import Candidate
from .null_distribution import chance_of_residual
from .own_angles import WEAK, Pair, Solution, asked_for, have_own_angles, place_of, quarter_of
from .predict import UnpredictableError
from .refine import Fit, refined
from .responses import Responses
from .screening import Screening
from .two_effects import MISFIT

#: So often further strengths are looked for.
ROUNDS = 3
#: Tolerance of what the fit's own values make up for, in standard coordinates.
OPEN = 100.0


def with_further_strengths(fit: Fit, screening: Screening, problem: Problem) -> Fit:
    """Return the fit of one effect with the strengths that the lines ask for, or as it is where they ask for none.

    Of effects whose strengths add up and have an angle each, where the fit leaves more than noise.
    """
    whole = _whole(fit.candidates[0], screening)
    for _ in range(ROUNDS if whole else 0):
        if whole is None or chance_of_residual(fit) > MISFIT:
            break
        try:
            found = _with_more(fit, whole, problem)
        except UnpredictableError:
            break
        if found is None or found.log_evidence <= fit.log_evidence:
            break
        fit = found
    return fit


def _whole(one: Candidate, screening: Screening) -> Candidate | None:
    """Return the candidate with all strengths of an effect at its place, if they have angles of their own."""
    every = [c for c in screening.atoms if (c.name, c.effect.at, c.beside) == (one.name, one.effect.at, one.beside)]
    return max((c for c in every if have_own_angles(c)), key=lambda c: len(c.strengths), default=None)


def _with_more(fit: Fit, whole: Candidate, problem: Problem) -> Fit | None:
    """Return the fit with the further strengths that are asked for about it; None where none is."""
    present, compared = fit.candidates[0].strength_names, problem.plain()
    absent = sorted(whole.strength_names - present)
    variants = [whole.with_only(present | {name}) for name in absent]
    pairs = [_beside(fit, one, name, problem) for one, name in zip(variants, absent, strict=True)]
    if not pairs:
        return None
    white = np.array([compared.whitened(one) for pair in pairs for one in pair.responses])
    # What the values that are there would make up for asks for no other strength.
    law = Widened(np.concatenate([fit.law, OPEN * compared.whitened(fit.slopes)]))
    solved = law.solve(white)
    solution = Solution(solved @ white.T, solved @ fit.residual)
    chosen = asked_for(solution, [True] * len(pairs))
    if not chosen:
        return None
    places = _places(fit)
    for i, (along, across) in zip(chosen, solution.sizes(chosen).reshape(-1, 2).tolist(), strict=True):
        places |= place_of(variants[i], pairs[i], along, across)
    more = whole.with_only(present | {absent[i] for i in chosen})
    position = np.array([places[one.parameter.name] for one in more.coordinates])
    return refined([more], position, compared, problem.baseline.machine, problem.predictor)


def _beside(fit: Fit, one: Candidate, name: str, problem: Problem) -> Pair:
    """Return what one more strength adds to a fit, small, at two angles a quarter of its period apart."""
    places = _places(fit)
    position = np.array([places.get(c.parameter.name, 0.0) for c in one.coordinates])
    strength = next(i for i, c in enumerate(one.coordinates) if c.parameter.name == name)
    angle = next(i for i, c in enumerate(one.coordinates) if c.parameter.only_with == name)
    position[strength] = WEAK
    turned = moved_to(position, [angle], [quarter_of(one, angle)])
    response = Responses([one], problem.baseline.machine, problem.predictor)
    return Pair(strength, angle, position, (response(position) - fit.response, response(turned) - fit.response))


def _places(fit: Fit) -> dict[str, float]:
    return {one.parameter.name: float(at) for one, at in zip(fit.coordinates, fit.position, strict=True)}
