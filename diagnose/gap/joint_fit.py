"""A hypothesis and the machine's own unknowns together: each where the measured and the healthy lines want both."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .baseline import Baseline, again, shifted
from .climb import laws_of
from .coordinates import log_prior
from .evidence import Comparison, Problem, Widened, log_density, model_errors
from .line_covariance import line_covariance
from .predict import UnpredictableError
from .refine import Fit, fit_at, refined
from .responses import Responses

#: Longest move of the machine's coordinates, and how often one that makes it worse is halved.
LONGEST_MOVE, HALVED = 1.0, 2
#: Relative deviation of a parameter below which it is not moved where each slope is a simulation: the law's tolerance
#: is wider.
KNOWN_WELL = 0.02
#: Change of the machine's own coordinates that is not worth another round.
SMALL_CHANGE = 0.03
#: Standard deviation of a coordinate that is taken as known.
KNOWN = 1e-6
#: Change of any coordinate after which the slopes of the machine's own are computed anew.
NEARBY = 0.3


def jointly(fit: Fit, problem: Problem, *, moves: int) -> Fit:
    """Return the fit with the machine's own unknowns linearised with the effects in place, and moved ``moves`` times.

    In turn: the effects' values at fixed unknowns, then the unknowns' most probable change (Gauss-Newton, with slopes
    from nearby). A move after which lines and priors together are less probable is halved: where a model is wrong, its
    slopes promise more than is there. Where each slope is a simulation in time, neither is moved: values are those that
    fit the machine as calibrated, and the unknowns widen their intervals. Of a machine that itself does not repeat, the
    fit is returned as it is.
    """
    baseline = problem.baseline
    in_time = not problem.predictor.repeats(fit.machine(baseline.machine))
    if in_time and (fit.problem is not None or not problem.predictor.repeats(baseline.machine)):
        return fit
    moving = _wide(baseline) if in_time else np.ones(baseline.position.size, dtype=bool)
    try:
        around = again(replace(baseline, active=moving), fit.machine(baseline.machine), problem.predictor)
    except UnpredictableError:
        return fit
    if in_time:
        compared = before_effects(problem.around(around, fit.response), fit.response)
        response = Responses(fit.candidates, baseline.machine, problem.predictor)
        return replace(fit_at(response, fit.position, fit.response, fit.slopes, compared), problem=problem)
    best, most, halved = fit, -math.inf, 0
    start, change = problem, np.zeros(baseline.position.size)
    seen = np.concatenate([baseline.position, fit.position])
    for count in range(moves + 1):
        here = np.concatenate([problem.baseline.position, fit.position])
        try:
            machine = fit.machine(problem.baseline.machine)
            if np.abs(here - seen).max() < NEARBY:
                moved = problem.baseline.position - around.position
                around = shifted(around, machine, moved, problem.predictor)
            else:
                around, seen = again(replace(problem.baseline, active=moving), machine, problem.predictor), here
        except UnpredictableError:
            break
        # What the effects add to the machine where it is now, not to that which they were fitted with.
        added = around.lines - problem.baseline.lines
        compared = problem.around(around, added)
        before = before_effects(compared, added)
        found = refined(fit.candidates, fit.position, before, problem.baseline.machine, problem.predictor)
        if found is None:
            break
        worth = density_at_values(found, problem) if moves else 0.0
        if worth < most:
            if halved == HALVED or count == moves:
                break
            halved, change, fit = halved + 1, change / 2, best
            problem = start.moved(change)
            continue
        fit = best = replace(found, problem=problem)
        most, start, halved = worth, problem, 0
        learnt = compared.learnt @ Widened(fit.law).solve(fit.residual)
        change = (compared.known + learnt)[: baseline.position.size]
        largest = float(np.abs(change).max(initial=0.0))
        if count == moves or largest < SMALL_CHANGE:
            break
        change = change * min(1.0, LONGEST_MOVE / largest)
        problem = problem.moved(change)
    return best


def density_at_values(fit: Fit, problem: Problem) -> float:
    """Return the logarithm of the density of all lines and priors at the values of effects and machine themselves.

    Nothing about the machine is integrated out but the gains of the probes and errors of its form, so that no slope in
    its own unknowns is trusted. Up to a constant.
    """
    own = len(problem.baseline.coordinates)
    fixed = replace(
        problem,
        baseline=without_unknowns(problem.baseline, own),
        at_healthy=None if problem.at_healthy is None else without_unknowns(problem.at_healthy, own),
    )
    compared = fixed.around(fixed.baseline, fit.response)
    residual = compared.residual - compared.whitened(fit.response)
    response = Responses(fit.candidates, problem.baseline.machine, problem.predictor)
    law = laws_of(compared, fit.candidates, response.own(fit.position, fit.response))
    outside = problem.baseline.prior_mean[:own] / problem.baseline.prior[:own]
    prior = log_prior(fit.coordinates, fit.position) - 0.5 * float(outside @ outside)
    return log_density(compared, residual, law) + prior + _density_of_healthy(fixed)


def _density_of_healthy(problem: Problem) -> float:
    healthy, there = problem.healthy, problem.at_healthy
    if healthy is None or there is None:
        return 0.0
    errors, *_ = model_errors(healthy, problem.lines, problem.error)
    covariance = line_covariance(healthy, errors, there.slopes, there.prior)
    return float(covariance.density(covariance.whole(healthy.amplitudes - there.lines)))


def without_unknowns(baseline: Baseline, own: int) -> Baseline:
    """Return the baseline with gains, errors of form, and what changes between recordings, as all that is open."""
    prior, mean = baseline.prior.copy(), baseline.prior_mean.copy()
    prior[:own], mean[:own] = KNOWN, 0.0
    return replace(baseline, prior=prior, prior_mean=mean)


def _wide(baseline: Baseline) -> np.ndarray:
    """Return which coordinates move their parameter by more than `KNOWN_WELL` within a standard deviation."""
    found = []
    for coordinate, z in zip(baseline.coordinates, baseline.position, strict=True):
        here, there = coordinate.value(float(z)), coordinate.value(float(z) + 1.0)
        found.append(coordinate.is_angle or abs(there - here) > KNOWN_WELL * abs(here))
    return np.array(found, dtype=bool)


def before_effects(compared: Comparison, response: np.ndarray) -> Comparison:
    """Return a comparison with the machine that carries the effects, their response put back to be fitted anew."""
    return replace(compared, residual=compared.residual + compared.whitened(response))
