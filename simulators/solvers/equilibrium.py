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
#: After so many of the longest steps in a row, each of which leaves more than this share of the smallest residual, the
#: search is over: a mean torque on a shaft that nothing holds would only turn it on and on.
STALLED_STEPS, STALLED = 10, 0.99


def static_equilibrium(system: System, plan: ForcePlan, start_s: float, form: BlockForm) -> np.ndarray:
    """Return states (states, lanes) of ``form`` with L y + B u(mean signals, C y) = 0, or zero where none is found.

    Implicit Euler steps of growing length with the interface forces' finite-difference slope: the machine settles
    heavily damped. Newton's method alone fails where play leaves a shaft free until a contact closes.
    """
    known: dict[tuple[SpeedProfile, bytes], int] = {}
    number = [
        known.setdefault((profile, plan.parameters[:, lane].tobytes()), len(known))
        for lane, profile in enumerate(plan.profiles)
    ]
    if not system.force_columns.shape[1]:
        return np.zeros((form.core.shape[0], plan.lanes))
    lanes = np.unique(number, return_index=True)[1]
    means = _mean_signals(plan, lanes, start_s)
    return np.ascontiguousarray(_settle(system, plan, lanes, means, form)[number].T)


def interface_forces(
    plan: ForcePlan, lanes: int | np.ndarray, signals: list[np.ndarray], x: np.ndarray, forces: int
) -> np.ndarray:
    """Return u (forces, instants) for motions x (motions, instants) and signals of each force.

    ``signals`` holds one array (signals, instants) for each force. The instants take the place of the lanes, so that
    one call to each law does. ``lanes`` says whose parameters hold, one lane or one for each instant.
    """
    u = np.zeros((forces, x.shape[1]))
    x = np.ascontiguousarray(x)
    whose = np.broadcast_to(lanes, x.shape[1])
    for k, force in enumerate(plan.forces):
        reads = plan.inputs[plan.rows[k, 1] : plan.rows[k, 2]]
        acts = plan.outputs[plan.rows[k, 3] : plan.rows[k, 4]]
        own = signals[k]
        if force.law.is_linear:
            row = acts.size
            for i, act in enumerate(acts):
                u[act] += own[i]
                for read in reads:
                    u[act] += own[row] * x[read]
                    row += 1
        else:
            parameters = np.ascontiguousarray(plan.own_parameters(k)[:, whose])
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


def _mean_signals(plan: ForcePlan, lanes: np.ndarray, start_s: float) -> list[np.ndarray]:
    """Return the mean signals (signals, lanes) of each force over the first revolution."""
    parts = []
    for lane in lanes:
        speed = float(plan.profiles[lane].speed_rad_s(np.array([start_s]))[0])
        turn = 2 * np.pi / max(abs(speed), 1e-3)
        parts.append(plan.lane_timeline(lane, start_s + turn * np.arange(ANGLES) / ANGLES))
    timeline = Timeline(
        np.concatenate([part.time_s for part in parts], axis=1),
        np.concatenate([part.phase_rad for part in parts], axis=1),
        np.concatenate([part.speed_rad_s for part in parts], axis=1),
        np.concatenate([part.acceleration_rad_s2 for part in parts], axis=1),
    )
    found = []
    for k, force in enumerate(plan.forces):
        extra = {"branch_rad": timeline.phase_rad} if force.law.jumps is not None else {}
        own = force.law.signals(timeline, plan.own_parameters(k)[:, lanes], **extra)
        # As a sum along the last axis: the same bits however many lanes there are.
        own = np.ascontiguousarray(np.moveaxis(own, 1, 2)).mean(axis=2)
        found.append(np.broadcast_to(own, (own.shape[0], lanes.size)))
    return found


def _settle(system: System, plan: ForcePlan, lanes: np.ndarray, means: list[np.ndarray], form: BlockForm) -> np.ndarray:
    """Return the states at rest of each lane, shape (lanes, states).

    All lanes go side by side. Products are done lane by lane in stacks, so that no lane changes another's bits.
    """
    count, motions = lanes.size, system.motion_rows.shape[0]
    state = np.zeros((count, form.core.shape[0]))
    best, best_size = state.copy(), np.full(count, np.inf)
    left, stalled = np.arange(count), np.zeros(count, dtype=int)
    for step in range(MOST_STEPS):
        duration = LONGEST_STEP_S if system.is_linear else min(FIRST_STEP_S * GROWTH**step, LONGEST_STEP_S)
        now = state[left]
        acting, slope = _forces_and_slopes(plan, lanes[left], [own[:, left] for own in means], form, now)
        pushed = _times(form.force_columns, acting)
        residual = _times(form.core, now) + pushed
        size = np.linalg.norm(_times(form.basis, residual), axis=1)
        no_less = (size > STALLED * best_size[left]) & (duration == LONGEST_STEP_S)
        stalled[left] = np.where(no_less, stalled[left] + 1, 0)
        better = size < best_size[left]
        best[left[better]], best_size[left[better]] = now[better], size[better]
        going = np.isfinite(size) & (size >= 1e-9 * np.maximum(1.0, np.linalg.norm(_times(form.basis, pushed), axis=1)))
        going &= stalled[left] < STALLED_STEPS
        left, now, residual, slope = left[going], now[going], residual[going], slope[going]
        if not left.size:
            break
        # (1/d - L - B S C) change = residual by the small system of the interface motions (Woodbury's identity).
        solved = _shifted_inverse(form, 1 / duration)
        moved_alone, pushing = _times(solved, residual), solved @ form.force_columns
        seen = form.motion_rows @ pushing
        moved = _solved(np.eye(motions) - np.matmul(seen, slope), _times(form.motion_rows, moved_alone))
        state[left] = now + moved_alone + _times(pushing, np.matmul(slope, moved[:, :, None])[:, :, 0])
    return best


def _times(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return the matrix times each of the vectors (lanes, size)."""
    return np.matmul(matrix, vectors[:, :, None])[:, :, 0]


def _solved(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return the solution of each small system; of a singular one the smallest of the best."""
    try:
        return np.linalg.solve(matrices, vectors[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        return np.array([_solved_alone(matrix, vector) for matrix, vector in zip(matrices, vectors, strict=True)])


def _solved_alone(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    try:
        return np.linalg.solve(matrix[None], vector[None, :, None])[0, :, 0]
    except np.linalg.LinAlgError:
        return np.linalg.lstsq(matrix, vector, rcond=None)[0]


def _forces_and_slopes(
    plan: ForcePlan, lanes: np.ndarray, means: list[np.ndarray], form: BlockForm, state: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the forces (lanes, forces) and their slopes against the motions (lanes, forces, motions)."""
    x = _times(form.motion_rows, state)
    count, motions = x.shape
    width = 1e-9 + 1e-6 * np.abs(x)
    shifts = width[:, :, None] * np.eye(motions)
    points = x[:, :, None] + np.concatenate([np.zeros((count, motions, 1)), shifts, -shifts], axis=2)
    instants = points.shape[2]
    u = interface_forces(
        plan,
        np.repeat(lanes, instants),
        [np.repeat(own, instants, axis=1) for own in means],
        points.transpose(1, 0, 2).reshape(motions, count * instants),
        form.force_columns.shape[1],
    )
    u = u.reshape(u.shape[0], count, instants).transpose(1, 0, 2)
    return u[:, :, 0], (u[:, :, 1 : 1 + motions] - u[:, :, 1 + motions :]) / (2 * width[:, None, :])


def _shifted_inverse(form: BlockForm, shift: float) -> np.ndarray:
    """Return (shift I - L)^-1, block by block where the core has small blocks."""
    if not form.is_blocks:
        return np.linalg.inv(shift * np.eye(form.core.shape[0]) - form.core)
    result = np.zeros(form.core.shape)
    for size in (1, 2):
        starts = np.unique(form.first[form.last - form.first == size])
        index = starts[:, None] + np.arange(size)
        place = index[:, :, None], index[:, None, :]
        result[place] = np.linalg.inv(shift * np.eye(size) - form.core[place])
    return result
