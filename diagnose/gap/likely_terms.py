"""Which of many terms healthy lines ask for, all looked at together, by their slopes.

Each term has a strength of unknown size: a normal variable whose variance is whatever makes the lines likeliest
(automatic relevance determination; D. J. C. MacKay, Neural Computation 4 (1992) 415, M. E. Tipping, J. Machine Learning
Research 1 (2001) 211). The variances of terms that are not needed shrink to nothing. One term at a time would not do:
where a support is wrong in three ways, none of them alone makes the lines much likelier. Of what is left, those go that
the evidence, with the prior that the calibration gives each, does not need.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.effect import effect_catalogue
from ...simulators.effects.empirical_mesh import EmpiricalMesh
from ...simulators.effects.residual_coupling_harmonic import ResidualCouplingHarmonic
from .baseline import Baseline
from .healthy_evidence import ERROR_FACTORS, whitened
from .lacking_terms import TURNING, Term
from .lines import OrderLines

#: By how much a term must raise the logarithm of the evidence.
TERM_GAIN = 5.0
#: What every machine has, only not how much: unbalance of each rotor, run-out of couplings and gears, errors of teeth,
#: weight; and how much likelier that is than a change of a support, which must raise the evidence by so much more.
_PERMANENT = [name for name, effect in effect_catalogue().items() if effect.PERMANENT]
USUAL = frozenset(
    [*(effect.NAME for effect, _, _ in TURNING), ResidualCouplingHarmonic.NAME, EmpiricalMesh.NAME, *_PERMANENT]
)
ODDS = 20.0
#: Variance of each strength at the start, in its own prior variances; below the last one a term is not needed.
START, NOTHING = 0.1, 1e-3
#: Standard deviation of a strength that is taken as known.
KNOWN = 1e-6
#: Steps, each of which fits the strengths and then their variances.
STEPS = 300
#: Range of variances.
LEAST, MOST = 1e-9, 4.0


def price_of(term: Term) -> float:
    """Return by how much a term must raise the logarithm of the evidence."""
    return TERM_GAIN + (0.0 if term.effect.NAME in USUAL else math.log(ODDS))


def likely_terms(current: Baseline, healthy: OrderLines, terms: Sequence[Term]) -> list[Term]:
    """Return the terms that the healthy lines ask for, by their slopes at a calibrated machine.

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
    seen = _projected(current, healthy, [term.slopes for term in terms])
    found = [_variances(inner, along, seen.owner) for inner, along in zip(seen.inner, seen.along, strict=True)]
    best = max(range(len(found)), key=lambda i: seen.density[i] + found[i][1])
    chosen = [int(i) for i in np.flatnonzero(found[best][0] > NOTHING)]
    return [terms[i] for i in _needed(seen, chosen, terms)]


def needed_terms(current: Baseline, healthy: OrderLines, terms: Sequence[Term], parts: Sequence[slice]) -> list[Term]:
    """Return those terms of a calibrated machine that the healthy lines ask for; ``parts`` are their coordinates."""
    own, prior = [current.slopes[part] for part in parts], current.prior.copy()
    for part in parts:
        # Known to be where their prior has them: at nothing.
        prior[part] = KNOWN
    seen = _projected(replace(current, prior=prior), healthy, own)
    return [terms[i] for i in _needed(seen, list(range(len(terms))), terms)]


@dataclass(frozen=True, eq=False)
class _Projected:
    """Directions of strengths among whitened lines, for each size of the model error.

    Attributes
    ----------
    owner : ndarray (strengths,)
        The term to which each belongs.
    density : list of float
        Logarithm, without any term.
    inner : list of ndarray (strengths, strengths)
        Products of the directions.
    along : list of ndarray (strengths,)
        Their products with the residual.
    """

    owner: np.ndarray
    density: list[float]
    inner: list[np.ndarray]
    along: list[np.ndarray]

    def evidence(self, chosen: Sequence[int]) -> float:
        """Return the logarithm of the evidence with some of the terms, of unit variance."""
        own = np.isin(self.owner, chosen)
        cases = zip(self.density, self.inner, self.along, strict=True)
        return max(density + _rise(inner[np.ix_(own, own)], along[own]) for density, inner, along in cases)


def _projected(current: Baseline, healthy: OrderLines, slopes: Sequence[np.ndarray]) -> _Projected:
    owner = np.repeat(np.arange(len(slopes)), [len(one) for one in slopes])
    found = _Projected(owner, [], [], [])
    for factor in ERROR_FACTORS:
        covariance, white, density = whitened(current, healthy, factor)
        moved = covariance.whole(np.concatenate(slopes))
        found.density.append(density)
        found.inner.append(moved @ moved.T)
        found.along.append(moved @ white)
    return found


def _needed(seen: _Projected, chosen: list[int], terms: Sequence[Term]) -> list[int]:
    """Return which of the chosen terms are left when those that raise the evidence too little have gone."""
    while chosen:
        whole = seen.evidence(chosen)
        others = [[i for i in chosen if i != leaving] for leaving in chosen]
        worth = [whole - seen.evidence(kept) - price_of(terms[i]) for i, kept in zip(chosen, others, strict=True)]
        weakest = int(np.argmin(worth))
        if worth[weakest] >= 0:
            break
        chosen = others[weakest]
    return chosen


def _rise(inner: np.ndarray, along: np.ndarray) -> float:
    """Return by how much directions of unit variance raise the logarithm of a density."""
    more = np.eye(along.size) + inner
    return 0.5 * float(along @ np.linalg.solve(more, along)) - 0.5 * float(np.linalg.slogdet(more)[1])


def _variances(inner: np.ndarray, along: np.ndarray, owner: np.ndarray) -> tuple[np.ndarray, float]:
    """Return each term's likeliest variance, and by how much they raise the logarithm of the density."""
    variance = np.full(owner.max() + 1, START)
    for _ in range(STEPS):
        root = np.sqrt(variance[owner])
        # Of the strengths in their deviations.
        covariance = np.linalg.inv(np.eye(root.size) + root[:, None] * inner * root)
        mean = root * (covariance @ (root * along))
        # MacKay's rule: the mean's power over how far the lines tell the strength at all.
        told = np.bincount(owner, 1 - np.diag(covariance))
        variance = np.clip(np.bincount(owner, mean**2) / np.maximum(told, 1e-9), LEAST, MOST)
    root = np.sqrt(variance[owner])
    return variance, _rise(root[:, None] * inner * root, root * along)
