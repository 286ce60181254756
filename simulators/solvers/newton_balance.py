"""The balance of harmonics for forces that are not linear in the motion: Newton's method.

In each step the forces that bend are replaced by their slopes along the motion found last. Beside
these, nearly linear forces keep their slopes, as `condensed_balance` tells.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .along_motion import NO_PAIRS, linearised, pushed_along
from .condensed_balance import Condensed, condensed
from .periodic_balance import Responses, Slopes, slopes_of, solved, spectrum_of, with_slopes
from .periodic_forces import PeriodicForces

MOST_STEPS = 30
#: Relative change of the motions at which Newton's method ends, and above which it has found nothing.
TOLERANCE, WORST = 1e-10, 1e-6
#: Shares in which forces are let in, what the last but one leaves out, and steps of Newton's method at each.
SHARES, LEFT_OUT, FEW_STEPS = 24, 1e-3, 12
#: Steps on to the farthest share at which the next balance is sought.
FARTHEST = 4
#: Relative change of the slopes that are kept from which on others may lead to a balance.
CHANGED = 0.01


def balanced_newton(
    forces: PeriodicForces,
    responding: Responses,
    start: np.ndarray | None = None,
    cases: Sequence[int] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the harmonics of the forces in balance, (lanes, K + 1, forces), and the last relative change of each lane.

    From ``start``, motions (lanes, K + 1, motions), or from rest. Of lanes of one case, by its number (lanes,), none is
    sought any further where one has been given up. Where that start leads nowhere, as with contacts that open and
    close, the forces that bend are let in little by little, each balance being sought from the one before. Nearly
    linear forces beside these keep the slopes that they begin with; where they have changed, or not even a share leads
    to a balance, all slopes are computed in each step. A lane that does not converge ends with a change above `WORST`,
    or not a number.
    """
    constant, slope = forces.linear_parts()
    given, linear = spectrum_of(constant, responding.top), slopes_of(slope, responding.top)
    lanes, shape = np.arange(given.shape[0]), constant.shape
    begun = np.zeros(responding.factors.shape, dtype=complex)
    if start is not None:
        reads = np.unique(np.concatenate([forces.systems[0].inputs[k] for k in forces.nonlinear]))
        begun[:, :, reads] = start[:, :, reads]
    mild = tuple(k for k in forces.nonlinear if forces.forces[k].law.nearly_linear)
    if len(mild) == len(forces.nonlinear):
        # Where nothing bends two or three steps are enough: taking kept slopes into the responses would cost more.
        mild = ()
    kept = linearised(forces, lanes, begun, shape, mild)[1]
    part = condensed(forces, given, linear, responding, kept, mild)
    case = lanes if cases is None else np.asarray(cases)
    found, change = _balanced(forces, part, lanes, begun, shape, case)
    lost = np.flatnonzero(np.logical_and(~(change < WORST), _have_changed(forces, part, found, shape)))
    if lost.size:
        whole = condensed(forces, given, linear, responding, Slopes(NO_PAIRS, kept.spectrum[:0]), ())
        found[lost], change[lost] = _balanced(forces, whole, lost, begun[lost], shape, case)
    pushed = given + pushed_along(forces, forces.nonlinear, lanes, found, shape)
    return with_slopes(pushed, linear, solved(pushed, linear, responding)), change


def _balanced(
    forces: PeriodicForces,
    part: Condensed,
    lanes: np.ndarray,
    begun: np.ndarray,
    shape: tuple[int, ...],
    case: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return motions in balance and the last change of some lanes: at once, or the forces let in little by little."""
    found, change = _newton(forces, part, lanes, begun, shape)
    lost = np.flatnonzero(~(change < WORST))
    if lost.size and part.bent:
        found[lost], change[lost] = _let_in(forces, part, lanes[lost], shape, case)
    return found, change


def _have_changed(forces: PeriodicForces, part: Condensed, motions: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return of which lanes the kept slopes are others along a motion, (lanes,); also where it is no number."""
    kept = part.kept.spectrum
    if not kept.size:
        return np.zeros(motions.shape[0], dtype=bool)
    finite = np.asarray(np.isfinite(motions).all(axis=(1, 2)))
    motions = np.where(finite[:, None, None], motions, 0.0)
    _, there = linearised(forces, np.arange(motions.shape[0]), motions, shape, part.mild)
    away = np.abs(there.spectrum - kept).max(axis=(0, 2))
    return np.logical_or(~finite, away >= CHANGED * np.abs(kept).max(axis=(0, 2)))


def _newton(
    forces: PeriodicForces,
    part: Condensed,
    lanes: np.ndarray,
    start: np.ndarray,
    shape: tuple[int, ...],
    *,
    shares: np.ndarray | None = None,
    most: int = MOST_STEPS,
) -> tuple[np.ndarray, np.ndarray]:
    """Return motions (lanes, K + 1, motions) in balance and their last change.

    With ``shares`` (lanes,) of the forces that bend, or all of them. Each lane until it has converged: these forces are
    replaced by their slopes along the motion found last.
    """
    found, change, going = start.copy(), np.full(lanes.size, np.inf), np.arange(lanes.size)
    shares = np.ones(lanes.size) if shares is None else shares
    for _ in range(most):
        pushes, slopes = linearised(forces, lanes[going], found[going], shape, part.bent)
        slopes = Slopes(slopes.pairs, shares[going][:, None] * slopes.spectrum)
        pushes = shares[going][:, None, None] * pushes
        pushes = pushes + part.beside_kept(forces, lanes[going], found[going], shape)
        following = part.motions(lanes[going], pushes, slopes)
        scale = np.abs(following).max(axis=(1, 2))
        moved = np.abs(following - found[going]).max(axis=(1, 2))
        change[going] = np.divide(moved, scale, out=np.zeros(going.size), where=scale != 0)
        found[going] = following
        going = going[np.isfinite(change[going]) & (change[going] >= TOLERANCE)]
        if not going.size:
            break
    return found, change


def _let_in(
    forces: PeriodicForces, part: Condensed, lanes: np.ndarray, shape: tuple[int, ...], case: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return motions in balance and their last change, the forces that bend being let in little by little.

    What is left out falls by the same factor from step to step: a support that has lost nearly all of its stiffness
    changes most at the end. From each balance the next is sought `FARTHEST` steps on, then nearer, then farther; a lane
    that finds none there is given up. Where there was none at all, the motion is not a number.
    """
    best = np.zeros((lanes.size, *part.factors.shape[1:]), dtype=complex)
    change, at = np.full(lanes.size, np.inf), np.zeros(lanes.size, dtype=int)
    # Of each lane the steps that have not been tried from where it is, in their order.
    ahead = [_steps_ahead(0, FARTHEST) for _ in lanes]
    while (going := np.flatnonzero([bool(own) for own in ahead])).size:
        wide = np.array([ahead[lane].pop(0) for lane in going])
        shares = np.where(at[going] + wide == SHARES, 1.0, 1.0 - LEFT_OUT ** ((at[going] + wide) / SHARES))
        found, changed = _newton(forces, part, lanes[going], best[going], shape, shares=shares, most=FEW_STEPS)
        for lane, step, motion, last in zip(going, wide, found, changed, strict=True):
            if last < WORST:
                best[lane], at[lane] = motion, at[lane] + step
                change[lane] = last if at[lane] == SHARES else np.inf
                ahead[lane] = _steps_ahead(at[lane], 2 * step)
        given_up = [lane for lane in going if not ahead[lane] and at[lane] < SHARES]
        for lane in np.flatnonzero(np.isin(case[lanes], case[lanes[given_up]])):
            ahead[lane].clear()
    best[at == 0] = np.nan
    return best, change


def _steps_ahead(at: int, first: int) -> list[int]:
    """Return how many steps on the next balance is sought, ``first`` first, and none where all has been let in."""
    most = min(FARTHEST, SHARES - at)
    return sorted(range(1, most + 1), key=lambda step: (step != min(first, most), step))
