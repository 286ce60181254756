"""Two causes that together can look like a third: they work against each other, or make the same order at one speed.

A difference of two large responses takes many shapes, and the tolerances of two laws are shares of each, not of the
difference. What two causes explain only that way is as likely one cause that is not in the catalogue, or is there in
another shape: a bent shaft without its effect is a misaligned coupling and an unbalance that oppose each other.

How two causes grow with speed tells that there are two. At one speed only their shapes along the shaft do, and a sum of
two takes that of a third: a bump in a shaft is a bow of another shape with an unbalance.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .evidence import Problem
from .lines import different_speeds
from .refine import Fit
from .responses import Responses
from .two_effects import best_of_each, told_by_more_than_one_size

#: Share of the power of both alone below which what they make together is worth a warning, and below which they are not
#: named. Of one line and sizes unlike by up to 50, any phase, independent causes come so close in about 1 % of cases.
SMALL_REST, NEARLY_NOTHING = 0.3, 0.05
#: Two effects make the same orders where these hold more than half of what each makes.
SAME_ORDERS = 0.5


def told_pairs(pairs: Sequence[Fit], singles: Sequence[Fit], problem: Problem) -> tuple[list[Fit], tuple[Fit, ...]]:
    """Return the pairs of which both effects may be named, and those that only oppose each other.

    ``singles`` are the fits of one effect.
    """
    told = [fit for fit in pairs if told_by_more_than_one_size(fit, best_of_each(singles)[0])]
    opposed = tuple(
        fit for fit in told if rest_of_both(fit, problem) < NEARLY_NOTHING or same_orders_at_one_speed(fit, problem)
    )
    return [fit for fit in told if fit not in opposed], opposed


def same_orders_at_one_speed(fit: Fit, problem: Problem) -> bool:
    """Return whether two effects make mostly the same orders, and no second speed tells them apart.

    One of them may be what a sensor adds, as run-out: at one speed it shows the shape of nothing but that sensor.
    """
    lines = problem.lines
    if len(fit.candidates) != 2 or different_speeds(lines.conditions) > 1:
        return False
    each = [
        (np.abs(own / np.where(lines.seen, lines.deviations, np.inf)) ** 2).sum((0, 1)) for own in _each(fit, problem)
    ]
    first, second = (power / max(float(power.sum()), 1e-300) for power in each)
    return float(np.minimum(first, second).sum()) > SAME_ORDERS


def _each(fit: Fit, problem: Problem) -> list[np.ndarray]:
    """Return what each effect of a fit makes."""
    machine = (fit.problem or problem).baseline.machine
    return Responses(fit.candidates, machine, problem.predictor).own(fit.position, fit.response)


def rest_of_both(fit: Fit, problem: Problem) -> float:
    """Return the power, in lines of unit noise, of what two effects make together over that of both alone.

    1 where they have nothing to do with each other, and of one effect.
    """
    if len(fit.candidates) != 2 or fit.compared is None:
        return 1.0
    each = _each(fit, problem)
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
    if rest >= NEARLY_NOTHING and not same_orders_at_one_speed(fit, problem):
        return (
            f"{both[0].upper()}{both[1:]} would explain it together, but point along one line of the shaft, as two "
            "causes seldom do, and the parts of a third do that they take the shape of: they are not named."
        )
    if rest >= NEARLY_NOTHING:
        return (
            f"{both[0].upper()}{both[1:]} would explain it together, but make the same orders, and all recordings are "
            "of one speed: one cause of another shape along the shaft may look like that, so that they are not named. "
            "Record at another speed."
        )
    return (
        f"{both[0].upper()}{both[1:]} would explain it, but only against each other, as {rest:.1%} of the power of "
        "both is left: one other cause may look like that, so that they are not named."
    )
