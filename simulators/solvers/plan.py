"""Interface forces of one or more lanes, laid out for the compiled loop, and their signals block by block."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidValueError
from ..law import InterfaceForce, Timeline
from ..speed_profile import SpeedProfile
from ..system import System


@dataclass(frozen=True)
class ForcePlan:
    """Forces of a group of lanes that share a linear core.

    Attributes
    ----------
    forces : tuple of InterfaceForce
        Those of the first lane; the others have the same laws and other parameters.
    laws : tuple of CompiledForce
        The distinct ones.
    rows : ndarray of int (forces, 10)
        Kind (-1 linear, else index in ``laws``), then start and stop in inputs, outputs, signals, parameters, then the
        number among the forces that jump, or -1. A linear law's own signals are its coefficients; what does not depend
        on the motion is summed for each column. Signals of compiled forces, and of those that jump, are counted apart.
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
    def signal_counts(self) -> tuple[int, int, int]:
        """Number of coefficients of linear laws, of signals of compiled forces and of those that jump."""
        stops = [0, 0, 0]
        for row in self.rows:
            kind = signal_kind(row)
            stops[kind] = max(stops[kind], int(row[6]))
        return stops[0], stops[1], stops[2]

    @property
    def lanes(self) -> int:
        """Number of runs side by side."""
        return len(self.profiles)

    def own_parameters(self, k: int) -> np.ndarray:
        """Return the parameters of force ``k``, shape (parameters, lanes)."""
        return self.parameters[self.rows[k, 7] : self.rows[k, 8]]

    def timeline(self, time_s: np.ndarray, spacing_s: float) -> Timeline:
        """Return the timeline of all distinct speed profiles at the same evenly spaced instants (instants,)."""
        profiles = tuple(dict.fromkeys(self.profiles))
        phase = np.stack([profile.phase_rad(time_s) for profile in profiles], axis=-1)
        speed = np.stack([profile.speed_rad_s(time_s) for profile in profiles], axis=-1)
        change = np.stack([profile.acceleration_rad_s2(time_s) for profile in profiles], axis=-1)
        advance = np.array([own.speeds_rad_s[0] * spacing_s if own.is_steady else math.nan for own in profiles])
        return Timeline(np.repeat(time_s[:, None], len(profiles), axis=1), phase, speed, change, advance)

    def distinct_columns(self, k: int) -> np.ndarray:
        """Return which columns of `timeline` belong to the distinct lanes of force ``k``."""
        profiles = list(dict.fromkeys(self.profiles))
        return np.array([profiles.index(self.profiles[lane]) for lane in self.distinct[k][0]])

    def distinct_signals(self, k: int, timeline: Timeline, **branch: np.ndarray) -> np.ndarray:
        """Return the signals of force ``k`` on all its distinct lanes, shape (signals, instants, distinct lanes)."""
        parameters = self.own_parameters(k)[:, self.distinct[k][0]]
        return self.forces[k].law.signals(timeline.select(self.distinct_columns(k)), parameters, **branch)

    def lane_timeline(self, lane: int, time_s: np.ndarray) -> Timeline:
        """Return the timeline of one lane at its own instants (instants,)."""
        profile = self.profiles[lane]
        return Timeline(
            time_s[:, None],
            profile.phase_rad(time_s)[:, None],
            profile.speed_rad_s(time_s)[:, None],
            profile.acceleration_rad_s2(time_s)[:, None],
        )


def signal_kind(row: np.ndarray) -> int:
    """Return 0 for a linear law, 1 for a compiled force, 2 for one that jumps; ``row`` is one of `ForcePlan.rows`."""
    return 2 if row[9] >= 0 else int(row[0] >= 0)


def force_plan(systems: list[System], profiles: list[SpeedProfile]) -> ForcePlan:
    """Lay out the forces of lanes that share a linear core and the same laws in the same order."""
    forces = systems[0].forces
    distinct: list[Any] = []
    rows = np.zeros((len(forces), 10), dtype=np.int64)
    counts = [0, 0, 0]
    at = np.zeros(3, dtype=np.int64)
    jumping: list[int] = []
    for k, force in enumerate(forces):
        count = _signal_count(force, profiles[0])
        rows[k, 0] = rows[k, 9] = -1
        if force.law.is_linear:
            count -= len(force.outputs)
        else:
            if force.law.force not in distinct:
                distinct.append(force.law.force)
            rows[k, 0] = distinct.index(force.law.force)
        if force.law.jumps is not None:
            rows[k, 9] = len(jumping)
            jumping.append(k)
        kind = signal_kind(rows[k])
        rows[k, 5:7] = counts[kind], counts[kind] + count
        counts[kind] += count
        stop = at + np.array([systems[0].inputs[k].size, systems[0].outputs[k].size, len(force.parameters)])
        rows[k, [1, 3, 7]], rows[k, [2, 4, 8]] = at, stop
        at = stop
    _check_jumps(systems[0], tuple(jumping))
    values = [[v for force in system.forces for v in force.parameters] for system in systems]
    parameters = np.ascontiguousarray(np.array(values, dtype=float).reshape(len(systems), -1).T)
    return ForcePlan(
        forces=forces,
        laws=tuple(distinct),
        rows=rows,
        inputs=np.concatenate([*systems[0].inputs, np.zeros(0, dtype=np.int64)]).astype(np.int64),
        outputs=np.concatenate([*systems[0].outputs, np.zeros(0, dtype=np.int64)]).astype(np.int64),
        parameters=parameters,
        profiles=tuple(profiles),
        jumping=tuple(jumping),
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


def on_all_lanes(plan: ForcePlan, k: int, own: np.ndarray) -> np.ndarray:
    """Return signals of distinct lanes for all lanes; one that all share stays one."""
    lanes = plan.distinct[k][1]
    return own if own.shape[-1] in (1, lanes.size) else own[..., lanes]


@dataclass(frozen=True)
class BlockSignals:
    """What `kernel.run_block` needs of the signals of a block.

    Attributes
    ----------
    pushes : ndarray (2 steps + 1, force columns, lanes)
        Forces that do not depend on the motion, at the start, middle and end of each step.
    coefficients : ndarray (signals, 2 steps + 1, lanes)
        Of linear laws.
    halves : ndarray (2 steps + 1, signals, lanes)
        Signals of compiled forces.
    jumped, events, branches : ndarray
        See `jumps.all_jumps`.
    """

    pushes: np.ndarray
    coefficients: np.ndarray
    halves: np.ndarray
    jumped: np.ndarray
    events: np.ndarray
    branches: np.ndarray


class Room:
    """Memory for the signals of one plan, used again for every block: fresh memory costs more than writing into it."""

    def __init__(self) -> None:
        self._kept: dict[str, np.ndarray] = {}

    def array(self, name: str, *shape: int) -> np.ndarray:
        """Return an array of this shape; zero where no array of this name has been written to."""
        size = math.prod(shape)
        if name not in self._kept or self._kept[name].size < size:
            self._kept[name] = np.zeros(size)
        return self._kept[name][:size].reshape(shape)


def block_signals(
    plan: ForcePlan, start_s: float, step_s: float, steps: int, room: Room, *, done: int = 0
) -> BlockSignals:
    """Return the signals of the block of so many steps that begins ``done`` steps after ``start_s``; in ``room``."""
    # Counted from the start: an instant has the same bits whatever the length of the blocks.
    half_times = start_s + 0.5 * step_s * np.arange(2 * done, 2 * (done + steps) + 1)
    timeline = plan.timeline(half_times, 0.5 * step_s)
    linear, compiled, jumping = plan.signal_counts
    # Instants first: a column into which no linear law pushes stays zero, however long the blocks are.
    pushes = room.array("pushes", half_times.size, plan.columns, plan.lanes)
    coefficients = room.array("coefficients", linear, half_times.size, plan.lanes)
    halves = room.array("halves", half_times.size, compiled, plan.lanes)
    jumped = room.array("jumped", steps, 3, jumping, plan.lanes)
    written = np.zeros(plan.columns, dtype=bool)
    for k, force in enumerate(plan.forces):
        if k in plan.jumping:
            continue
        own = on_all_lanes(plan, k, plan.distinct_signals(k, timeline))
        place = slice(plan.rows[k, 5], plan.rows[k, 6])
        if not force.law.is_linear:
            halves[:, place] = np.moveaxis(own, 0, 1)
            continue
        acts = plan.outputs[plan.rows[k, 3] : plan.rows[k, 4]]
        for act, push in zip(acts, own, strict=False):
            if written[act]:
                pushes[:, act] += push
            else:
                pushes[:, act], written[act] = push, True
        coefficients[place] = own[acts.size :]
    if plan.jumping:
        from .jumps import all_jumps

        return BlockSignals(pushes, coefficients, halves, *all_jumps(plan, half_times, step_s, timeline, jumped))
    return BlockSignals(pushes, coefficients, halves, jumped, np.zeros((0, 4)), np.zeros((0, 6, 1, 1)))
