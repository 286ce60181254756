"""Two causes that work against each other: together they can look like a third.

A difference of two large responses takes many shapes, and the tolerances of two laws are shares of each, not of the
difference. What two causes explain only that way is as likely one cause that is not in the catalogue, or is there in
another shape: a bent shaft without its effect is a misaligned coupling and an unbalance that oppose each other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .evidence import Problem
from .refine import Fit
from .responses import Responses
from .two_effects import best_of_each, told_by_more_than_one_size

#: Share of the power of both alone below which what they make together is worth a warning, and below which they are not
#: named. Of one line and sizes unlike by up to 50, any phase, independent causes come so close in about 1 % of cases.
SMALL_REST, NEARLY_NOTHING = 0.3, 0.05


def told_pairs(pairs: Sequence[Fit], singles: Sequence[Fit], problem: Problem) -> tuple[list[Fit], tuple[Fit, ...]]:
    """Return the pairs of which both effects may be named, and those that only oppose each other.

    ``singles`` are the fits of one effect.
    """
    told = [fit for fit in pairs if told_by_more_than_one_size(fit, best_of_each(singles)[0])]
    opposed = tuple(fit for fit in told if rest_of_both(fit, problem) < NEARLY_NOTHING)
    return [fit for fit in told if fit not in opposed], opposed


def rest_of_both(fit: Fit, problem: Problem) -> float:
    """Return the power, in lines of unit noise, of what two effects make together over that of both alone.

    1 where they have nothing to do with each other, and of one effect.
    """
    if len(fit.candidates) != 2 or fit.compared is None:
        return 1.0
    machine = (fit.problem or problem).baseline.machine
    each = Responses(fit.candidates, machine, problem.predictor).own(fit.position, fit.response)
    alone = sum(float((fit.compared.whitened(own) ** 2).sum()) for own in each)
    return float((fit.compared.whitened(np.sum(each, axis=0)) ** 2).sum()) / max(alone, 1e-300)


def opposing_words(fit: Fit, problem: Problem) -> tuple[str, ...]:
    """Return a warning where two named causes cancel most of what each makes; else nothing."""
    rest = rest_of_both(fit, problem)
    if rest > SMALL_REST:
        return ()
    first, second = (candidate.name.replace("_", " ") for candidate in fit.candidates)
    return (
        f"{first[0].upper()}{first[1:]} and {second} work against each other: together they make {rest:.0%} of the "
        "power of both alone. One other cause may look like that.",
    )


def not_named_words(fit: Fit, problem: Problem) -> str:
    """Return why two effects that would explain the lines are not named."""
    both = " and ".join(str(candidate).replace("_", " ") for candidate in fit.candidates)
    rest = rest_of_both(fit, problem)
    return (
        f"{both[0].upper()}{both[1:]} would explain it, but only against each other, as {rest:.1%} of the power of "
        "both is left: one other cause may look like that, so that they are not named."
    )
