"""A machine at one speed, as matrices: y' = L y + B u(t, phase, C y), probes = D y + E u."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .assembly import Assembly, Probe, StateBlock
from .errors import InvalidValueError
from .law import Direction, InterfaceForce, Law, Timeline


@dataclass(frozen=True)
class System:
    """Linear core and interface of a machine.

    With n coordinates and k controller states, y = [q, q', z] has 2 n + k entries.

    Attributes
    ----------
    core : ndarray (states, states)
        L.
    force_columns : ndarray (states, interface forces)
        B.
    motion_rows : ndarray (interface motions, states)
        C.
    probe_rows : ndarray (probes, states)
    probe_columns : ndarray (probes, interface forces)
        What a force does at once to a probe: not zero for acceleration.
    forces : tuple of InterfaceForce
    inputs, outputs : tuple of ndarray
        For each force, its rows of C and its columns of B.
    mass_matrix : ndarray (coordinates, coordinates)
    damping_matrix, gyroscopic_matrix, stiffness_matrix : ndarray (coordinates, coordinates)
        Damping without the gyroscopic part, which is the speed times its matrix.
    force_directions : ndarray (coordinates, interface forces)
        B before the division by the mass.
    probe_directions : ndarray (probes, coordinates)
        What each probe sees of displacements, velocities or accelerations.
    state_blocks : tuple of StateBlock
    speed_rad_s : float
        Speed about which L was formed.
    """

    core: np.ndarray
    force_columns: np.ndarray
    motion_rows: np.ndarray
    probe_rows: np.ndarray
    probe_columns: np.ndarray
    probes: tuple[Probe, ...]
    forces: tuple[InterfaceForce, ...]
    inputs: tuple[np.ndarray, ...]
    outputs: tuple[np.ndarray, ...]
    coordinates: tuple[str, ...]
    mass_matrix: np.ndarray
    damping_matrix: np.ndarray
    gyroscopic_matrix: np.ndarray
    stiffness_matrix: np.ndarray
    force_directions: np.ndarray
    probe_directions: np.ndarray
    state_blocks: tuple[StateBlock, ...]
    speed_rad_s: float
    notes: tuple[str, ...] = ()

    @property
    def is_linear(self) -> bool:
        """Whether every interface force is linear in the motion."""
        return all(force.law.is_linear for force in self.forces)

    @property
    def states(self) -> int:
        """Number of states."""
        return self.core.shape[0]

    def with_probes(self, names: Sequence[str]) -> System:
        """Return the system with these probes and those that have a limit, in the order of the machine."""
        known = [probe.name for probe in self.probes]
        for name in names:
            if name not in known:
                raise InvalidValueError(f"No probe {name!r}; allowed: {', '.join(known)}. Correct the name.")
        kept = [i for i, probe in enumerate(self.probes) if probe.name in names or probe.limit is not None]
        return replace(
            self,
            probe_rows=self.probe_rows[kept],
            probe_columns=self.probe_columns[kept],
            probes=tuple(self.probes[i] for i in kept),
            probe_directions=self.probe_directions[kept],
        )

    def row(self, direction: Direction, *, velocity: bool = False) -> np.ndarray:
        """Return the row over the states that reads a displacement or velocity."""
        row = np.zeros(self.states)
        offset = len(self.coordinates) if velocity else 0
        for name, value in direction.items():
            row[offset + _index(_positions(self.coordinates), name)] += value
        return row


@dataclass
class _Rows:
    """Distinct vectors in order of appearance: two effects at one place share a column."""

    vectors: list[np.ndarray] = field(default_factory=list)
    known: dict[bytes, int] = field(default_factory=dict)

    def index(self, vector: np.ndarray) -> int:
        key = vector.tobytes()
        if key not in self.known:
            self.known[key] = len(self.vectors)
            self.vectors.append(vector)
        return self.known[key]

    def matrix(self, width: int) -> np.ndarray:
        return np.array(self.vectors).reshape(len(self.vectors), width)


def build_system(assembly: Assembly, *, steady: bool = True) -> System:
    """Turn an assembly into matrices.

    Parameters
    ----------
    assembly : Assembly
        With its components finished.
    steady : bool
        False when the speed will change: the gyroscopic change and the inertia of accelerating parts then become
        interface forces.
    """
    names = _positions(assembly.coordinates)
    n = len(names)
    mass = _matrix(assembly.mass, names)
    inverse = _inverse(mass.tobytes())
    if inverse is None:
        bare = [name for i, name in enumerate(names) if not mass[i].any()]
        raise InvalidValueError(
            f"The mass matrix is singular (no mass at {', '.join(bare) or 'a combination of coordinates'}); allowed: "
            "every degree of freedom has mass. Give it a mass or remove it."
        )
    forces = [*assembly.forces, *([] if steady else _speed_change_forces(assembly, names, mass))]
    damping, gyroscopic, stiffness = (
        _matrix(entries, names) for entries in (assembly.damping, assembly.gyroscopic, assembly.stiffness)
    )
    core = _core(assembly, names, inverse, damping + assembly.speed_rad_s * gyroscopic, stiffness)
    size = core.shape[0]
    rows, columns = _Rows(), _Rows()
    directions: dict[int, np.ndarray] = {}
    inputs, outputs = [], []
    for force in forces:
        read = [_padded(_vector(d, names), 0, size) for d in force.displacements]
        read += [_padded(_vector(d, names), n, size) for d in force.velocities]
        inputs.append(np.array([rows.index(v) for v in read], dtype=np.int64))
        pushes = [_vector(d, names) for d in force.outputs]
        acts = [columns.index(_padded(inverse @ push, n, size)) for push in pushes]
        directions.update(zip(acts, pushes, strict=True))
        outputs.append(np.array(acts, dtype=np.int64))
    force_columns = columns.matrix(size).T.copy()
    seen = np.array([_vector(probe.row, names) for probe in assembly.probes]).reshape(-1, n)
    probe_rows, probe_columns = _probe_matrices(assembly.probes, seen, core, force_columns)
    return System(
        core=core,
        force_columns=force_columns,
        motion_rows=rows.matrix(size),
        probe_rows=probe_rows,
        probe_columns=probe_columns,
        probes=tuple(assembly.probes),
        forces=tuple(forces),
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        coordinates=tuple(names),
        mass_matrix=mass,
        damping_matrix=damping,
        gyroscopic_matrix=gyroscopic,
        stiffness_matrix=stiffness,
        force_directions=np.array([directions[i] for i in range(len(directions))]).reshape(-1, n).T,
        probe_directions=seen,
        state_blocks=tuple(assembly.state_blocks),
        speed_rad_s=assembly.speed_rad_s,
        notes=tuple(assembly.notes),
    )


@functools.lru_cache(maxsize=32)
def _inverse(mass: bytes) -> np.ndarray | None:
    """Return the inverse of a mass matrix, None of a singular one; kept, as few effects change masses."""
    matrix = np.frombuffer(mass).reshape(2 * [math.isqrt(len(mass) // 8)])
    if not matrix.size or np.linalg.matrix_rank(matrix) < matrix.shape[0]:
        return None
    inverse = np.linalg.inv(matrix)
    inverse.flags.writeable = False
    return inverse


def _core(
    assembly: Assembly, names: dict[str, int], inverse: np.ndarray, damping: np.ndarray, stiffness: np.ndarray
) -> np.ndarray:
    n = len(names)
    extra = sum(block.a.shape[0] for block in assembly.state_blocks)
    core = np.zeros((2 * n + extra, 2 * n + extra))
    core[:n, n : 2 * n] = np.eye(n)
    at = 2 * n
    for block in assembly.state_blocks:
        seen, acts = _vector(block.input, names), inverse @ _vector(block.output, names)
        states = slice(at, at + block.a.shape[0])
        core[states, states] = block.a
        core[states, :n] = np.outer(block.b, seen)
        core[n : 2 * n, states] += np.outer(acts, block.c)
        core[n : 2 * n, :n] += block.d * np.outer(acts, seen)
        at = states.stop
    core[n : 2 * n, :n] -= inverse @ stiffness
    core[n : 2 * n, n : 2 * n] -= inverse @ damping
    return core


def _probe_matrices(
    probes: list[Probe], seen: np.ndarray, core: np.ndarray, force_columns: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    n, size = seen.shape[1], core.shape[0]
    rows = np.zeros((len(probes), size))
    columns = np.zeros((len(probes), force_columns.shape[1]))
    for i, (probe, vector) in enumerate(zip(probes, seen, strict=True)):
        if probe.quantity == "acceleration":
            rows[i] = vector @ core[n : 2 * n]
            columns[i] = vector @ force_columns[n : 2 * n]
        elif probe.quantity in ("displacement", "velocity"):
            start = 0 if probe.quantity == "displacement" else n
            rows[i, start : start + n] = vector
        else:
            raise InvalidValueError(
                f"Probe {probe.name} measures {probe.quantity!r}; allowed: displacement, velocity, acceleration."
            )
    return rows, columns


def _gyroscopic_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    """No force without motion, then the coefficient -(speed - reference) of one row of G q'."""
    return np.stack([np.zeros(timeline.speed_rad_s.shape), -(timeline.speed_rad_s - parameters[0])])


def _inertia_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    return -parameters[0] * timeline.acceleration_rad_s2[None]


GYROSCOPIC_CHANGE = Law("gyroscopic change with speed", _gyroscopic_signals)
INERTIA_TORQUE = Law("inertia torque of a changing speed", _inertia_signals)


def _speed_change_forces(assembly: Assembly, names: dict[str, int], mass: np.ndarray) -> list[InterfaceForce]:
    forces = []
    listed = list(names)
    gyroscopic = _matrix(assembly.gyroscopic, names)
    # One force a row: a single force of n rows would have n x n coefficients, nearly all of them zero.
    for i in np.flatnonzero(gyroscopic.any(axis=1)):
        read = {listed[j]: float(gyroscopic[i, j]) for j in np.flatnonzero(gyroscopic[i])}
        name = f"gyroscopic change at {listed[i]}"
        forces.append(
            InterfaceForce(name, GYROSCOPIC_CHANGE, (assembly.speed_rad_s,), ({listed[i]: 1.0},), (), (read,))
        )
    if assembly.torsional:
        torque = mass @ _vector(assembly.torsional, names)
        acts = ({listed[i]: float(torque[i]) for i in np.flatnonzero(torque)},)
        forces.append(InterfaceForce("inertia torque", INERTIA_TORQUE, (1.0,), acts))
    return forces


def _matrix(entries: dict[tuple[str, str], float], names: dict[str, int]) -> np.ndarray:
    matrix = np.zeros(len(names) ** 2)
    try:
        places = list(map(_places(tuple(names)).__getitem__, entries))
    except KeyError:
        places = [_index(names, first) * len(names) + _index(names, second) for first, second in entries]
    matrix[places] = list(entries.values())
    return matrix.reshape(len(names), len(names))


@functools.lru_cache(maxsize=8)
def _places(names: tuple[str, ...]) -> dict[tuple[str, str], int]:
    """Return the place of each pair of degrees of freedom in a matrix, row by row."""
    return {pair: place for place, pair in enumerate(itertools.product(names, names))}


def _vector(direction: Direction, names: dict[str, int]) -> np.ndarray:
    vector = np.zeros(len(names))
    for name, value in direction.items():
        vector[_index(names, name)] += value
    return vector


def _positions(names: Sequence[str]) -> dict[str, int]:
    return {name: position for position, name in enumerate(names)}


def _index(names: dict[str, int], name: str) -> int:
    if name not in names:
        raise InvalidValueError(f"{name!r} is no degree of freedom; allowed: {', '.join(names)}. Correct the name.")
    return names[name]


def _padded(vector: np.ndarray, start: int, size: int) -> np.ndarray:
    row = np.zeros(size)
    row[start : start + vector.size] = vector
    return row
