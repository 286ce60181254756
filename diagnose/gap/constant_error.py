"""What a model misses of a healthy line alike in all conditions: a shaft's run-out under a probe, a mark on it.

It hides nothing: what is new beside it is as clear as if it were not there. Taken for an error that changes with speed,
it would be interpolated, and a fault would have to stand out of what that leaves open. Lines with phase tell it: no
error that changes keeps size and direction in several conditions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .error_smoothness import line_likelihoods
from .lines import Condition
from .model_error import ModelError

#: Shares of the variance that all conditions have in common that are tried, and by how much the logarithm of a line's
#: likelihood must rise for one. More than the last nobody can promise for another day.
SHARES, LEAST_RISE = (0.9, 0.99, 0.999), 5.0
#: Conditions that tell it.
FEWEST = 3


def with_constant_parts(
    error: ModelError,
    grown: Sequence[ModelError],
    conditions: tuple[Condition, ...],
    left: np.ndarray,
    noise: np.ndarray,
    parts: np.ndarray,
) -> ModelError:
    """Return the error with those lines in which a constant part makes the healthy lines clearly likelier.

    Parameters
    ----------
    error : ModelError
        Without such parts.
    grown : sequence of ModelError
        The same where each line has the size that is likeliest if it grows by one power of speed, each power once:
        a part that is alike in all conditions may grow by another one than what all lines of a probe show together.
    conditions, left, noise, parts
        As of `length_of`.
    """
    told = (np.isfinite(noise).sum(axis=0) >= FEWEST) & (parts == 2)
    best = np.where(told, line_likelihoods(conditions, left, noise, error, parts) + LEAST_RISE, np.inf)
    deviation, growth, common = error.deviation, np.broadcast_to(error.growth, best.shape), np.zeros(best.shape)
    for one in grown:
        for share in SHARES:
            tried = replace(one, common=np.full(best.shape, share))
            own = line_likelihoods(conditions, left, noise, tried, parts)
            better = own > best
            best, common = np.where(better, own, best), np.where(better, share, common)
            deviation, growth = np.where(better, one.deviation, deviation), np.where(better, one.growth, growth)
    return replace(error, deviation=deviation, growth=growth, common=common)
