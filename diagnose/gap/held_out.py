"""What the conditions that were held out say of the hypotheses: is the leading one right there, and better than others.

Evidence in the fitted conditions weighs priors as well as data, and supposes that the laws compared hold. The held-out
conditions are a second witness: a hypothesis, fitted to the others, gives their lines a density before they are seen.
They may withdraw a name but not give one, so that the gain stays one on recordings that nothing was chosen by: another
effect can draw level with the leading one, no more; nothing at all, or something unknown, can take its place. Of those
that are level the best there is shown first, and that is said. Densities hold what the machine's own unknowns leave
open; where these are wide, and the evidence of a fit on a long ridge is uncertain, the plain distance from the most
probable lines tells more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .baseline import again
from .climb import FIRST_STEPS, climbed, laws_of
from .evidence import Problem
from .force_kernels import force_kernels
from .gain import predicted_db, smooth_db
from .joint_fit import jointly
from .judged import TOLD_APART
from .null_distribution import chance_of_residual
from .posterior import Posterior
from .predict import UnpredictableError
from .prediction import Predicted, given_others, prior_of
from .refine import Fit
from .responses import Responses
from .result import AS_GOOD_DB
from .search import GOOD
from .shown_lines import SHOWN
from .two_effects import LITTLE, MISFIT, MOVES
from .unknown_force import unexplained
from .within_law import PAIR_MARGIN

if TYPE_CHECKING:
    from .prepared import Prepared

Names = tuple[str, ...]
#: A name that brings the held-out lines so much farther from where they are than the calibrated machine has them is
#: none, whatever density its uncertainty gives them. Nor is one without a density, where a function of speed that knows
#: no physics brings them so much nearer, and the name not half of the way: between neighbouring speeds such a function
#: may well be more exact than a physical one.
WORSE_DB = 1.0
#: A rival whose held-out error is this much smaller draws level, of the most probable ones.
BETTER_DB, RIVALS = 3.0, 4
#: Not another name whose evidence is smaller by more than this: the fitted lines speak clearly against it. Fewer names
#: may, as they only take one away, but where lines stand out that these do not make. Where the one taken away makes
#: more than this share of what both explain, something unknown does so in their place.
HOPELESS, MADE_BY_OTHER = 50.0, 0.1
#: And stands in front of what it is level with, the best one first: too little to count as more probable.
AHEAD = 1e-6
#: Starts about a fit, so many of its standard deviations wide.
STARTS_NEAR, WIDER = 6, 2.0
#: Probability that a pulse is elsewhere than at the model's zero, where that explains all and nobody knows.
ELSEWHERE = 0.45
#: Evidence of a name, or of something unknown, over that of nothing at all, where this leaves only noise and no other
#: condition confirms a name: twice what a second effect has to add.
STRONGLY = 2 * PAIR_MARGIN
#: A logarithm of a ratio that is as good as certain, and no overflow.
LARGEST = 100.0


def checked(prepared: Prepared, posterior: Posterior) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior after a look at the held-out conditions, and remarks on what that has changed."""
    leading = next(iter(posterior.probabilities))
    if not prepared.held_out:
        return _without_witness(posterior)
    if leading == ("unknown",):
        return _form_not_known(posterior, prepared)
    fits: dict[Names, Fit] = {}
    for fit in (*posterior.fits, posterior.none):
        fits.setdefault(fit.names, fit)
    found = {names: predicted(fit, prepared) for names, fit in fits.items()}
    known = {names: one for names, one in found.items() if one is not None}
    if leading in known and known[leading].own_chance < MISFIT:
        # A contact that opens at another speed than the fit has it is no other cause: look from where all is explained.
        nearer = predicted(fits[leading], prepared, moves=MOVES) or known[leading]
        known[leading] = max(known[leading], nearer, key=lambda one: one.log_density)
    wrong = leading in known and known[leading].own_chance < MISFIT
    # Of an effect beside something unknown only its own order was looked at: no density to set beside those of others.
    seen = replace(posterior, held_out={names: one for names, one in known.items() if "unknown" not in names})
    if "unknown" in leading:
        text = f"What {_said(leading[:-1])} would make alone is not there in the held-out conditions: no name."
        return _unnamed(seen, leading, text) if wrong else (seen, ())
    if wrong:
        return _refuted(seen, prepared, fits[leading])
    levelled, remarks = _levelled(seen, prepared, fits)
    if leading in known and known[leading].chance < MISFIT:
        said = _said(leading)
        remarks += (
            f"In the held-out conditions lines stand out that {said} does not make: something else acts there.",
        )
    return levelled, remarks


def _without_witness(posterior: Posterior) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior where no condition could be held out: a name is then told by the fitted lines alone.

    Where nothing at all leaves only noise of these, they must tell it strongly.
    """
    leading = next(iter(posterior.probabilities))
    fitted = {fit.names: fit for fit in reversed(posterior.fits)}
    if leading not in fitted or "unknown" in leading or chance_of_residual(posterior.none) <= GOOD:
        return posterior, ()
    ahead = fitted[leading].log_evidence - posterior.none.log_evidence
    return _as_nothing(posterior, leading, _NO_WITNESS) if ahead < STRONGLY else (posterior, ())


def _form_not_known(posterior: Posterior, prepared: Prepared) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior in which something unknown gives way to nothing, where that may be the machine's own form.

    How well the model describes the healthy machine only healthy recordings say. Without these, what is merely likelier
    than noise, where noise would do, is no news of a fault.
    """
    if prepared.healthy is not None:
        return posterior, ()
    none = predicted(posterior.none, prepared)
    seen = replace(posterior, held_out={(): none} if none else {})
    return _as_nothing(seen, ("unknown",), _FORM) if _needs_nothing(seen) else (posterior, ())


def with_pulse_elsewhere(prepared: Prepared, posterior: Posterior) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior where the tacho's pulse at another angle would explain all lines, and the remark.

    Without healthy recordings a cause is then hardly more likely; something unknown is not claimed.
    """
    leading = next(iter(posterior.probabilities))
    elsewhere_rad = prepared.by_lines.elsewhere_rad if prepared.by_lines else 0.0
    if not elsewhere_rad or not leading:
        return posterior, ()
    text = _ELSEWHERE.format(math.degrees(elsewhere_rad))
    if "unknown" in leading:
        return _as_nothing(posterior, leading, text)
    shares = {names: (1 - ELSEWHERE) * share for names, share in posterior.probabilities.items()}
    shares[()] = shares.get((), 0.0) + ELSEWHERE
    return _with(posterior, shares), (text,)


def predicted(fit: Fit, prepared: Prepared, *, moves: int = 0) -> Predicted | None:
    """Return how probable the held-out lines are under a hypothesis, given the fitted ones.

    None where the motion does not repeat with the shaft, as each derivative is then a simulation. Where something
    unknown acts beside the effect, only the orders that are left to the effect are looked at.

    Parameters
    ----------
    fit : Fit
        To the fitted conditions: there everything is taken as linear.
    prepared : Prepared
    moves : int
        How often the point where everything is linear is moved towards what all conditions together say.
    """
    problem = prepared.problem(range(len(prepared.measured.conditions)))
    if fit.unknown_beside and fit.compared is not None:
        problem = _without(problem, fit.unknown_beside)
        problem = replace(problem, transfer=fit.compared.transfer)
    if not fit.candidates:
        compared = problem.plain()
        return given_others(compared, compared.residual, np.zeros((0, compared.residual.size)), prepared.held_out)
    try:
        if fit.problem is not None:
            problem = problem.moved(fit.problem.baseline.position - problem.baseline.position)
        if not problem.predictor.repeats(fit.machine(problem.baseline.machine)):
            return None
        if moves:
            fit = jointly(_from_near(fit, problem), problem, moves=moves)
            problem = fit.problem or problem
        return _given_fitted(fit, problem, prepared.held_out)
    except UnpredictableError:
        return None


def _from_near(fit: Fit, problem: Problem) -> Fit:
    """Return the fit a few steps nearer to what all conditions say, from the best of several starts about it."""
    draws = np.random.default_rng(0).multivariate_normal(fit.position, WIDER**2 * fit.covariance, size=STARTS_NEAR)
    machine, predictor = problem.baseline.machine, problem.predictor
    tried = climbed(fit.candidates, [fit.position, *draws], problem.plain(), machine, predictor, steps=FIRST_STEPS)
    if not tried:
        raise UnpredictableError(f"No start near {_said(fit.names)} can be computed.")
    return replace(fit, position=tried[0].position, response=tried[0].added)


def _given_fitted(fit: Fit, problem: Problem, held_out: Sequence[int]) -> Predicted:
    own, predictor = problem.baseline.machine, problem.predictor
    around = again(problem.baseline, fit.machine(own), predictor)
    response = around.lines - predictor.amplitudes(own)
    alive = np.ones(fit.position.size, dtype=bool)
    responses = Responses(fit.candidates, own, predictor)
    slopes = responses.slopes(fit.position, response, alive)
    inexact = fit.compared.inexact if fit.compared is not None else 1.0
    compared = replace(problem.around(around, response), inexact=inexact)
    law = laws_of(compared, fit.candidates, responses.own(fit.position, response))
    residual, directions = prior_of(fit, compared.residual, compared.whitened(slopes), law.directions)
    size = np.where(compared.seen, np.abs(response) / problem.lines.deviations, 0.0)
    return given_others(compared, residual, directions, held_out, made=size.max(axis=(0, 1)) > SHOWN)


def _without(problem: Problem, orders: frozenset[int]) -> Problem:
    """Return the problem with some orders not looked at."""
    kept = np.array([number not in orders for number in range(len(problem.lines.orders))])
    deviations = np.where(kept, problem.lines.deviations, np.inf)
    return replace(problem, lines=replace(problem.lines, deviations=deviations))


def _unnamed(seen: Posterior, leading: Names, remark: str) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior in which something unknown takes the place of the leading hypothesis, and the remark."""
    shares = dict(seen.probabilities)
    shares["unknown",] = shares.get(("unknown",), 0.0) + shares.pop(leading)
    return _with(seen, shares), (remark,)


def _no_nearer(leading: Names) -> str:
    """Return what is said of a cause that nothing but its distance from the held-out lines can confirm."""
    return (
        f"With {_said(leading)}, likeliest in the fitted conditions, the held-out ones are predicted no better than by "
        "the calibrated machine: no name."
    )


def _nearer_without(names: Names, leading: Names) -> str:
    other = _said(tuple(name for name in leading if name not in names))
    return (
        f"The held-out conditions are predicted better without {other}, which makes much of the others: something else "
        f"acts there, or {other} has other values."
    )


def _refuted(seen: Posterior, prepared: Prepared, leading: Fit) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior where the leading hypothesis leaves more of the held-out lines than noise would.

    Something unknown takes its place as far as that predicts them better: every model of a real machine is wrong. Of a
    name also where it brings them farther from where they are.
    """
    if leading.names and predicted_db([leading], prepared)[0] <= -WORSE_DB:
        return _unnamed(seen, leading.names, _no_nearer(leading.names))
    own, shares = seen.held_out[leading.names], dict(seen.probabilities)
    what = f"With {_said(leading.names)} the model" if leading.names else "The model without any effect"
    text = f"{what} misses the held-out conditions by more than noise (chance {own.own_chance:.0e})"
    more = seen.unknown.log_evidence + _unknown_density(prepared, seen) - leading.log_evidence - own.log_density
    shares["unknown",] = max(shares["unknown",], shares[leading.names] * math.exp(min(more, LARGEST)))
    better = shares["unknown",] > shares[leading.names]
    return _with(seen, shares), (f"{text}{': something else acts' if better else ', and nothing known does better'}.",)


def _unknown_density(prepared: Prepared, seen: Posterior) -> float:
    """Return the logarithm of the density of the held-out lines, given the others, if something unknown acts."""
    problem = prepared.problem(range(len(prepared.measured.conditions)))
    tied = all(one.tied for one in problem.predictor.conditions)
    kernels = force_kernels(problem.baseline.machine, problem.predictor) if tied else ()
    return unexplained(problem.plain(), kernels).log_evidence - seen.unknown.log_evidence


def _levelled(seen: Posterior, prepared: Prepared, fits: Mapping[Names, Fit]) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior where hypotheses that the held-out conditions favour are as probable as all lines say."""
    leading = next(iter(seen.probabilities))
    shares, top = dict(seen.probabilities), seen.probabilities[leading]
    for names, one in seen.held_out.items():
        more = one.log_density - seen.held_out[leading].log_density if leading in seen.held_out else 0.0
        if more > 0 and shares.get(names):
            after = math.log(shares[names] / top) + more
            # Only nothing at all may pass: that takes a name away.
            shares[names] = top * math.exp(min(after, 0.0 if names else LARGEST))
    unconfirmed = False
    if leading and "unknown" not in leading:
        rivals = [names for names in fits if names not in ((), leading) and "unknown" not in names][:RIVALS]
        own, *others = predicted_db([fits[names] for names in (leading, *rivals)], prepared)
        refused = _not_confirmed(seen, prepared, fits[leading], own)
        if refused is not None:
            return refused
        unconfirmed = leading not in seen.held_out and own <= 0
        for names, other in zip(rivals, others, strict=True):
            fewer, behind = set(names) < set(leading), fits[leading].log_evidence - fits[names].log_evidence
            if fewer and _others_stand_out(seen.held_out.get(names)):
                continue
            if other > own + BETTER_DB and (fewer or behind < HOPELESS):
                most = fits[leading].log_evidence - seen.none.log_evidence
                if fewer and behind > max(HOPELESS, MADE_BY_OTHER * most):
                    return _unnamed(seen, leading, _nearer_without(names, leading))
                shares[names] = top * (1 + AHEAD * (other - own))
    level = [names for names in shares if TOLD_APART * shares[names] > top > TOLD_APART * seen.probabilities[names]]
    said = " and ".join(_said(names) or "nothing at all" for names in level)
    text = f"The held-out conditions are predicted better by {said} than by {_said(leading)}."
    if any(shares[names] > top for names in level if names):
        text += " For that it stands in front: the gain on these conditions is then no independent one."
    remarks = (text,) if level and leading else ()
    return _with(seen, shares), (*remarks, *([_SILENT.format(_said(leading))] if unconfirmed else []))


def _not_confirmed(
    seen: Posterior, prepared: Prepared, leading: Fit, own_db: float
) -> tuple[Posterior, tuple[str, ...]] | None:
    """Return the posterior without the leading name, where the held-out lines are no nearer with it; None where so."""
    names, has_density = leading.names, leading.names in seen.held_out
    # Sizes of a machine that does not repeat itself are predicted to a factor: only a clear gain confirms.
    least = 0.0 if prepared.predictor.repeats(prepared.baseline.machine) else AS_GOOD_DB
    if own_db <= least and _needs_nothing(seen):
        # All lines together may look like noise where most are doubted, and some stand out of it all the same.
        stands_out = seen.unknown.log_evidence - seen.none.log_evidence >= STRONGLY
        return _unnamed(seen, names, _no_nearer(names)) if stands_out else _as_nothing(seen, names)
    nothing_to_gain = _nothing_to_gain(seen)
    lost = WORSE_DB if has_density else AS_GOOD_DB if nothing_to_gain else 0.0
    if own_db <= -lost:
        return _unnamed(seen, names, _no_nearer(names))
    smooth = -math.inf if has_density or nothing_to_gain else smooth_db(leading.position.size, prepared)
    if smooth > own_db + WORSE_DB and _explained(own_db) < LITTLE * _explained(smooth):
        return _unnamed(seen, names, _SMOOTH_IS_NEARER.format(_said(names), own_db, smooth))
    return None


def _explained(gain_db: float) -> float:
    """Return the share of a squared error that is gone when it has fallen by so many dB."""
    return 1 - 10 ** (-gain_db / 10)


def _needs_nothing(seen: Posterior) -> bool:
    """Return whether nothing at all leaves only noise, in the conditions that were fitted and in those held out."""
    there = seen.held_out.get(())
    return there is not None and there.chance > MISFIT and chance_of_residual(seen.none) > GOOD


def _nothing_to_gain(seen: Posterior) -> bool:
    """Return whether the held-out lines are as the machine makes them without any effect.

    An effect that is not to be seen there, as a clearance that closes at other speeds, then predicts just that.
    """
    there = seen.held_out.get(())
    return there is not None and there.chance > GOOD


_SILENT = (
    "In the held-out conditions nothing differs from the calibrated machine, and with {} hardly anything should: they "
    "do not confirm it."
)
_SMOOTH_IS_NEARER = (
    "With {}, likeliest in the fitted conditions, the held-out error falls by {:.1f} dB, but by {:.1f} dB with a "
    "smooth function of speed that has as many values: no name."
)
_NO_NEARER = (
    "{} makes the fitted lines likelier, but the held-out conditions are predicted no better with it, and without any "
    "effect only noise is left: no name."
)
_NO_WITNESS = (
    "{} would make the lines somewhat likelier, but without any effect only noise is left, and there are too few "
    "conditions to hold one out that could confirm it: no name. Record at a fourth speed."
)
_FORM = (
    "{} would make the lines likelier, but without any effect only noise is left, and no recording shows how well the "
    "model describes this machine when it is healthy: nothing is claimed. Recordings of the healthy machine "
    "(--baseline) would tell."
)
_ELSEWHERE = (
    "If the tacho's pulse comes when the model has turned by {:.0f} deg, and not at its zero, the machine by itself "
    "explains all lines and nothing is wrong. Look where the mark is, or give recordings of the healthy machine "
    "(--baseline)."
)


def _as_nothing(seen: Posterior, leading: Names, text: str = _NO_NEARER) -> tuple[Posterior, tuple[str, ...]]:
    """Return the posterior in which nothing at all takes the place of the leading hypothesis, and the remark."""
    shares = dict(seen.probabilities)
    shares[()] = shares.get((), 0.0) + shares.pop(leading)
    said = "Something unknown" if leading == ("unknown",) else _said(leading)
    return _with(seen, shares), (text.format(f"{said[0].upper()}{said[1:]}"),)


def _others_stand_out(seen: Predicted | None) -> bool:
    """Return whether a hypothesis is right in the lines that it makes, and others stand out: it is not all there is."""
    return seen is not None and seen.chance < MISFIT <= seen.own_chance


def _with(posterior: Posterior, shares: Mapping[Names, float]) -> Posterior:
    whole = sum(shares.values())
    # Python's sort keeps the order of those that are level.
    ordered = sorted(shares.items(), key=lambda item: -item[1])
    return replace(posterior, probabilities={names: share / whole for names, share in ordered})


def _said(names: Names) -> str:
    return " and ".join(name.replace("_", " ") for name in names)
