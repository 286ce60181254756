"""Two causes of which one is as strong as it can be at all: it stands for one that is stronger, or shaped otherwise.

Where sizes alone tell an effect, to a factor, two take the shape of a third that is not followed: a cracked tooth of
another author was an error of that tooth with pits over all of the width that pits are allowed (README, "Other
authors' machines"). Of motions that repeat with the shaft phases tell such a pair from the third.
"""

from __future__ import annotations

from collections.abc import Mapping

from ...simulators.parameter import Uniform
from .evidence import Problem
from .hypotheses import Candidate
from .refine import Fit

#: Share of the way from nothing to the most that a strength can be, within which it is that.
NEAR_END = 0.02


def at_its_end(fit: Fit, problem: Problem) -> str:
    """Return which of two effects, told by sizes, is as strong as it can be, in words; empty where none is."""
    if len(fit.candidates) != 2:
        return ""
    each = (_of_one(one, one.at(fit.position[place]).values()) for one, place in fit.parts)
    words = next(filter(None, each), "")
    machine = (fit.problem or problem).baseline.machine
    return words if words and not problem.predictor.repeats(fit.machine(machine)) else ""


def stretched_words(fit: Fit, problem: Problem) -> str:
    """Return why two effects are not named of which one is as strong as it can be; empty where none is."""
    stretched = at_its_end(fit, problem)
    if not stretched:
        return ""
    both = " and ".join(str(candidate).replace("_", " ") for candidate in fit.candidates)
    return (
        f"{both[0].upper()}{both[1:]} would explain it together, but only with {stretched}: that stands for something "
        "stronger, or of another shape, so that they are not named."
    )


def _of_one(candidate: Candidate, values: Mapping[str, float]) -> str:
    for number in candidate.strengths:
        declared = candidate.coordinates[number].parameter
        prior, value = declared.prior, values[declared.name]
        most = prior.high if isinstance(prior, Uniform) else declared.bounds[1]
        if most - value <= NEAR_END * (most - (declared.zero or 0.0)):
            unit = f" {declared.unit}" if declared.unit else ""
            what = f"{candidate.name} {declared.name}".replace("_", " ")
            return f"{what} of {value:.3g}{unit} where {most:.3g}{unit} is the most"
    return ""
