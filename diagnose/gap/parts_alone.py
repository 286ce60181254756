"""Each effect of the best pair alone, from where it was found beside the other: two must be better than either.

A narrow resonance, or a tooth's crack of one depth, is passed over by the first look at it alone, and is found beside
an effect that explains a part of the same lines. What it does without that one was never asked then.
"""

from __future__ import annotations

from collections.abc import Sequence

from .evidence import Problem
from .joint_fit import jointly
from .refine import Fit, refined
from .two_effects import MOVES, best_of_each


def parts_alone(pairs: Sequence[Fit], singles: Sequence[Fit], problem: Problem) -> list[Fit]:
    """Return the single effects, with each of the best pair fitted alone from its values there; the best first.

    As they are where the best pair is behind a single effect. About the machine that was fitted beside the pair.
    """
    best = best_of_each(pairs)[0]
    if best.log_evidence < max(fit.log_evidence for fit in singles):
        return list(singles)
    own = best.problem or problem
    machine, found = own.baseline.machine, list(singles)
    for one, place in best.parts:
        fit = refined([one], best.position[place], own.plain(), machine, own.predictor)
        found += [jointly(fit, own, moves=MOVES)] if fit else []
    return best_of_each(found, place=True)
