"""How much closer the extended machine comes to conditions that were not fitted, against calibration and placebos."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...simulators.effect import Effect
from ...simulators.machine import Machine
from .empirical import AddedForce, as_effect, empirical_forces
from .evidence import Problem
from .judged import judged
from .model_error import similarity
from .posterior import Posterior
from .predict import UnpredictableError
from .refine import Fit
from .result import Gain
from .size_scale import at_most_once

if TYPE_CHECKING:
    from .prepared import Prepared

#: Accuracy of a line beside its noise: lines far above the noise do not count for more than this allows.
ACCURACY = 0.01
#: Of the larger one of a measured and a simulated size: these are right to a factor, whatever is right about the cause.
ACCURACY_OF_SIZES = 0.5


def useful_forces(prepared: Prepared, posterior: Posterior) -> tuple[tuple[AddedForce, ...], tuple[str, ...]]:
    """Return the forces to add for what is unknown, and remarks.

    None where they spoil the conditions that were not fitted.
    """
    forces, remarks = empirical_forces(prepared, posterior)
    if not forces or not prepared.held_out:
        return forces, remarks
    problem, best = prepared.problem(prepared.held_out), posterior.named
    without = residual_power(problem, explained(best, problem))
    spoilt = _db(without, residual_power(problem, explained(best, problem, further=[as_effect(f) for f in forces])))
    if spoilt >= 0:
        return forces, remarks
    text = (
        f"No force is added for what is left over: fitted to the other conditions, it would make the held-out error "
        f"{-spoilt:.1f} dB larger."
    )
    return (), (*remarks, text)


def measured_gain(
    machine: Machine, prepared: Prepared, posterior: Posterior, forces: Sequence[AddedForce] = ()
) -> Gain:
    """Return the gain on the held-out conditions, or on all where none could be held out.

    ``forces`` are those added for what is unknown, from `useful_forces`.
    """
    held_out = prepared.held_out or prepared.fitted
    problem = prepared.problem(held_out)
    plain, by_lines = problem.plain().expected, prepared.by_lines
    calibrated = problem.predictor.amplitudes(by_lines.calibrated) if by_lines else plain
    given = residual_power(problem, problem.predictor.amplitudes(machine))
    added = tuple(as_effect(one) for one in forces)
    # Of the machine that is written: where nothing is named and nothing added, that is the calibrated one.
    best = posterior.named
    extended = explained(best, problem, further=added)
    if by_lines and by_lines.calibrated == prepared.baseline.machine and not (best.candidates or added):
        extended = calibrated
    # What cannot be told apart from the name is no placebo.
    alike = {name for names in judged(posterior.probabilities)[2] for name in names} | set(best.names)
    others = [fit for fit in posterior.fits if not set(fit.names) & alike] if best.candidates or added else []
    # An empirical force has amplitude, phase and exponent.
    parameters = 3 * len(added) if added else best.position.size
    return Gain(
        held_out_db=_db(given, residual_power(problem, extended)),
        calibration_only_db=_db(given, residual_power(problem, calibrated)),
        wrong_effect_db=(_db(given, residual_power(problem, explained(others[0], problem))) if others else math.nan),
        smooth_function_db=_db(given, residual_power(problem, plain + _smooth(prepared, held_out, parameters))),
        held_out=prepared.held_out,
    )


def explained(fit: Fit, problem: Problem, *, further: Sequence[Effect] = ()) -> np.ndarray:
    """Return the lines that a fit, with further effects, expects in other conditions than it was fitted to."""
    if fit.problem is not None:
        change = fit.problem.baseline.position - problem.baseline.position
        problem = problem.moved(change) if change.any() else problem
    machine = problem.baseline.machine
    try:
        extended = fit.machine(machine).with_effects(*further)
        own = problem.predictor.amplitudes(extended) - problem.predictor.amplitudes(machine)
    except UnpredictableError:
        own = np.zeros(problem.lines.seen.shape, dtype=complex)
    return problem.plain().expected + own


def predicted_db(fits: Sequence[Fit], prepared: Prepared) -> list[float]:
    """Return by how many dB each fit's held-out error lies below that of the machine without any effect."""
    problem = prepared.problem(prepared.held_out)
    without = residual_power(problem, problem.plain().expected)
    return [_db(without, residual_power(problem, explained(fit, problem))) for fit in fits]


def smooth_db(parameters: int, prepared: Prepared) -> float:
    """Return the same for a smooth function of speed with so many parameters: a placebo."""
    problem = prepared.problem(prepared.held_out)
    plain = problem.plain().expected
    smooth = plain + _smooth(prepared, prepared.held_out, parameters)
    return _db(residual_power(problem, plain), residual_power(problem, smooth))


def residual_power(problem: Problem, simulated: np.ndarray) -> float:
    """Return the mean squared distance from the measured lines, in their noise and accuracy."""
    lines = problem.lines
    seen = lines.seen
    phase = np.array([kind.phase for kind in lines.kinds])
    larger = np.where(phase, np.abs(lines.amplitudes), np.maximum(np.abs(lines.amplitudes), np.abs(simulated)))
    larger = at_most_once(larger, lines.knees)
    scale = lines.deviations[seen] ** 2 + (np.where(phase, ACCURACY, ACCURACY_OF_SIZES) * larger)[seen] ** 2
    return float((np.abs(lines.amplitudes - simulated)[seen] ** 2 / scale).mean())


def _smooth(prepared: Prepared, held_out: Sequence[int], parameters: int) -> np.ndarray:
    """Return the held-out lines as a smooth function of speed predicts them from the fitted ones.

    ``parameters`` (probe, order) lines are followed, those that are furthest off.
    """
    problem = prepared.problem(prepared.fitted)
    compared = problem.plain()
    left = np.where(problem.lines.seen, problem.lines.amplitudes - compared.expected, 0.0)
    scale = np.where(problem.lines.seen, problem.lines.deviations, np.inf)
    size = (np.abs(left / scale) ** 2).sum(axis=0)
    chosen = np.argsort(size, axis=None)[::-1][: max(parameters, 1)]
    both = similarity(tuple(prepared.measured.conditions))
    cross = both[np.ix_(list(held_out), list(prepared.fitted))]
    inner = both[np.ix_(list(prepared.fitted), list(prepared.fitted))] + 1e-6 * np.eye(len(prepared.fitted))
    result = np.zeros((len(held_out), *size.shape), dtype=complex)
    for flat in chosen:
        probe, order = np.unravel_index(int(flat), size.shape)
        result[:, probe, order] = cross @ np.linalg.solve(inner, left[:, probe, order])
    return result


def _db(before: float, after: float) -> float:
    return 10 * math.log10(max(before, 1e-300) / max(after, 1e-300))
