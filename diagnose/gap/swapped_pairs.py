"""Pairs in which one effect of the best pair stands beside another one than it was found with.

Pairs are built on the effects that explain most alone. Where a contact explains little without its partner, partners
are looked for beside the other effect only, and what makes the lines of that one as well is never seen beside the
contact: a bow beside a rub that was found beside a misaligned coupling.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .evidence import Problem
from .predict import UnpredictableError
from .refine import Fit, fit_at
from .responses import Responses
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

    None where the best pair is behind a single effect, or its motion does not repeat with the shaft.
    """
    best, single = best_of_each(pairs)[0], best_of_each(singles)[0]
    machine, known = problem.baseline.machine, {fit.names for fit in pairs}
    if best.log_evidence < single.log_evidence or not problem.predictor.repeats(best.machine(machine)):
        return []
    hopeless, found = hopeless_beside(best, none, unknown), []
    for number in range(len(best.candidates)):
        leader = _alone(best, number, problem)
        if leader is None:
            continue
        beside = screened_beside(leader, screening, problem, ("sensor",), tell)
        ranked = few_of_each(beside.against(left_beside(leader, screening)))
        others = [o for o in ranked if tuple(sorted((*leader.names, o[0].candidate.name))) not in known]
        others = [o for o in others if o[0].candidate.name not in leader.names and repeat(leader, o[0], problem)]
        for options in others[:OTHERS]:
            tell(f"{leader.candidates[0]} with {options[0].candidate}")
            fit = fitted_pair(leader, options[:STARTS], problem, none, hopeless=hopeless)
            found += [fit] if fit else []
    return best_jointly(found, problem, pair_level(single, none, misfit=MISFIT), unknown)


def _alone(pair: Fit, number: int, problem: Problem) -> Fit | None:
    """Return one effect of a pair where it was found, as if it were alone; None where it cannot be computed."""
    ends = np.cumsum([0, *(len(one.coordinates) for one in pair.candidates)])
    position = pair.position[ends[number] : ends[number + 1]]
    response = Responses((pair.candidates[number],), problem.baseline.machine, problem.predictor)
    try:
        added = response(position)
        slopes = response.slopes(position, added, np.ones(position.size, dtype=bool))
        return fit_at(response, position, added, slopes, problem.plain())
    except UnpredictableError:
        return None
