"""Effects whose lines pass a resonance that the healthy lines leave open: the machine is looked for as well.

A crack's 2X may pass a critical speed that no healthy recording came near. With little damping the resonance is then
narrower than what is known of its place, and no slope of the calibrated machine tells the effect's lines there.
Machines drawn from what the healthy lines leave open say where that is so. By how much their lines differ from what the
slopes promise widens what is expected, so that the other lines tell the effect's values; of many machines with these,
the one that is nearest to the measured lines is where both are fitted on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline, again, machine_at
from .climb import laws_of
from .evidence import Problem
from .healthy_evidence import fitted
from .joint_fit import before_effects, jointly, without_unknowns
from .lines import OrderLines, stacked
from .null_distribution import chance_of_residual
from .predict import UnpredictableError
from .refine import Fit, refined
from .responses import Responses
from .screening import TIMES_WORSE

#: Machines that are drawn to see whether slopes tell the effect's lines, and to find the nearest one.
DRAWS, PLACES = 12, 64
SEED = 1
#: Median share of an effect's response by which it differs between these machines, where slopes do not tell it.
OPEN = 0.3
#: Fits that are looked at, and of which a machine is sought, the likeliest first.
LOOKED_AT, SOUGHT = 4, 2
#: Share of the machines that have to run.
LEAST_RUNNING = 0.5
#: How often the machine is moved on from the nearest one.
MOVES = 4

Tell = Callable[[str], None]


def at_open_resonances(
    fits: Sequence[Fit], problem: Problem, unknown: float, *, misfit: float, tell: Tell = lambda _: None
) -> list[Fit]:
    """Return the fits, of those with most evidence the machine sought as well where a resonance is open.

    They stay as they are where the best leaves noise (with a chance above ``misfit``) and has more evidence than
    something ``unknown``, where there are no healthy lines, where their lines pass no such resonance, or where that
    explains no more.
    """
    ranked = sorted(fits, key=lambda fit: -fit.log_evidence)
    if problem.healthy is None or problem.at_healthy is None or not ranked:
        return ranked
    if ranked[0].log_evidence >= unknown and chance_of_residual(ranked[0]) > misfit:
        return ranked
    try:
        moves = _open_moves(problem.at_healthy, problem.healthy)
    except np.linalg.LinAlgError:
        # Rounding, where some unknowns are known to parts in a million beside others that are open.
        return ranked
    wider = {}
    for fit in ranked[:LOOKED_AT]:
        tell(f"resonances that {fit.candidates[0]} may pass")
        found = _wider(fit, problem, moves[:DRAWS])
        if found is not None:
            wider[fit] = found
    least = min((one.power for one in wider.values()), default=0.0)
    near = [fit for fit, one in wider.items() if one.power <= TIMES_WORSE * least]
    for fit in sorted(near, key=lambda one: -wider[one].log_evidence)[:SOUGHT]:
        tell(f"the machine beside {fit.candidates[0]}")
        wider[fit] = max(wider[fit], _sought(wider[fit], problem, moves), key=lambda one: one.log_evidence)
    better = {fit: replace(one, redrawn=True) for fit, one in wider.items() if one.log_evidence > fit.log_evidence}
    return sorted([better.get(fit, fit) for fit in ranked], key=lambda fit: -fit.log_evidence)


def _wider(fit: Fit, problem: Problem, moves: np.ndarray) -> Fit | None:
    """Return the fit with what is expected widened; None where slopes tell the effect's lines, or nothing runs."""
    if not problem.predictor.repeats(fit.machine(problem.baseline.machine)):
        return None
    try:
        moves = _that_run((fit, None), problem, moves)
        return _fitted_wider(fit, problem, moves) if _is_open(fit, problem, moves) else None
    except UnpredictableError:
        return None


def _sought(fit: Fit, problem: Problem, moves: np.ndarray) -> Fit:
    """Return the fit about the nearest of the moved machines, which moves on from there."""
    try:
        fit = _fitted_wider(fit, problem, _that_run((fit,), problem, moves[:DRAWS])) or fit
        nearest = problem.moved(_nearest(fit, problem, _that_run((fit,), problem, moves)))
        return jointly(replace(fit, problem=None), nearest, moves=MOVES)
    except UnpredictableError:
        return fit


def _open_moves(at_healthy: Baseline, healthy: OrderLines) -> np.ndarray:
    """Return moves (moves, coordinates) of the machine, drawn from what the healthy lines leave open."""
    own = len(at_healthy.coordinates)
    change, covariance = fitted(at_healthy, healthy)
    lower = np.linalg.cholesky(covariance[:own, :own])
    return np.random.default_rng(SEED).standard_normal((PLACES, own)) @ lower.T + change[:own]


def _that_run(fits: Sequence[Fit | None], problem: Problem, moves: np.ndarray) -> np.ndarray:
    """Return the moves to machines that run with each fit's effects, or without: some of those drawn may be unstable.

    Raises
    ------
    UnpredictableError
        Where hardly any does.
    """
    each = [_moved(fit, problem.baseline, problem, moves) for fit in fits]
    problem.predictor.prepare([machine for machines in each for machine in machines])
    runs = np.array([all(_runs(machine, problem) for machine in same) for same in zip(*each, strict=True)])
    if runs.mean() < LEAST_RUNNING:
        raise UnpredictableError(f"Of {runs.size} machines {runs.sum()} run.")
    return moves[runs]


def _runs(machine: Machine, problem: Problem) -> bool:
    try:
        problem.predictor.amplitudes(machine)
    except UnpredictableError:
        return False
    return True


def _lines_of(fit: Fit | None, baseline: Baseline, problem: Problem, moves: np.ndarray) -> np.ndarray:
    """Return the lines of moved machines with the effects, or without, shape (moves, conditions, probes, orders)."""
    machines = _moved(fit, baseline, problem, moves)
    problem.predictor.prepare(machines)
    return np.stack([problem.predictor.amplitudes(one) for one in machines])


def _moved(fit: Fit | None, baseline: Baseline, problem: Problem, moves: np.ndarray) -> list[Machine]:
    moved = [machine_at(problem.baseline.machine, baseline.coordinates, baseline.position + move) for move in moves]
    return [fit.machine(one) if fit else one for one in moved]


def _is_open(fit: Fit, problem: Problem, moves: np.ndarray) -> bool:
    compared, baseline = problem.plain(), problem.baseline
    added = _lines_of(fit, baseline, problem, moves) - _lines_of(None, baseline, problem, moves)
    differs = np.linalg.norm(compared.whitened(added - fit.response), axis=1)
    return bool(np.median(differs) > OPEN * np.linalg.norm(compared.whitened(fit.response)))


def _around(fit: Fit, problem: Problem) -> Baseline:
    """Return the machine with the effects, linearised in all its coordinates."""
    free = replace(problem.baseline, active=np.ones(problem.baseline.position.size, dtype=bool))
    return again(free, fit.machine(problem.baseline.machine), problem.predictor)


def _fitted_wider(fit: Fit, problem: Problem, moves: np.ndarray) -> Fit | None:
    """Return the effects fitted anew; by how much slopes mislead, as the moves show, is uncertain as well."""
    around = _around(fit, problem)
    straight = around.lines + np.tensordot(moves, around.slopes[: moves.shape[1]], 1)
    bends = _lines_of(fit, around, problem, moves) - straight
    flat = np.stack([stacked(one, problem.lines.parts) for one in bends])
    added = around.lines - problem.baseline.lines
    compared = problem.around(around, added).widened(flat.T @ flat / len(moves))
    start = before_effects(compared, added)
    found = refined(fit.candidates, fit.position, start, problem.baseline.machine, problem.predictor)
    return found and replace(found, problem=problem)


def _nearest(fit: Fit, problem: Problem, moves: np.ndarray) -> np.ndarray:
    """Return the move to the machine whose lines, with the effects, are nearest to the measured ones.

    In their noise, the model's errors and the effects' tolerance: the moves themselves are as likely as each other.
    """
    around, own = _around(fit, problem), len(problem.baseline.coordinates)
    alone = replace(problem, baseline=without_unknowns(problem.baseline, own), healthy=None, at_healthy=None)
    added = around.lines - problem.baseline.lines
    compared = alone.around(without_unknowns(around, own), added)
    response = Responses(fit.candidates, problem.baseline.machine, problem.predictor)
    law = laws_of(compared, fit.candidates, response.own(fit.position, added))
    away = compared.residual - compared.whitened(_lines_of(fit, around, problem, moves) - around.lines)
    return moves[int(np.argmin([float(one @ law.solve(one)) for one in away]))]
