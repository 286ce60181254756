"""Two causes that work against each other: together they can look like a third.

A difference of two large responses takes many shapes, and the tolerances of two laws are shares of each, not of the
difference. What two causes explain only that way is as likely one cause that is not in the catalogue, or is there in
another shape: a bent shaft without its effect is a misaligned coupling and an unbalance that oppose each other. Nor is
a second cause there that only undoes what a first one, predicted too large, makes of lines that are as they should be.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .evidence import Comparison, Problem
from .lines import unstacked
from .refine import Fit
from .responses import Responses
from .shown_lines import SHOWN
from .two_effects import best_of_each, told_by_more_than_one_size

#: Share of the power of both alone below which what they make together is worth a warning, and below which they are not
#: named. Of one line and sizes unlike by up to 50, any phase, independent causes come so close in about 1 % of cases.
SMALL_REST, NEARLY_NOTHING = 0.3, 0.05


def told_pairs(pairs: Sequence[Fit], singles: Sequence[Fit], problem: Problem) -> tuple[list[Fit], tuple[Fit, ...]]:
    """Return the pairs of which both effects may be named, and those that only oppose each other.

    ``singles`` are the fits of one effect.
    """
    plain = problem.plain()
    told = [fit for fit in pairs if told_by_more_than_one_size(fit, best_of_each(singles)[0])]
    alone = [(fit, own_lines(fit, problem)) for fit in told]
    opposed = tuple(fit for fit, each in alone if rest_of(fit, each) < NEARLY_NOTHING)
    return [fit for fit, each in alone if fit not in opposed and not undoes(fit, each, plain)], opposed


def own_lines(fit: Fit, problem: Problem) -> list[np.ndarray]:
    """Return what each effect of a fit makes alone, (conditions, probes, orders)."""
    machine = (fit.problem or problem).baseline.machine
    return list(Responses(fit.candidates, machine, problem.predictor).own(fit.position, fit.response))


def rest_of(fit: Fit, each: Sequence[np.ndarray]) -> float:
    """Return the power, in lines of unit noise, of what two effects make together over that of both alone.

    1 where they have nothing to do with each other, and of one effect. ``each`` as of `own_lines`.
    """
    if len(fit.candidates) != 2 or fit.compared is None:
        return 1.0
    alone = sum(float((fit.compared.whitened(own) ** 2).sum()) for own in each)
    return float((fit.compared.whitened(np.sum(each, axis=0)) ** 2).sum()) / max(alone, 1e-300)


def undoes(fit: Fit, each: Sequence[np.ndarray], plain: Comparison) -> bool:
    """Return whether one of two effects brings the lines that it makes no nearer than they are without both.

    Parameters
    ----------
    fit : Fit
    each : sequence of ndarray
        As of `own_lines`.
    plain : Comparison
        Of the lines without any effect.
    """
    if len(fit.candidates) != 2 or fit.compared is None:
        return False
    lines = plain.lines
    apart = [
        unstacked(of.factor @ left, lines.parts) for of, left in ((plain, plain.residual), (fit.compared, fit.residual))
    ]
    before, after = (np.where(lines.seen, np.abs(own / lines.deviations) ** 2, 0.0) for own in apart)
    made = [lines.seen & (np.abs(own) > SHOWN * lines.deviations) for own in each]
    return any(own.any() and after[own].sum() >= before[own].sum() for own in made)


def rest_of_both(fit: Fit, problem: Problem) -> float:
    """Return `rest_of` two effects of a fit."""
    return rest_of(fit, own_lines(fit, problem)) if len(fit.candidates) == 2 else 1.0


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
