"""Where a machine comes to rest under its mean forces: the start of a simulation, close to its steady motion."""

from __future__ import annotations

import numpy as np

from ..law import Timeline
from ..system import System
from .plan import ForcePlan

#: Angles of the first revolution over which the signals are averaged.
ANGLES = 64
MOST_STEPS = 60
#: First step of the search in seconds; every further one is twice as long, until each is one of Newton's method.
FIRST_STEP_S, LONGEST_STEP_S = 1e-5, 1e6


def static_equilibrium(system: System, plan: ForcePlan, start_s: float) -> np.ndarray:
    """Return states (states, lanes) with L y + B u(mean signals, C y) = 0, or zero where none is found.

    Implicit Euler steps of growing length with the interface forces' finite-difference slope: the machine settles
    heavily damped. Newton's method alone fails where play leaves a shaft free until a contact closes.
    """
    states = np.zeros((system.states, plan.lanes))
    for lane in range(plan.lanes):
        means = _mean_signals(plan, lane, start_s)
        found = _settle(system, plan, lane, means)
        if found is not None:
            states[:, lane] = found
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


def _settle(system: System, plan: ForcePlan, lane: int, means: list[np.ndarray]) -> np.ndarray | None:
    motions, forces = system.motion_rows.shape[0], system.force_columns.shape[1]
    if forces == 0:
        return np.zeros(system.states)
    state = np.zeros(system.states)
    best, best_size = None, np.inf
    for step in range(MOST_STEPS):
        x = system.motion_rows @ state
        width = 1e-9 + 1e-6 * np.abs(x)
        points = np.concatenate([x[:, None], x[:, None] + np.diag(width), x[:, None] - np.diag(width)], axis=1)
        count = points.shape[1]
        u = interface_forces(plan, lane, [np.repeat(own, count, axis=1) for own in means], points, forces)
        residual = system.core @ state + system.force_columns @ u[:, 0]
        size = float(np.linalg.norm(residual))
        if not np.isfinite(size):
            return best
        if size < best_size:
            best, best_size = state, size
        slope = (u[:, 1 : 1 + motions] - u[:, 1 + motions :]) / (2 * width)
        jacobian = system.core + system.force_columns @ slope @ system.motion_rows
        if size < 1e-9 * max(1.0, float(np.linalg.norm(system.force_columns @ u[:, 0]))):
            return best
        duration = min(FIRST_STEP_S * 2.0**step, LONGEST_STEP_S)
        state = state + np.linalg.solve(np.eye(system.states) / duration - jacobian, residual)
    return best
