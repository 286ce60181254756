"""Interface forces over one period of the shaft, at several steady speeds (lanes) at once."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InvalidValueError
from ..law import InterfaceForce, Timeline
from ..system import System

#: Bytes of cosines and sines that are kept for the next machine at the same speeds, for each set of speeds.
KEPT_BYTES = 32_000_000
#: So many instants are worth a first look.
MANY = 256
#: Instants of a first look at whether forces repeat, and by which share of their distance they lie beside 0: there the
#: sine of no order is zero at all of them, rounding beside rounding.
FEW, BESIDE = 8, 0.381966


@dataclass(frozen=True)
class PeriodicForces:
    """Signals of a machine's interface forces over one period.

    Attributes
    ----------
    systems : tuple of System
        Of each lane; they share forces and differ in their parameters and cores at most.
    signals : tuple of ndarray (signals, lanes, instants)
        Of each force.
    parameters : tuple of ndarray (parameters, lanes)
    """

    systems: tuple[System, ...]
    signals: tuple[np.ndarray, ...]
    parameters: tuple[np.ndarray, ...]

    @property
    def forces(self) -> tuple[InterfaceForce, ...]:
        """The forces of the first lane."""
        return self.systems[0].forces

    @property
    def nonlinear(self) -> tuple[int, ...]:
        """Numbers of the forces that are not linear in the motion."""
        return tuple(k for k, force in enumerate(self.forces) if not force.law.is_linear)

    def linear_parts(self) -> tuple[np.ndarray, dict[tuple[int, int], np.ndarray]]:
        """Return s (forces, lanes, instants) and S by (force, motion), each (lanes, instants), without zeros."""
        system = self.systems[0]
        lanes, instants = self.signals[0].shape[1:]
        constant = np.zeros((system.force_columns.shape[1], lanes, instants))
        slope: dict[tuple[int, int], np.ndarray] = {}
        for k, force in enumerate(self.forces):
            if not force.law.is_linear:
                continue
            acts, reads, own = system.outputs[k], system.inputs[k], self.signals[k]
            for i, act in enumerate(acts.tolist()):
                constant[act] += own[i]
                for j, read in enumerate(reads.tolist()):
                    part = own[acts.size + i * reads.size + j]
                    if part.any():
                        slope[act, read] = slope.get((act, read), 0.0) + part
        return constant, slope

    def pushed(self, k: int, lanes: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Return what a nonlinear force does, shape (outputs, points, lanes, instants).

        Parameters
        ----------
        k : int
            Number of the force.
        lanes : ndarray of int (lanes,)
        x : ndarray (inputs, points, lanes, instants)
            Several motions (points) that are looked at together.
        """
        force, system = self.forces[k], self.systems[0]
        reads, acts = system.inputs[k], system.outputs[k]
        points, instants = x.shape[1], x.shape[3]
        signals = self.signals[k][:, lanes]
        wide = np.repeat(signals[:, None], points, axis=1)
        parameters = np.repeat(self.parameters[k][:, lanes], instants, axis=1)
        u = np.zeros((acts.size, points * lanes.size * instants))
        own = np.arange(reads.size), np.arange(acts.size)
        force.law.force(
            wide.reshape(signals.shape[0], u.shape[1]),
            np.tile(parameters, points),
            np.ascontiguousarray(x).reshape(reads.size, u.shape[1]),
            *own,
            u,
        )
        return u.reshape(acts.size, *x.shape[1:])


def periodic_forces(
    systems: Sequence[System], speeds_rad_s: Sequence[float], instants: int, revolutions: int
) -> PeriodicForces:
    """Return the forces of lanes over so many revolutions.

    Raises
    ------
    InvalidValueError
        When the signals do not repeat after so many revolutions.
    """
    parameters = [np.array([one.forces[k].parameters for one in systems]).T for k in range(len(systems[0].forces))]
    if instants >= MANY:
        # A drive in which something never repeats is told so before all else is computed.
        _signals(systems, speeds_rad_s, parameters, FEW, revolutions, BESIDE)
    signals = _signals(systems, speeds_rad_s, parameters, instants, revolutions)
    return PeriodicForces(tuple(systems), signals, tuple(parameters))


def _signals(
    systems: Sequence[System],
    speeds_rad_s: Sequence[float],
    parameters: Sequence[np.ndarray],
    instants: int,
    revolutions: int,
    beside: float = 0.0,
) -> tuple[np.ndarray, ...]:
    """Return the signals of each force at instants that lie a share ``beside`` of their distance after the usual."""
    forces, lanes = systems[0].forces, len(systems)
    together: dict[tuple[object, ...], list[int]] = {}
    for k, force in enumerate(forces):
        counts = tuple(force.parameters[i] for i in force.law.counts)
        together.setdefault((force.law, len(force.parameters), len(force.outputs), counts), []).append(k)
    signals: list[np.ndarray] = [np.zeros(0)] * len(forces)
    for group in together.values():
        law = forces[group[0]].law
        timeline = _timeline(tuple(speeds_rad_s), instants, revolutions, len(group), beside)
        branch = {"branch_rad": timeline.phase_rad} if law.jumps is not None else {}
        found = law.signals(timeline, np.concatenate([parameters[k] for k in group], axis=1), **branch)
        found = np.broadcast_to(found, (*found.shape[:2], len(group) * lanes))
        found = found.reshape(found.shape[0], 2, instants, len(group), lanes).transpose(3, 1, 0, 4, 2)
        for k, (first, second) in zip(group, found, strict=True):
            _check(forces[k], first, second, revolutions)
            signals[k] = np.ascontiguousarray(first)
        _drop_many_orders(timeline)
    return tuple(signals)


def _check(force: InterfaceForce, first: np.ndarray, second: np.ndarray, revolutions: int) -> None:
    if (
        first.size
        and (np.abs(first - second).max(axis=(0, 2)) > 1e-6 * (np.abs(first).max(axis=(0, 2)) + 1e-300)).any()
    ):
        raise InvalidValueError(
            f"Force {force.name} does not repeat after {revolutions} revolution(s) of the reference shaft; "
            "allowed: a period of all forces. Give more revolutions, or simulate in time."
        )
    acts, reads = len(force.outputs), len(force.displacements) + len(force.velocities)
    if force.law.is_linear and first.shape[0] != acts * (1 + reads):
        raise InvalidValueError(
            f"Force {force.name}: {first.shape[0]} signals for {acts} outputs and {reads} inputs; "
            f"allowed: {acts * (1 + reads)}. Correct its law."
        )


@functools.lru_cache(maxsize=16)
def _timeline(speeds_rad_s: tuple[float, ...], instants: int, revolutions: int, copies: int, beside: float) -> Timeline:
    """Return two periods of each lane, the lanes so many times over; kept with the cosines it is asked for."""
    speed = np.tile(speeds_rad_s, copies)
    turns = revolutions * (np.arange(2 * instants) + beside) / instants
    phase = np.repeat(2 * np.pi * turns[:, None], speed.size, axis=1)
    still = np.zeros(phase.shape)
    return Timeline(phase / speed, phase, still + speed, still)


def _drop_many_orders(timeline: Timeline) -> None:
    # A search that varies the order of a force would fill the memory, and so would forces that jump, finely sampled.
    if 2 * len(timeline._cached) * timeline.phase_rad.nbytes > KEPT_BYTES:
        timeline._cached.clear()
