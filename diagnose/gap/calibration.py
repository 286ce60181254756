"""The machine's own unknowns where its healthy recordings put them, and what the model still misses there.

Levenberg-Marquardt on minus the logarithm of the posterior of the machine's coordinates, the probes' gains integrated
out. Where the motion repeats with the shaft the slopes are computed anew at every step.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline, again, error_covariance, model_error, noise_covariance, shifted, start
from .lines import OrderLines, stacked
from .predict import Predictor

#: Steps, fewer where each is a simulation, and tries to find one that gains.
MOST_STEPS, MOST_STEPS_IN_TIME, MOST_TRIES = 15, 6, 6
#: Longest step in any coordinate, standard deviations of the prior.
LONGEST = 1.0
#: Damping at the start, and its factor after a try that gained nothing.
DAMPING, HARDER = 1e-2, 6.0
#: A step that gains less is the last one.
LEAST_GAIN = 0.1
#: Model errors that are tried, as shares of the largest miss.
SHARES = np.concatenate([[0.0], np.geomspace(1e-3, 3.0, 60)])


def calibrated(
    machine: Machine, healthy: OrderLines, predictor: Predictor, *, tell: Callable[[str], None] = lambda _: None
) -> Baseline:
    """Return the machine with its parameters where the healthy lines put them, linearised there.

    Only the healthy conditions are used; ``predictor`` is for those.
    """
    current = start(machine, predictor, tell=tell)
    repeats = predictor.repeats(machine)
    error = model_error(current.lines)
    best, damping = objective(current, healthy, error), DAMPING
    for count in range(MOST_STEPS if repeats else MOST_STEPS_IN_TIME):
        tell(f"calibration, step {count + 1}")
        trial, damping = _step(current, machine, healthy, predictor, error, damping)
        if trial is None:
            break
        # Each slope of a machine that does not repeat is a simulation: the first ones have to do.
        current = again(trial, machine, predictor) if repeats else trial
        before, best = best, objective(current, healthy, error)
        if before - best < LEAST_GAIN:
            break
    return current


def _step(
    current: Baseline,
    machine: Machine,
    healthy: OrderLines,
    predictor: Predictor,
    error: np.ndarray,
    damping: float,
) -> tuple[Baseline | None, float]:
    """Return the first step that gains anything, and the damping for the next one; None where none gains."""
    here = objective(current, healthy, error)
    gradient, curvature = _slope(current, healthy, error)
    active = np.flatnonzero(current.active)
    inner = curvature[np.ix_(active, active)]
    for _ in range(MOST_TRIES if active.size else 0):
        move = np.zeros(current.position.size)
        move[active] = np.linalg.solve(inner + damping * np.diag(np.diag(inner)), gradient[active])
        # Scaled as a whole: a step cut coordinate by coordinate points elsewhere, perhaps uphill.
        move *= min(1.0, LONGEST / max(float(np.abs(move).max()), 1e-300))
        trial = shifted(current, machine, move, predictor)
        if objective(trial, healthy, error) < here:
            return trial, damping / HARDER
        damping *= HARDER
    return None, damping


def _slope(current: Baseline, lines: OrderLines, error: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return minus the gradient of the objective in the machine's coordinates, and its curvature."""
    own = current.position.size
    slopes = stacked(current.slopes[:own], lines.parts)
    weighted = np.linalg.solve(_covariance(current, lines, error), slopes.T)
    precision = current.prior[:own] ** -2
    left = stacked(lines.amplitudes - current.lines, lines.parts)
    return weighted.T @ left + precision * current.prior_mean[:own], slopes @ weighted + np.diag(precision)


def objective(current: Baseline, lines: OrderLines, error: np.ndarray) -> float:
    """Return minus the logarithm of the posterior at the best gains, up to a constant."""
    left = stacked(lines.amplitudes - current.lines, lines.parts)
    own = len(current.coordinates)
    outside = current.prior_mean[:own] / current.prior[:own]
    return 0.5 * float(left @ np.linalg.solve(_covariance(current, lines, error), left)) + 0.5 * float(
        outside @ outside
    )


def _covariance(current: Baseline, lines: OrderLines, error: np.ndarray) -> np.ndarray:
    """Return the covariance of the stacked lines about the machine's: noise, model error and the probes' gains."""
    own = len(current.coordinates)
    gains = stacked(current.slopes[own:], lines.parts)
    covariance = noise_covariance(lines) + error_covariance(lines.conditions, error, lines.parts)
    return covariance + (gains.T * current.prior[own:] ** 2) @ gains


def residual_error(current: Baseline, healthy: OrderLines) -> np.ndarray:
    """Return the model error, shape (probes, orders), that the calibrated machine leaves on healthy lines."""
    return np.sqrt(np.maximum(left_variance(current, healthy), model_error(current.lines) ** 2))


def left_variance(current: Baseline, healthy: OrderLines) -> np.ndarray:
    """Return the variance of what the calibrated machine leaves of healthy lines beyond their noise.

    That of the real or the imaginary part, shape (probes, orders), by maximum likelihood: each condition counts with
    its own noise, so that quiet ones tell although others are loud. The most probable unknowns and gains are used.
    """
    error = model_error(current.lines)
    parts = healthy.parts
    slopes = stacked(current.slopes, parts)
    covariance = noise_covariance(healthy) + error_covariance(healthy.conditions, error, parts)
    weighted = np.linalg.solve(covariance, slopes.T)
    precision = current.prior**-2
    right = weighted.T @ stacked(healthy.amplitudes - current.lines, parts) + precision * current.prior_mean
    change = np.linalg.solve(slopes @ weighted + np.diag(precision), right)
    left = healthy.amplitudes - current.lines - np.tensordot(change, current.slopes, 1)
    seen = healthy.seen
    power = np.where(seen, np.abs(left) ** 2 / 2, 0.0)
    tried = SHARES[:, None, None] ** 2 * power.max(axis=0)
    noise = np.where(seen, healthy.deviations, 1.0) ** 2
    whole = tried[:, None] + noise
    cost = np.where(seen, np.log(whole) + power / whole, 0.0).sum(axis=1)
    return np.take_along_axis(tried, np.argmin(cost, axis=0)[None], axis=0)[0]
