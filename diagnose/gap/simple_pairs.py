"""Pairs of effects that bend little: neither a contact nor a crack, nor simulated in time.

A contact bends itself to much of what two other effects make, so that alone it is far ahead of both, and neither leads
a pair (`two_effects`). What these two make together costs little to look at, and is looked at first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from .evidence import Problem
from .refine import Fit
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
    may_gain,
    repeat,
    screened_beside,
)
from .within_law import pair_level

#: Single effects whose partners are looked at, and pairs of which some steps are made.
LEADERS, PAIRS = 5, 6

Tell = Callable[[str], None]


def simple_pairs(
    singles: Sequence[Fit],
    screening: Screening,
    problem: Problem,
    none: Fit,
    unknown: float,
    tell: Tell = lambda _: None,
) -> list[Fit]:
    """Return the fits of two such effects that have clearly more evidence than the best of one; as `two_effects`."""
    if not problem.predictor.repeats(problem.baseline.machine):
        return []
    every = best_of_each(singles)
    best = pair_level(every[0], none, misfit=MISFIT)
    hopeless = hopeless_beside(every[0], none, unknown)
    tried: set[frozenset[object]] = set()
    found = []
    for leader, options in _likeliest([fit for fit in every if may_gain(fit, best)], screening, problem, tell):
        both = frozenset((leader.candidates[0], options[0].candidate))
        if both in tried or not repeat(leader, options[0], problem):
            continue
        tried.add(both)
        tell(f"{leader.candidates[0]} with {options[0].candidate}")
        fit = fitted_pair(leader, options[:STARTS], problem, none, hopeless=hopeless)
        found += [fit] if fit else []
        if len(tried) == PAIRS:
            break
    return best_jointly(found, problem, best, unknown)


def _likeliest(
    fits: Sequence[Fit], screening: Screening, problem: Problem, tell: Tell
) -> list[tuple[Fit, list[Start]]]:
    """Return effects with the starts of a partner, by their first look."""
    simple = replace(screening, atoms={one: own for one, own in screening.atoms.items() if not one.effect.IDEALISED})
    found = []
    for leader in [fit for fit in fits if not fit.candidates[0].effect.IDEALISED][:LEADERS]:
        beside = screened_beside(leader, simple, problem, ("sensor", "structure"), tell)
        others = few_of_each(beside.against(left_beside(leader, screening)))
        found += [(leader, options) for options in others if options[0].candidate.name not in leader.names]
    return sorted(found, key=lambda pair: -pair[1][0].score)
