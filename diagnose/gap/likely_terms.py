"""Which of many terms healthy lines ask for, all looked at together.

Each term has a strength of unknown size: a normal variable whose variance is whatever makes the lines likeliest
(automatic relevance determination; D. J. C. MacKay, Neural Computation 4 (1992) 415, M. E. Tipping, J. Machine Learning
Research 1 (2001) 211). The variances of terms that are not needed shrink to nothing. One term at a time would not do:
where a support is wrong in three ways, none of them alone makes the lines much likelier.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .baseline import Baseline
from .healthy_evidence import ERROR_FACTORS, whitened
from .lacking_terms import Term
from .lines import OrderLines, stacked
from .whitening import lower_solved

#: Variance of each strength at the start, in its own prior variances; below the last one a term is not needed.
START, NOTHING = 0.1, 1e-3
#: Steps, each of which fits the strengths and then their variances.
STEPS = 300
#: Range of variances.
LEAST, MOST = 1e-9, 4.0


def likely_terms(current: Baseline, healthy: OrderLines, terms: Sequence[Term]) -> list[Term]:
    """Return the terms whose strengths are not nothing where the lines are likeliest.

    Parameters
    ----------
    current : Baseline
        Calibrated, in the healthy conditions.
    healthy : OrderLines
    terms : sequence of Term
        That may be added to it.
    """
    if not terms:
        return []
    owner = np.repeat(np.arange(len(terms)), [len(term.strengths) for term in terms])
    shapes = stacked(np.concatenate([term.slopes for term in terms]), healthy.parts)
    best, kept = -np.inf, np.zeros(len(terms))
    for factor in ERROR_FACTORS:
        lower, white, density = whitened(current, healthy, factor)
        moved = lower_solved(lower, shapes.T)
        found, rise = _variances(moved.T @ moved, moved.T @ white, owner)
        if density + rise > best:
            best, kept = density + rise, found
    return [term for term, variance in zip(terms, kept, strict=True) if variance > NOTHING]


def _variances(inner: np.ndarray, along: np.ndarray, owner: np.ndarray) -> tuple[np.ndarray, float]:
    """Return each term's variance, and by how much they raise the logarithm of the density.

    ``inner`` (strengths, strengths) are the products of the whitened directions, ``along`` (strengths,) their products
    with the residual, ``owner`` (strengths,) the number of the term to which each belongs.
    """
    variance = np.full(owner.max() + 1, START)
    for _ in range(STEPS):
        each = variance[owner]
        covariance, mean = _posterior(inner, along, each)
        # MacKay's rule: the mean's power over how far the lines tell the strength at all.
        told = np.bincount(owner, 1 - np.diag(covariance) / each)
        variance = np.clip(np.bincount(owner, mean**2) / np.maximum(told, 1e-9), LEAST, MOST)
    each = np.sqrt(variance[owner])
    more = np.eye(owner.size) + each[:, None] * inner * each
    _, mean = _posterior(inner, along, each**2)
    return variance, 0.5 * float(along @ mean) - 0.5 * float(np.linalg.slogdet(more)[1])


def _posterior(inner: np.ndarray, along: np.ndarray, variance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return covariance and mean of the strengths at given variances."""
    root = np.sqrt(variance)
    covariance = root[:, None] * np.linalg.inv(np.eye(root.size) + root[:, None] * inner * root) * root
    return covariance, covariance @ along
