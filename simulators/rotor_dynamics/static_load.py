"""Motion of a machine at rest under its constant forces: weight, torque, preload."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..assembly import Assembly
from ..law import Direction, Law, Timeline
from ..pseudo_inverse import pseudo_inverse
from ..system import System, build_system

#: Turns over which forces are averaged, under a Hann window, and angles in each: of a force at any order from the half
#: on nothing is left of whole and half orders, and less than a hundredth of others.
_TURNS, _ANGLES = 8, 64
#: A speed at which forces of inertia are small beside any weight.
_SLOW_RAD_S = 1.0


def static_motion(assembly: Assembly, unfinished: Iterable[Any], rows: Sequence[Direction]) -> np.ndarray:
    """Return what ``rows`` read, shape (rows,), when the mean forces act on the linear core.

    Forces that depend on the motion are taken as they are without motion: their linear part is in the core, and what a
    statically determinate part carries does not depend on the rest. A motion that nothing holds is left out.

    Parameters
    ----------
    assembly : Assembly
        Left unchanged.
    unfinished : iterable of Component
        Those whose `finish` has not been called.
    rows : sequence of Direction
    """
    # At rest the gyroscopic terms do nothing, and mean forces seldom follow the speed: one answer then serves them all.
    system, follows = _finished(assembly, unfinished, 0.0)
    slow, fast = _mean_forces(system, _SLOW_RAD_S), _mean_forces(system, assembly.own_speed_rad_s)
    if follows or not np.allclose(slow[0], fast[0], rtol=0, atol=1e-12 * fast[1]):
        system, _ = _finished(assembly, unfinished, assembly.speed_rad_s)
        slow = _mean_forces(system, system.speed_rad_s)
    push = system.force_columns @ slow[0]
    if system.state_blocks:
        states = _least_response(system.core, push)
        return np.array([system.row(row) @ states for row in rows])
    # The stiffness alone is far better conditioned than the core, whose states are in m and in m/s.
    count = len(system.coordinates)
    found = _least_response(-system.stiffness_matrix, system.mass_matrix @ push[count : 2 * count])
    return np.array([system.row(row)[:count] @ found for row in rows])


def _finished(assembly: Assembly, unfinished: Iterable[Any], speed_rad_s: float) -> tuple[System, bool]:
    """Return the finished machine without probes, and whether a component asked for its speed."""
    trial = replace(
        assembly,
        speed_rad_s=speed_rad_s,
        **{name: dict(getattr(assembly, name)) for name in ("mass", "damping", "stiffness", "gyroscopic")},
        **{name: list(getattr(assembly, name)) for name in ("coordinates", "state_blocks", "forces", "notes")},
        probes=[],
    )
    for component in unfinished:
        component.finish(trial)
    follows = trial.follows_speed
    return build_system(trial), follows


def _mean_forces(system: System, speed_rad_s: float) -> tuple[np.ndarray, float]:
    """Return the mean over some turns of the forces without motion, (forces,), and their largest value."""
    mean, largest = np.zeros(system.force_columns.shape[1]), 0.0
    for force, reads, acts in zip(system.forces, system.inputs, system.outputs, strict=True):
        own, size = _mean_of_law(force.law, force.parameters, reads.size, acts.size, speed_rad_s)
        np.add.at(mean, acts, own)
        largest = max(largest, size)
    return mean, largest


@functools.lru_cache(maxsize=512)
def _mean_of_law(
    law: Law, parameters: tuple[float, ...], reads: int, acts: int, speed_rad_s: float
) -> tuple[np.ndarray, float]:
    """Return the same of one law, (acts,), that reads no motion; kept, as few of a machine's forces change."""
    count = _TURNS * _ANGLES
    phase = 2 * np.pi * np.arange(count)[:, None] / _ANGLES
    weights = (1 - np.cos(phase[:, 0] / _TURNS)) / count
    timeline = Timeline(np.zeros(phase.shape), phase, np.full(phase.shape, speed_rad_s), np.zeros(phase.shape))
    values = np.array(parameters)[:, None]
    branch = {"branch_rad": phase} if law.jumps is not None else {}
    signals = law.signals(timeline, values, **branch)[:, :, 0]
    if law.is_linear:
        forces = signals[:acts]
    else:
        forces, still = np.zeros((acts, count)), np.zeros((reads, count))
        signals, values = np.ascontiguousarray(signals), np.repeat(values, count, axis=1)
        law.force(signals, values, still, np.arange(reads), np.arange(acts), forces)
    return forces @ weights, float(np.abs(forces).max(initial=0.0))


def _least_response(matrix: np.ndarray, push: np.ndarray) -> np.ndarray:
    """Return x with matrix x + push = 0, without the motions that nothing holds."""
    balanced, scale, inverse = _inverse(np.ascontiguousarray(matrix).tobytes())
    wanted = push / scale
    found = inverse @ wanted
    for _ in range(2):
        found = found + inverse @ (wanted + balanced @ found)
    return found * scale


@functools.lru_cache(maxsize=32)
def _inverse(matrix: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a square matrix balanced, its scale, and the inverse without what nothing holds; kept, as few change."""
    from scipy.linalg import matrix_balance

    whole = np.frombuffer(matrix).reshape(2 * [math.isqrt(len(matrix) // 8)])
    # Balanced first: coordinates in m, rad and V differ so much in size that the cut for "nothing holds" would hit
    # others.
    balanced, (scale, _) = matrix_balance(whole, permute=False, separate=True)
    return balanced, scale, pseudo_inverse(-balanced, rcond=1e-14)
