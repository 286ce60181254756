"""The machine's own unknowns where its healthy recordings put them, and what the model still misses there.

Levenberg-Marquardt on minus the logarithm of the posterior of the machine's coordinates, the probes' gains integrated
out. Where the motion repeats with the shaft the slopes are computed anew at every step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline, again, shifted, start
from .boxed_step import boxed_step
from .constant_error import with_constant_parts
from .coordinates import Coordinate
from .error_smoothness import length_of
from .healthy_evidence import fitted
from .line_covariance import LineCovariance, line_covariance
from .lines import OrderLines
from .model_error import REFERENCE_RPM, ModelError, error_blocks, model_error
from .out_of_reach import out_of_reach
from .predict import Predictor, UnpredictableError
from .size_scale import at_most_once

#: Steps, fewer where each is a simulation, and tries to find one that gains.
MOST_STEPS, MOST_STEPS_IN_TIME, MOST_TRIES = 20, 6, 10
#: Longest step in any coordinate, standard deviations of the prior.
LONGEST = 1.0
#: Damping at the start and at least, and its factor after a try that gained nothing.
DAMPING, LEAST_DAMPING, HARDER = 1e-2, 1e-5, 6.0
#: Shares of the gain promised by the slopes, above which the next step is damped less, and below which more.
AS_PROMISED, SHORT_OF_PROMISED = 0.75, 0.25
#: A step that gains what its slopes promised, to this share, bears them out.
BORNE_OUT = 0.25
#: A step that gains less is the last one.
LEAST_GAIN = 0.1
#: As long as the machine misses its lines, these are doubted by as much, and each step by this factor less: slopes of a
#: machine that is far off would put what is hardly told anywhere, on hills from which no step leads on.
SURER = 2.0
#: Powers of the speed by which the model error may grow; one where speeds differ by less than this factor.
GROWTHS, FEW_SPEEDS = (0, 1, 2, 3, 4), 1.2
#: Sizes of lines without phase are measured to this share at best.
SIZES_TO = 0.1
#: And count where they are this many times their deviation.
SEEN = 5.0
#: Logarithm of a likelihood, one standard deviation from the best.
ONE_DEVIATION = 0.5
#: Records for which what all sizes are off by counts beside a line's own.
RECORDS_OF_ALL = 3.0
#: Share of a model error's variance that no other record has in common, where the machine does not repeat itself: of a
#: gearbox, sizes that are simulated a few tenths of a per cent faster scatter by 0.1 to 0.6 of it, those of the mesh
#: alone by less.
OWN_SHARE = 0.1
#: Model errors that are tried, as shares of the largest miss.
SHARES = np.concatenate([[0.0], np.geomspace(1e-3, 3.0, 60)])


def calibrated(
    machine: Machine,
    healthy: OrderLines,
    predictor: Predictor,
    added: Sequence[Coordinate] = (),
    *,
    begin: np.ndarray | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> Baseline:
    """Return the machine with its parameters where the healthy lines put them, linearised there.

    Only the healthy conditions are used; ``predictor`` is for those. ``added`` are coordinates of effects that the
    machine is given with, or of its own parameters without a prior; ``begin`` is the position to begin at, else the
    machine as given.
    """
    return settled(start(machine, predictor, added, begin=begin, tell=tell), machine, healthy, predictor, tell=tell)


def settled(
    current: Baseline,
    machine: Machine,
    healthy: OrderLines,
    predictor: Predictor,
    *,
    most_steps: int = MOST_STEPS,
    tell: Callable[[str], None] = lambda _: None,
) -> Baseline:
    """Return a linearised machine with its parameters where the healthy lines put them; see `calibrated`."""
    repeats = predictor.repeats(machine)
    error = np.maximum(model_error(current.lines), out_of_reach(current, healthy))
    # Where each slope is a simulation there are too few steps for that.
    damping, doubt = DAMPING, math.inf if repeats else 1.0
    are_fresh = True
    for count in range(most_steps if repeats else MOST_STEPS_IN_TIME):
        tell(f"calibration, step {count + 1}")
        wide = np.maximum(error, size_error(current, healthy))
        covariance = covariance_about(current, healthy, wide)
        doubt = max(min(misfit(current, healthy, covariance), doubt / SURER), 1.0)
        doubted = covariance.times(doubt)
        step, damping = _step(current, machine, healthy, predictor, doubted, damping)
        is_last = doubt == 1.0 and (step is None or step.gained < LEAST_GAIN)
        if step is None:
            # Lines that are less doubted may lead on.
            damping = DAMPING
        elif repeats and abs(step.kept - 1) < BORNE_OUT:
            current, are_fresh = corrected(current, step.reached), False
        else:
            # Each slope of a machine that does not repeat is a simulation: the first ones have to do.
            current = relinearised(step.reached, machine, predictor) if repeats else step.reached
            are_fresh = True
        if is_last and are_fresh:
            break
        if not are_fresh and (is_last or step is None):
            current, are_fresh = relinearised(current, machine, predictor), True
    return current if are_fresh else relinearised(current, machine, predictor)


def corrected(before: Baseline, after: Baseline) -> Baseline:
    """Return the machine after a step with slopes that lead there from before it: corrected along the step.

    C. G. Broyden, Mathematics of Computation 19 (1965) 577: one motion instead of one for each slope.
    """
    move, own = after.position - before.position, after.position.size
    missing = after.lines - before.lines - np.tensordot(move, before.slopes[:own], 1)
    slopes = after.slopes.copy()
    slopes[:own] += np.multiply.outer(move / (move @ move), missing)
    return replace(after, slopes=slopes)


def misfit(current: Baseline, lines: OrderLines, covariance: LineCovariance) -> float:
    """Return the mean square of what a machine misses of lines, in standard deviations."""
    white = covariance.whole(lines.amplitudes - current.lines)
    return float(white @ white) / max(white.size, 1)


def relinearised(current: Baseline, machine: Machine, predictor: Predictor) -> Baseline:
    """Return the machine with the slopes of where it is; with those that it has, where it is unstable next to it."""
    try:
        return again(current, machine, predictor)
    except UnpredictableError:
        return current


def settled_further(
    current: Baseline,
    healthy: OrderLines,
    predictor: Predictor,
    *,
    tell: Callable[[str], None] = lambda _: None,
) -> Baseline:
    """Return a calibrated machine with its parameters where the error that it leaves lets the healthy lines put them.

    Calibration takes all sizes for equally far off; what is explained then, each line for its own. The way between is
    simulated here: of a machine that does not repeat itself, slopes do not tell. Others are returned as they are.
    """
    machine = current.machine
    if predictor.repeats(machine):
        return current
    error, damping = residual_error(current, healthy), DAMPING
    for count in range(MOST_STEPS_IN_TIME):
        tell(f"calibration, last step {count + 1}")
        covariance = covariance_about(current, healthy, error)
        step, damping = _step(current, machine, healthy, predictor, covariance, damping)
        if step is None:
            break
        current = step.reached
        if step.gained < LEAST_GAIN:
            break
    return current


def size_error(current: Baseline, healthy: OrderLines) -> np.ndarray:
    """Return by how much sizes of lines without phase are off, (conditions, probes, orders): about as all of them are.

    A share of the larger one of a measured and a simulated size: sizes are predicted to a factor, and one that is three
    times too small is no nearer than one that is three times too large.
    """
    phase = np.array([kind.phase for kind in healthy.kinds])
    own = healthy.seen & ~phase
    larger = np.where(own, np.maximum(np.abs(healthy.amplitudes), np.abs(current.lines)), 0.0)
    larger = np.where(own, at_most_once(larger, healthy.knees), 0.0)
    told = own & (larger > SEEN * np.where(own, healthy.deviations, np.inf))
    if not told.any():
        return larger
    off = (np.abs(healthy.amplitudes - current.lines) - healthy.deviations)[told] / larger[told]
    return max(float(np.sqrt(np.mean(np.maximum(off, 0.0) ** 2))), SIZES_TO) * larger


@dataclass(frozen=True, eq=False)
class _Step:
    """Where a step leads, by how much the objective falls, and the share of what the slopes promised."""

    reached: Baseline
    gained: float
    kept: float


def _step(
    current: Baseline,
    machine: Machine,
    healthy: OrderLines,
    predictor: Predictor,
    covariance: LineCovariance,
    damping: float,
) -> tuple[_Step | None, float]:
    """Return the first step that gains anything, None where none does, and the damping for the next one."""
    # The gains of the probes, part of the covariance, are a share of what the machine makes, and stay so during the
    # step: were they to follow each trial, one that makes more would seem better, as it may be wrong by more; were they
    # a share of what was measured, one that makes less would (R. D. Ball et al., J. High Energy Physics 05 (2010) 075).
    here = _objective(current, healthy, covariance)
    gradient, curvature = _slope(current, healthy, covariance)
    active = np.flatnonzero(current.active)
    inner = curvature[np.ix_(active, active)]
    for _ in range(MOST_TRIES if active.size else 0):
        move = np.zeros(current.position.size)
        move[active] = boxed_step(inner + damping * np.diag(np.diag(inner)), gradient[active], LONGEST)
        try:
            trial = shifted(current, machine, move, predictor)
            gained = here - _objective(trial, healthy, covariance)
        except UnpredictableError:
            # Slopes of a machine that is stable promise much of one that is not.
            trial, gained = current, 0.0
        if gained > 0:
            promised = float(gradient @ move - 0.5 * move @ curvature @ move)
            kept = gained / promised
            return _Step(trial, gained, kept), _damping_after(kept, damping)
        damping *= HARDER
    return None, damping


def _damping_after(kept: float, damping: float) -> float:
    """Return the damping of the next step, after one that gained a share ``kept`` of what its slopes promised."""
    if kept < SHORT_OF_PROMISED:
        return damping * HARDER
    return max(damping / HARDER, LEAST_DAMPING) if kept > AS_PROMISED else damping


def _slope(current: Baseline, lines: OrderLines, covariance: LineCovariance) -> tuple[np.ndarray, np.ndarray]:
    """Return minus the gradient of the objective in the machine's coordinates, and its curvature."""
    own = current.position.size
    slopes = covariance.whole(current.slopes[:own])
    precision = current.prior[:own] ** -2
    left = covariance.whole(lines.amplitudes - current.lines)
    return slopes @ left + precision * current.prior_mean[:own], slopes @ slopes.T + np.diag(precision)


def objective(current: Baseline, lines: OrderLines, error: np.ndarray) -> float:
    """Return minus the logarithm of the posterior at the best gains, up to a constant."""
    return _objective(current, lines, covariance_about(current, lines, error))


def _objective(current: Baseline, lines: OrderLines, covariance: LineCovariance) -> float:
    left = covariance.whole(lines.amplitudes - current.lines)
    own = len(current.coordinates)
    outside = current.prior_mean[:own] / current.prior[:own]
    return 0.5 * float(left @ left) + 0.5 * float(outside @ outside)


def covariance_about(current: Baseline, lines: OrderLines, error: np.ndarray | ModelError) -> LineCovariance:
    """Return the covariance of the lines about the machine's: noise, model error and the probes' gains."""
    own = len(current.coordinates)
    return line_covariance(lines, error_blocks(lines.conditions, error), current.slopes[own:], current.prior[own:])


def residual_error(current: Baseline, healthy: OrderLines) -> ModelError:
    """Return the model error that the calibrated machine leaves on healthy lines.

    The largest whose likelihood is within one standard deviation of the best: where the healthy lines are too noisy to
    show what the model lacks, the best one is 0, and a quieter record of the same line would then be something new.

    What a model lacks grows with speed as the vibration does. By which power tells no line by itself; all lines of one
    kind at a probe do together.
    """
    speeds = np.array([one.speed_rpm for one in healthy.conditions]) / REFERENCE_RPM
    with_phase = np.array([kind.phase for kind in healthy.kinds])
    left, power, noise = _left(current, healthy)
    shape, parts = power.shape[1:], healthy.part_counts
    chosen, growth, least = np.zeros(shape), np.zeros(shape), np.full((shape[0], 2), np.inf)
    likeliest: dict[int, np.ndarray] = {}
    for exponent in GROWTHS if speeds.max() > FEW_SPEEDS * speeds.min() else GROWTHS[:1]:
        scale = speeds[:, None, None] ** (2 * exponent)
        # Of lines divided by the growth: their noise is divided as well.
        variance, cost = _likeliest(power / scale, noise / scale, parts, within=ONE_DEVIATION)
        likeliest[exponent] = variance
        cost = cost + parts / 2 * np.where(np.isfinite(noise), np.log(scale), 0.0).sum(axis=0)
        for kind in (0, 1):
            own = with_phase == bool(kind)
            total = cost[:, own].sum(axis=1)
            better = (total < least[:, kind])[:, None] & own
            least[:, kind] = np.minimum(least[:, kind], total)
            chosen, growth = np.where(better, variance, chosen), np.where(better, exponent, growth)
    usual = np.maximum(model_error(current.lines) ** 2, _as_others(current, healthy, power, noise))
    mean_speed, own_share = np.exp(np.log(speeds).mean()), OWN_SHARE if healthy.spectrum_on_scale else 0.0

    def grown(variance: np.ndarray, power: np.ndarray) -> ModelError:
        return ModelError(np.sqrt(np.maximum(variance, usual / mean_speed ** (2 * power))), power, own_share=own_share)

    each = [grown(variance, np.full(shape, float(one))) for one, variance in likeliest.items()]
    seen = healthy.conditions, left, noise
    found = with_constant_parts(grown(chosen, growth), each, *seen, parts)
    return replace(found, length=length_of(*seen, found, parts))


def _as_others(current: Baseline, healthy: OrderLines, power: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return the least variance of each size on the scale, (probes, orders): what those of all lines have in common.

    A few healthy records tell no line's own: two that happen to fit would make the next one that does not something
    new. Each line counts as `RECORDS_OF_ALL` further records that are off as all lines are; less where it is hardly
    there.
    """
    if healthy.knees is None:
        return np.zeros(power.shape[1:])
    knees, seen = healthy.knees, np.isfinite(noise)
    larger = np.where(seen, np.maximum(np.abs(healthy.amplitudes), np.abs(current.lines)), 0.0) / knees
    there = np.minimum(larger.max(axis=0), 1.0)
    told = seen & (there >= 1)
    if not told.any():
        return np.zeros(power.shape[1:])
    own = np.where(told, power - np.where(seen, noise, 0.0), 0.0) / knees**2
    of_all = max(float(own.sum() / told.sum()), 0.0)
    count = seen.sum(axis=0)
    pooled = (np.maximum(own.sum(axis=0), 0.0) + RECORDS_OF_ALL * of_all) / (count + RECORDS_OF_ALL)
    return np.where(np.isfinite(knees), pooled * (there * np.where(np.isfinite(knees), knees, 0.0)) ** 2, 0.0)


def left_variance(current: Baseline, healthy: OrderLines) -> np.ndarray:
    """Return the variance of what the calibrated machine leaves of healthy lines beyond their noise.

    That of the real or the imaginary part, shape (probes, orders), by maximum likelihood: each condition counts with
    its own noise, so that quiet ones tell although others are loud. The most probable unknowns and gains are used.
    """
    _, power, noise = _left(current, healthy)
    return _likeliest(power, noise, healthy.part_counts)[0]


def _left(current: Baseline, healthy: OrderLines) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what is left of each line, its power in one part of it, and the variance of the noise of one part.

    The power has in it what the unknowns still have: many of them fit few lines whatever is wrong, and what is left is
    then small although the model is not right. The last is infinite where a line is not seen.
    """
    change, covariance = fitted(current, healthy)
    left = healthy.amplitudes - current.lines - np.tensordot(change, current.slopes, 1)
    open_still = np.einsum("i...,i...->...", np.tensordot(covariance, current.slopes, 1), current.slopes.conj()).real
    power, seen = (np.abs(left) ** 2 + open_still) / healthy.part_counts, healthy.seen
    return np.where(seen, left, 0.0), np.where(seen, power, 0.0), np.where(seen, healthy.deviations, np.inf) ** 2


def _likeliest(
    power: np.ndarray, noise: np.ndarray, parts: np.ndarray, *, within: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest variance beyond the noise that costs as little as ``within`` more than the best, and its cost.

    Both (probes, orders); the cost is the logarithm of the likelihood, negative. Power and noise are those of one part
    of a line, of which there are ``parts`` (orders,).
    """
    seen = np.isfinite(noise)
    known = np.where(seen, noise, 1.0)
    # As far as noise hides it, where the best is not the only one that counts.
    largest = np.where(seen, power + known if within else power, 0.0).max(axis=0)
    tried = SHARES[:, None, None] ** 2 * largest
    whole = tried[:, None] + known
    cost = parts / 2 * np.where(seen, np.log(whole) + power / whole, 0.0).sum(axis=1)
    return np.where(cost <= cost.min(axis=0) + within, tried, 0.0).max(axis=0), cost.min(axis=0)
