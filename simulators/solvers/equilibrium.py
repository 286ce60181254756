"""Where a machine comes to rest under its mean forces: the start of a simulation, close to its steady motion."""

from __future__ import annotations

import numpy as np

from ..law import Timeline
from ..speed_profile import SpeedProfile
from ..system import System
from .block_form import BlockForm
from .plan import ForcePlan

#: Angles of the first revolution over which the signals are averaged.
ANGLES = 64
MOST_STEPS = 60
#: First step of the search in seconds; every further one is so many times longer, until each is one of Newton's method.
FIRST_STEP_S, GROWTH, LONGEST_STEP_S = 1e-5, 4.0, 1e6


def static_equilibrium(system: System, plan: ForcePlan, start_s: float, form: BlockForm) -> np.ndarray:
    """Return states (states, lanes) of ``form`` with L y + B u(mean signals, C y) = 0, or zero where none is found.

    Implicit Euler steps of growing length with the interface forces' finite-difference slope: the machine settles
    heavily damped. Newton's method alone fails where play leaves a shaft free until a contact closes.
    """
    states = np.zeros((form.core.shape[0], plan.lanes))
    known: dict[tuple[SpeedProfile, bytes], np.ndarray] = {}
    for lane, profile in enumerate(plan.profiles):
        key = (profile, plan.parameters[:, lane].tobytes())
        if key not in known:
            known[key] = _settle(system, plan, lane, _mean_signals(plan, lane, start_s), form)
        states[:, lane] = known[key]
    return states


def interface_forces(plan: ForcePlan, lane: int, signals: list[np.ndarray], x: np.ndarray, forces: int) -> np.ndarray:
    """Return u (forces, instants) of one lane for motions x (motions, instants) and signals of each force.

    ``signals`` holds one array (signals, instants) for each force. The instants take the place of the lanes, so that
    one call to each law does.
    """
    u = np.zeros((forces, x.shape[1]))
    x = np.ascontiguousarray(x)
    for k, force in enumerate(plan.forces):
        reads = plan.inputs[plan.rows[k, 1] : plan.rows[k, 2]]
        acts = plan.outputs[plan.rows[k, 3] : plan.rows[k, 4]]
        own = signals[k]
        if force.law.is_linear:
            count = acts.size
            slope = own[count:].reshape(count, reads.size, own.shape[1])
            np.add.at(u, acts, own[:count] + np.einsum("ijt,jt->it", slope, x[reads]))
        else:
            parameters = np.repeat(plan.own_parameters(k)[:, [lane]], x.shape[1], axis=1)
            force.law.force(np.ascontiguousarray(own), parameters, x, reads, acts, u)
    return u


def lane_signals(plan: ForcePlan, lane: int, timeline: Timeline) -> list[np.ndarray]:
    """Return the signals (signals, instants) of each force of one lane, on the branch of each instant."""
    found = []
    for k, force in enumerate(plan.forces):
        parameters = plan.own_parameters(k)[:, [lane]]
        extra = {"branch_rad": timeline.phase_rad} if force.law.jumps is not None else {}
        found.append(force.law.signals(timeline, parameters, **extra)[:, :, 0])
    return found


def _mean_signals(plan: ForcePlan, lane: int, start_s: float) -> list[np.ndarray]:
    speed = float(plan.profiles[lane].speed_rad_s(np.array([start_s]))[0])
    turn = 2 * np.pi / max(abs(speed), 1e-3)
    timeline = plan.lane_timeline(lane, start_s + turn * np.arange(ANGLES) / ANGLES)
    return [own.mean(axis=1, keepdims=True) for own in lane_signals(plan, lane, timeline)]


def _settle(system: System, plan: ForcePlan, lane: int, means: list[np.ndarray], form: BlockForm) -> np.ndarray:
    motions, forces = system.motion_rows.shape[0], system.force_columns.shape[1]
    state = np.zeros(form.core.shape[0])
    best, best_size = state, np.inf
    for step in range(MOST_STEPS if forces else 0):
        x = form.motion_rows @ state
        width = 1e-9 + 1e-6 * np.abs(x)
        points = np.concatenate([x[:, None], x[:, None] + np.diag(width), x[:, None] - np.diag(width)], axis=1)
        count = points.shape[1]
        u = interface_forces(plan, lane, [np.repeat(own, count, axis=1) for own in means], points, forces)
        acting = form.force_columns @ u[:, 0]
        residual = form.core @ state + acting
        size = float(np.linalg.norm(form.basis @ residual))
        if not np.isfinite(size):
            return best
        if size < best_size:
            best, best_size = state, size
        if size < 1e-9 * max(1.0, float(np.linalg.norm(form.basis @ acting))):
            return best
        slope = (u[:, 1 : 1 + motions] - u[:, 1 + motions :]) / (2 * width)
        duration = LONGEST_STEP_S if system.is_linear else min(FIRST_STEP_S * GROWTH**step, LONGEST_STEP_S)
        # (1/d - L - B S C) change = residual by the small system of the interface motions (Woodbury's identity).
        solved = _shifted_solve(form, 1 / duration, np.column_stack([residual, form.force_columns]))
        seen = form.motion_rows @ solved
        moved = np.linalg.lstsq(np.eye(motions) - seen[:, 1:] @ slope, seen[:, 0], rcond=None)[0]
        state = state + solved[:, 0] + solved[:, 1:] @ (slope @ moved)
    return best


def _shifted_solve(form: BlockForm, shift: float, columns: np.ndarray) -> np.ndarray:
    """Return (shift I - L)^-1 columns, block by block where the core has small blocks."""
    if not form.is_blocks:
        return np.linalg.solve(shift * np.eye(form.core.shape[0]) - form.core, columns)
    result = np.empty_like(columns)
    for size in (1, 2):
        starts = np.unique(form.first[form.last - form.first == size])
        index = starts[:, None] + np.arange(size)
        blocks = shift * np.eye(size) - form.core[index[:, :, None], index[:, None, :]]
        result[index] = np.linalg.solve(blocks, columns[index])
    return result
