"""What forces at multiples of a speed do to a machine's linear core.

In coordinates, M q'' + (D + w G) q' + K q - (controllers) = f. A force f exp(s t) moves them by q = Z(s)^-1 f with the
dynamic stiffness Z = s^2 M + s (D + w G) + K - sum over the controllers of out (c (s - A)^-1 b + d) in^T: half as many
unknowns as states, and controllers stay small.

A search asks for the same core again and again with other forces. Its whole inverse is then kept; a core that comes
once is only solved for the forces at hand.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..assembly import StateBlock
from ..pseudo_inverse import pseudo_inverse
from ..system import System

#: Cores that are remembered, and of these the ones whose inverses are kept (each up to 0.4 MB a speed).
REMEMBERED, KEPT = 64, 6
#: Speeds of one core whose inverses are kept.
MOST_SPEEDS = 32
#: Above this condition number a static response is computed without the motions that nothing holds.
UNHELD = 1e14


@dataclass(frozen=True)
class Spinning:
    """At which frequencies a lane (one speed) is wanted: 0 to ``count`` times ``base_rad_s``."""

    speed_rad_s: float
    base_rad_s: float
    count: int


@dataclass
class _Known:
    """What was found out about a core."""

    static: np.ndarray
    inverses: dict[Spinning, np.ndarray] = field(default_factory=dict)


_cores: OrderedDict[tuple[bytes, ...], _Known] = OrderedDict()


def forget() -> None:
    """Forget every core, as if none had been asked for."""
    _cores.clear()


def kept_inverses() -> int:
    """Return how many inverses, each of one core at one speed, are kept."""
    return sum(len(known.inverses) for known in _cores.values())


def responses(
    systems: Sequence[System], lanes: Sequence[Spinning], rows: np.ndarray, columns: np.ndarray
) -> np.ndarray:
    """Return rows Z^-1 columns at each frequency, shape (lanes, count + 1, rows, columns), complex.

    Parameters
    ----------
    systems : sequence of System
        Of each lane; the gyroscopic part is taken at the lane's speed, whatever the system's.
    lanes : sequence of Spinning
        All with the same count.
    rows : ndarray (rows, coordinates)
        Displacements to be read.
    columns : ndarray (coordinates, columns)
        Generalised forces.
    """
    found = np.empty((len(lanes), lanes[0].count + 1, rows.shape[0], columns.shape[1]), dtype=complex)
    keys = {id(system): _key(system) for system in {id(system): system for system in systems}.values()}
    of_key: dict[tuple[bytes, ...], list[int]] = {}
    for i, system in enumerate(systems):
        of_key.setdefault(keys[id(system)], []).append(i)
    for key, chosen in of_key.items():
        found[chosen] = _of_core(key, systems[chosen[0]], [lanes[i] for i in chosen], rows, columns)
    return found


def _of_core(
    key: tuple[bytes, ...], system: System, lanes: list[Spinning], rows: np.ndarray, columns: np.ndarray
) -> np.ndarray:
    known, is_new = _remembered(key, system)
    found = np.empty((len(lanes), lanes[0].count + 1, rows.shape[0], columns.shape[1]), dtype=complex)
    found[:, 0] = rows @ known.static @ columns
    used_rows, used_columns = np.flatnonzero(rows.any(axis=0)), np.flatnonzero(columns.any(axis=1))
    left, right = np.ascontiguousarray(rows[:, used_rows]), np.ascontiguousarray(columns[used_columns])
    if not is_new and len(known.inverses) + len(lanes) > MOST_SPEEDS:
        known.inverses.clear()
    # Metres and radians beside each other cost digits: over the square root of their mass all coordinates are alike.
    scale = 1 / np.sqrt(np.diag(system.mass_matrix))
    for i, lane in enumerate(lanes):
        if is_new:
            solution = np.linalg.solve(dynamic_stiffness(system, lane, scale), scale[None, :, None] * columns)
            found[i, 1:] = (left * scale[used_rows]) @ solution[:, used_rows]
            continue
        if lane not in known.inverses:
            inverse = np.linalg.inv(dynamic_stiffness(system, lane, scale))
            known.inverses[lane] = scale[:, None] * inverse * scale
        found[i, 1:] = left @ known.inverses[lane][:, used_rows[:, None], used_columns] @ right
    return found


def _key(system: System) -> tuple[bytes, ...]:
    n = len(system.coordinates)
    # Of the first-order core the columns of the velocities follow the speed; the others hold stiffness and controllers.
    matrices = (system.mass_matrix, system.damping_matrix, system.gyroscopic_matrix)
    return (*(own.tobytes() for own in matrices), system.core[:, :n].tobytes(), system.core[:, 2 * n :].tobytes())


def _remembered(key: tuple[bytes, ...], system: System) -> tuple[_Known, bool]:
    """Return what is known of a core, and whether it is asked for the first time."""
    is_new = key not in _cores
    if is_new:
        _cores[key] = _Known(_static_response(system))
    _cores.move_to_end(key)
    while len(_cores) > REMEMBERED:
        _cores.popitem(last=False)
    with_inverses = [own for own in _cores.values() if own.inverses]
    for own in with_inverses[:-KEPT]:
        own.inverses.clear()
    return _cores[key], is_new


def dynamic_stiffness(system: System, lane: Spinning, scale: np.ndarray) -> np.ndarray:
    """Return Z at 1 to ``count`` times the base frequency, shape (count, coordinates, coordinates).

    Rows and columns are multiplied by ``scale`` (coordinates,).
    """
    frequency = lane.base_rad_s * np.arange(1, lane.count + 1)
    found = np.empty((lane.count, *system.mass_matrix.shape), dtype=complex)
    both = np.multiply.outer(scale, scale)
    damping = both * (system.damping_matrix + lane.speed_rad_s * system.gyroscopic_matrix)
    found.real = both * system.stiffness_matrix - np.multiply.outer(frequency**2, both * system.mass_matrix)
    found.imag = np.multiply.outer(frequency, damping)
    transfers: dict[tuple[bytes, ...], np.ndarray] = {}
    places = {name: i for i, name in enumerate(system.coordinates)}
    for block in system.state_blocks:
        key = (block.a.tobytes(), block.b.tobytes(), block.c.tobytes())
        if key not in transfers:
            transfers[key] = _transfer(block, 1j * frequency)
        gain = transfers[key] + block.d
        for output, push in block.output.items():
            for read, seen in block.input.items():
                i, j = places[output], places[read]
                found[:, i, j] -= both[i, j] * push * seen * gain
    return found


def _transfer(block: StateBlock, frequency: np.ndarray) -> np.ndarray:
    """Return c (s - A)^-1 b at each frequency."""
    pencil = frequency[:, None, None] * np.eye(block.a.shape[0]) - block.a
    return np.linalg.solve(pencil, np.broadcast_to(block.b[:, None], (*pencil.shape[:-1], 1)))[..., 0] @ block.c


def _static_response(system: System) -> np.ndarray:
    """Return the displacements of unit constant forces, (coordinates, coordinates), without unheld motions.

    The speed does not matter: nothing moves. Controllers take part with their states, since an integrator holds its
    place with any force.
    """
    from scipy.linalg import matrix_balance

    n, size = len(system.coordinates), system.states
    held = np.r_[0:n, 2 * n : size]
    core = np.ascontiguousarray(system.core[np.ix_(np.r_[n : 2 * n, 2 * n : size], held)])
    # Balanced first: states in m, rad and V differ so much in size that the cut for "nothing holds" would hit others.
    balanced, (scale, _) = matrix_balance(-core, permute=False, separate=True)
    push = np.zeros((held.size, n))
    push[:n] = np.linalg.inv(system.mass_matrix)
    push /= scale[:, None]
    try:
        inverse = np.linalg.inv(balanced)
        is_held = np.linalg.norm(inverse, 1) * np.linalg.norm(balanced, 1) < UNHELD
    except np.linalg.LinAlgError:
        is_held = False
    if not is_held:
        inverse = pseudo_inverse(balanced, rcond=1 / UNHELD)
    found = inverse @ push
    for _ in range(2):
        found += inverse @ (push - balanced @ found)
    return (found * scale[:, None])[:n]
