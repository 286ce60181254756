"""Interface forces of one or more lanes, laid out for the compiled loop, and their signals block by block."""

from __future__ import annotations

import functools
import threading
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidValueError
from ..law import InterfaceForce, Timeline, compiled_force
from ..speed_profile import SpeedProfile
from ..system import System


@dataclass(frozen=True)
class ForcePlan:
    """Forces of a group of lanes that share a linear core.

    Attributes
    ----------
    forces : tuple of InterfaceForce
        Those of the first lane; the others have the same laws and other parameters.
    laws : tuple of compiled functions
    rows : ndarray of int (forces, 9)
        See `kernel.run_block`. A linear law's own signals are its coefficients; its forces that do not depend on the
        motion are summed into the first rows of all signals.
    inputs, outputs : ndarray of int
    parameters : ndarray (parameters, lanes)
    profiles : tuple of SpeedProfile
    jumping : tuple of int
        Forces whose signals jump.
    distinct : tuple of (ndarray, ndarray)
        For each force, lanes with distinct signals, and for every lane the number of the one that it equals: lanes
        often differ in one parameter only, and signals cost much.
    """

    forces: tuple[InterfaceForce, ...]
    laws: tuple[Any, ...]
    rows: np.ndarray
    inputs: np.ndarray
    outputs: np.ndarray
    parameters: np.ndarray
    profiles: tuple[SpeedProfile, ...]
    jumping: tuple[int, ...]
    distinct: tuple[tuple[np.ndarray, np.ndarray], ...]

    @property
    def columns(self) -> int:
        """Number of force columns."""
        return int(self.outputs.max()) + 1 if self.outputs.size else 0

    @property
    def signals(self) -> int:
        """Number of signals."""
        return int(self.rows[-1, 6]) if len(self.forces) else 0

    @property
    def lanes(self) -> int:
        """Number of runs side by side."""
        return len(self.profiles)

    def own_parameters(self, k: int) -> np.ndarray:
        """Return the parameters of force ``k``, shape (parameters, lanes)."""
        return self.parameters[self.rows[k, 7] : self.rows[k, 8]]

    def timeline(self, time_s: np.ndarray) -> Timeline:
        """Return the timeline of all distinct speed profiles at the same instants (instants,)."""
        profiles = tuple(dict.fromkeys(self.profiles))
        phase = np.stack([profile.phase_rad(time_s) for profile in profiles], axis=-1)
        speed = np.stack([profile.speed_rad_s(time_s) for profile in profiles], axis=-1)
        change = np.stack([profile.acceleration_rad_s2(time_s) for profile in profiles], axis=-1)
        return Timeline(np.repeat(time_s[:, None], len(profiles), axis=1), phase, speed, change)

    def distinct_columns(self, k: int) -> np.ndarray:
        """Return which columns of `timeline` belong to the distinct lanes of force ``k``."""
        profiles = list(dict.fromkeys(self.profiles))
        return np.array([profiles.index(self.profiles[lane]) for lane in self.distinct[k][0]])

    def distinct_signals(self, k: int, timeline: Timeline, **branch: np.ndarray) -> np.ndarray:
        """Return the signals of force ``k`` on all its distinct lanes, shape (instants, signals, distinct lanes)."""
        parameters = self.own_parameters(k)[:, self.distinct[k][0]]
        own = self.forces[k].law.signals(timeline.select(self.distinct_columns(k)), parameters, **branch)
        return np.moveaxis(own, 0, 1)

    def lane_timeline(self, lane: int, time_s: np.ndarray) -> Timeline:
        """Return the timeline of one lane at its own instants (instants,)."""
        profile = self.profiles[lane]
        return Timeline(
            time_s[:, None],
            profile.phase_rad(time_s)[:, None],
            profile.speed_rad_s(time_s)[:, None],
            profile.acceleration_rad_s2(time_s)[:, None],
        )


def force_plan(systems: list[System], profiles: list[SpeedProfile]) -> ForcePlan:
    """Lay out the forces of lanes that share a linear core and the same laws in the same order."""
    forces = systems[0].forces
    distinct: list[Any] = []
    rows = np.zeros((len(forces), 9), dtype=np.int64)
    # The first signals are the forces that do not depend on the motion, one row for each force column.
    at = np.array([0, 0, systems[0].force_columns.shape[1], 0], dtype=np.int64)
    for k, force in enumerate(forces):
        kind, count = -1, _signal_count(force, profiles[0])
        if force.law.is_linear:
            count -= len(force.outputs)
        else:
            if force.law.force not in distinct:
                distinct.append(force.law.force)
            kind = distinct.index(force.law.force)
        sizes = (systems[0].inputs[k].size, systems[0].outputs[k].size, count, len(force.parameters))
        rows[k, 0] = kind
        rows[k, 1::2], rows[k, 2::2] = at, at + sizes
        at += sizes
    jumping = tuple(k for k, force in enumerate(forces) if force.law.jumps is not None)
    _check_jumps(systems[0], jumping)
    values = [[v for force in system.forces for v in force.parameters] for system in systems]
    parameters = np.ascontiguousarray(np.array(values, dtype=float).reshape(len(systems), -1).T)
    return ForcePlan(
        forces=forces,
        laws=law_tuple(tuple(force.compiled for force in distinct)),
        rows=rows,
        inputs=np.concatenate([*systems[0].inputs, np.zeros(0, dtype=np.int64)]).astype(np.int64),
        outputs=np.concatenate([*systems[0].outputs, np.zeros(0, dtype=np.int64)]).astype(np.int64),
        parameters=parameters,
        profiles=tuple(profiles),
        jumping=jumping,
        distinct=tuple(_distinct(profiles, parameters[row[7] : row[8]]) for row in rows),
    )


def _distinct(profiles: list[SpeedProfile], parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    seen: dict[tuple[SpeedProfile, bytes], int] = {}
    first, number = [], []
    for lane, profile in enumerate(profiles):
        key = (profile, parameters[:, lane].tobytes())
        if key not in seen:
            seen[key] = len(first)
            first.append(lane)
        number.append(seen[key])
    return np.array(first), np.array(number)


def _signal_count(force: InterfaceForce, profile: SpeedProfile) -> int:
    instant = np.zeros(1)
    timeline = Timeline(
        instant[:, None],
        profile.phase_rad(instant)[:, None],
        profile.speed_rad_s(instant)[:, None],
        profile.acceleration_rad_s2(instant)[:, None],
    )
    parameters = np.array(force.parameters)[:, None]
    extra = {"branch_rad": timeline.phase_rad} if force.law.jumps is not None else {}
    count = force.law.signals(timeline, parameters, **extra).shape[0]
    n_out, n_in = len(force.outputs), len(force.displacements) + len(force.velocities)
    if force.law.is_linear and count != n_out * (1 + n_in):
        raise InvalidValueError(
            f"Force {force.name}: {count} signals for {n_out} outputs and {n_in} inputs; "
            f"allowed: {n_out * (1 + n_in)}. Correct its law."
        )
    return count


def _check_jumps(system: System, jumping: tuple[int, ...]) -> None:
    for k in jumping:
        force = system.forces[k]
        if force.law.is_linear or [dict(d) for d in force.displacements] != [dict(d) for d in force.velocities]:
            raise InvalidValueError(
                f"Force {force.name} jumps; allowed: a compiled force that reads displacements and the same velocities."
            )


def _nothing(signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    return


@functools.cache
def law_tuple(distinct: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the compiled forces, filled up to a fixed number so that one compiled loop serves every machine."""
    from .kernel_parts import KINDS

    if len(distinct) > KINDS:
        raise InvalidValueError(
            f"This machine has {len(distinct)} kinds of nonlinear force; allowed: {KINDS} in one run. Take some out."
        )
    return (*distinct, *([_compiled_nothing()] * (KINDS - len(distinct))))


@functools.cache
def _compiled_nothing() -> Any:
    return compiled_force(_nothing).compiled


class _Quiet:
    """Silences numba's remark that tuples of functions are experimental, from first entry to last exit.

    numba makes it at every call. The warning filters belong to the whole process, hence the count and the lock.
    """

    def __init__(self) -> None:
        self._lock, self._inside = threading.Lock(), 0
        self._filters = warnings.catch_warnings()

    def __enter__(self) -> None:
        from numba.core.errors import NumbaExperimentalFeatureWarning

        with self._lock:
            if self._inside == 0:
                self._filters = warnings.catch_warnings()
                self._filters.__enter__()
                warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
            self._inside += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                self._filters.__exit__(None, None, None)


quiet = _Quiet()


def write_signals(plan: ForcePlan, k: int, signals: np.ndarray, stages: tuple[np.ndarray, ...]) -> None:
    """Enter the signals of force ``k`` on its distinct lanes, one array a stage, into the block of all lanes."""
    place, lanes = slice(plan.rows[k, 5], plan.rows[k, 6]), plan.distinct[k][1]
    same = lanes.size == plan.distinct[k][0].size
    acts = plan.outputs[plan.rows[k, 3] : plan.rows[k, 4]] if plan.forces[k].law.is_linear else ()
    for stage, own in enumerate(stages):
        if not same and own.shape[2] > 1:
            own = own[:, :, lanes]
        for i, act in enumerate(acts):
            signals[:, stage, act] += own[:, i]
        signals[:, stage, place] = own[:, len(acts) :]


def block_signals(
    plan: ForcePlan, start_s: float, step_s: float, steps: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what `kernel.run_block` needs of the signals of a block: signals, events and branches.

    Parameters
    ----------
    plan : ForcePlan
    start_s, step_s : float
    steps : int
    """
    signals = np.empty((steps, 3, plan.signals, plan.lanes))
    signals[:, :, : plan.columns] = 0.0
    half_times = start_s + 0.5 * step_s * np.arange(2 * steps + 1)
    timeline = plan.timeline(half_times)
    for k in range(len(plan.forces)):
        if k in plan.jumping:
            continue
        own = plan.distinct_signals(k, timeline)
        write_signals(plan, k, signals, (own[0:-1:2], own[1::2], own[2::2]))
    events, branches = [np.zeros((0, 4))], []
    for which, k in enumerate(plan.jumping):
        from .jumps import jump_events

        found, parts = jump_events(plan, k, which, half_times, timeline, signals)
        events.append(found)
        branches.append(parts)
    if not branches:
        return signals, events[0], np.zeros((0, 3, 2, 1, 1))
    joined = np.concatenate(events)
    widest = max(part.shape[3] for part in branches)
    padded = [np.pad(part, [(0, 0)] * 3 + [(0, widest - part.shape[3]), (0, 0)]) for part in branches]
    order = np.lexsort((-joined[:, 3], joined[:, 1], joined[:, 0]))
    return signals, joined[order], np.ascontiguousarray(np.concatenate(padded)[order])
