"""Pairs in which one effect of the best pair stands beside another one than it was found with.

Pairs are built on the effects that explain most alone. Where a contact explains little without its partner, partners
are looked for beside the other effect only, and what makes the lines of that one as well is never seen beside the
contact: a bow beside a rub that was found beside a misaligned coupling. And where the motion does not repeat with the
shaft, partners are looked for beside one leader only: what alone was as likely as that is tried in its place, an
unbalance for a bow beside an inner race.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .evidence import Problem
from .hypotheses import Candidate
from .predict import UnpredictableError
from .refine import Fit, fit_at
from .responses import Responses
from .screen import Start
from .screening import Screening, few_of_each
from .two_effects import (
    MISFIT,
    STARTS,
    best_jointly,
    best_of_each,
    fitted_pair,
    hopeless_beside,
    left_beside,
    repeat,
    screened_beside,
)
from .within_law import pair_level

#: Other partners of each of the two that are fitted.
OTHERS = 2
#: Effects are as likely alone as each other within this in the logarithm of the evidence.
LEVEL = 10.0

Tell = Callable[[str], None]


def swapped_pairs(
    pairs: Sequence[Fit],
    singles: Sequence[Fit],
    screening: Screening,
    problem: Problem,
    none: Fit,
    unknown: float,
    tell: Tell = lambda _: None,
) -> list[Fit]:
    """Return further fits of two effects, one of them of the best pair, with clearly more evidence than the singles.

    None where the best pair is behind a single effect.
    """
    best, single = best_of_each(pairs)[0], best_of_each(singles)[0]
    machine, known = problem.baseline.machine, {fit.names for fit in pairs}
    if best.log_evidence < single.log_evidence:
        return []
    repeats = problem.predictor.repeats(best.machine(machine))
    hopeless, found = hopeless_beside(best, none, unknown), []
    for number in range(len(best.candidates)):
        leader = _alone(best, number, problem)
        if leader is None:
            continue
        others = (
            _others(leader, screening, problem, tell) if repeats else _as_likely(best.candidates[1 - number], singles)
        )
        others = [o for o in others if tuple(sorted((*leader.names, o[0].candidate.name))) not in known]
        for options in [o for o in others if o[0].candidate.name not in leader.names][:OTHERS]:
            tell(f"{leader.candidates[0]} with {options[0].candidate}")
            fit = fitted_pair(leader, options[:STARTS], problem, none, hopeless=hopeless)
            found += [fit] if fit else []
    return best_jointly(found, problem, pair_level(single, none, misfit=MISFIT), unknown)


def _others(leader: Fit, screening: Screening, problem: Problem, tell: Tell) -> list[list[Start]]:
    """Return the starts of every candidate beside an effect whose motion repeats with it, the best candidate first."""
    beside = screened_beside(leader, screening, problem, ("sensor",), tell)
    ranked = few_of_each(beside.against(left_beside(leader, screening)))
    return [options for options in ranked if repeat(leader, options[0], problem)]


def _as_likely(partner: Candidate, singles: Sequence[Fit]) -> list[list[Start]]:
    """Return the fits, as starts, of what was as likely alone as the partner, the likeliest first."""
    alone = [fit.log_evidence for fit in singles if fit.candidates == (partner,)]
    level = [fit for fit in best_of_each(singles) if alone and abs(fit.log_evidence - max(alone)) < LEVEL]
    return [[Start(fit.candidates[0], fit.position, fit.log_evidence)] for fit in level if len(fit.candidates) == 1]


def _alone(pair: Fit, number: int, problem: Problem) -> Fit | None:
    """Return one effect of a pair where it was found, as if it were alone; None where it cannot be computed."""
    one, place = pair.parts[number]
    position, response = pair.position[place], Responses((one,), problem.baseline.machine, problem.predictor)
    try:
        added = response(position)
        slopes = response.slopes(position, added, np.ones(position.size, dtype=bool))
        return fit_at(response, position, added, slopes, problem.plain())
    except UnpredictableError:
        return None
