"""What the conditions that were held out say of the hypotheses: is the leading one right there, and better than others.

Evidence in the fitted conditions weighs priors as well as data, and supposes that the laws compared hold. The held-out
conditions are a second witness: a hypothesis, fitted to the others, gives their lines a density before they are seen.
They may withdraw a name but not give one, so that the gain stays one on recordings that nothing was chosen by: another
effect can draw level with the leading one, no more; nothing at all, or something unknown, can take its place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .baseline import again
from .evidence import law_columns
from .judged import TOLD_APART
from .predict import UnpredictableError
from .prediction import Predicted, given_others, prior_of
from .refine import Fit, Responses
from .search import MISFIT, Posterior

if TYPE_CHECKING:
    from .explain import Prepared

Names = tuple[str, ...]


def checked(prepared: Prepared, posterior: Posterior) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior after a look at the held-out conditions, and remarks on what that has changed."""
    leading = next(iter(posterior.probabilities))
    if not prepared.held_out or "unknown" in leading:
        return posterior, ()
    fits = {fit.names: fit for fit in reversed((*posterior.fits, posterior.none))}
    found = {names: predicted(fit, prepared) for names, fit in fits.items()}
    known = {names: one for names, one in found.items() if one is not None}
    seen = replace(posterior, held_out=known)
    if leading not in known:
        return seen, ()
    if known[leading].chance < MISFIT:
        return _refuted(seen, leading)
    return _levelled(seen, leading)


def predicted(fit: Fit, prepared: Prepared) -> Predicted | None:
    """Return how probable the held-out lines are under a hypothesis fitted to the others.

    None where the motion does not repeat with the shaft, as each derivative is then a simulation, or where something
    unknown acts beside the effect.
    """
    problem = prepared.problem(range(len(prepared.measured.conditions)))
    if fit.unknown_beside:
        return None
    if not fit.candidates:
        compared = problem.plain()
        return given_others(compared, compared.residual, np.zeros((0, compared.residual.size)), prepared.held_out)
    predictor = problem.predictor
    try:
        if fit.problem is not None:
            problem = problem.moved(fit.problem.baseline.position - problem.baseline.position)
        own = problem.baseline.machine
        if not predictor.repeats(fit.machine(own)):
            return None
        around = again(problem.baseline, fit.machine(own), predictor)
        response = around.lines - predictor.amplitudes(own)
        alive = np.ones(fit.position.size, dtype=bool)
        slopes = Responses(fit.candidates, own, predictor).slopes(fit.position, response, alive)
    except UnpredictableError:
        return None
    compared = problem.around(around, response)
    residual, directions = prior_of(fit, compared.residual, compared.whitened(slopes), law_columns(compared, response))
    return given_others(compared, residual, directions, prepared.held_out)


def _refuted(posterior: Posterior, leading: Names) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior where the leading hypothesis leaves more of the held-out lines than noise would."""
    chance = posterior.held_out[leading].chance
    shares = dict(posterior.probabilities)
    shares["unknown",] = max(shares["unknown",], shares[leading] * MISFIT / max(chance, 1e-300))
    what = "The model without any effect" if not leading else f"With {_said(leading)} the model"
    text = f"{what} misses the held-out conditions by more than noise (chance {chance:.0e}): something else acts."
    return _with(posterior, shares), (text,)


def _levelled(posterior: Posterior, leading: Names) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior where hypotheses that the held-out conditions favour are as probable as all lines say."""
    top, shares, level = posterior.probabilities[leading], dict(posterior.probabilities), []
    for names, one in posterior.held_out.items():
        if names == leading or not shares.get(names):
            continue
        more = one.log_density - posterior.held_out[leading].log_density
        after = math.log(shares[names] / top) + more
        if more > 0:
            # Only nothing at all may pass: that takes a name away.
            shares[names] = top * math.exp(after if not names else min(after, 0.0))
            if leading and TOLD_APART * shares[names] > top > TOLD_APART * posterior.probabilities[names]:
                level.append(names)
    said = " and ".join(_said(names) or "nothing at all" for names in level)
    text = f"The held-out conditions are predicted better by {said} than by {_said(leading)}."
    return _with(posterior, shares), ((text,) if level else ())


def _with(posterior: Posterior, shares: Mapping[Names, float]) -> Posterior:
    whole = sum(shares.values())
    # Python's sort keeps the order of those that are level.
    ordered = sorted(shares.items(), key=lambda item: -item[1])
    return replace(posterior, probabilities={names: share / whole for names, share in ordered})


def _said(names: Names) -> str:
    return " and ".join(name.replace("_", " ") for name in names)
