"""The linear core in coordinates where it is block diagonal, so that a step costs little.

In modal coordinates e^(hL) has one or two entries a row instead of as many as there are states. The change of
coordinates is used only while its condition number leaves the answer accurate; otherwise the core stays as it is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..system import System
from .low_modes import Modes, low_modes

#: Above this condition number of the modal basis rounding would show; the core is then used as it is.
WORST_CONDITION = 1e9
#: Parts of fewer coordinates are not worth a reduction.
FEW = 24


@dataclass(frozen=True)
class BlockForm:
    """A system in new coordinates w with y = basis w.

    Attributes
    ----------
    core, force_columns, motion_rows, probe_rows : ndarray
        As in `System`, in the new coordinates.
    basis, inverse : ndarray (states, new states), (new states, states)
    first, last : ndarray of int
        Row i of the core, and of its exponential, is zero outside columns first[i] to last[i] - 1.
    is_blocks : bool
        Whether every block is one number or [[a, b], [-b, a]].
    """

    core: np.ndarray
    force_columns: np.ndarray
    motion_rows: np.ndarray
    probe_rows: np.ndarray
    basis: np.ndarray
    inverse: np.ndarray
    first: np.ndarray
    last: np.ndarray
    is_blocks: bool

    @property
    def pattern(self) -> np.ndarray:
        """Where the core may differ from zero."""
        column = np.arange(self.core.shape[0])
        return (column >= self.first[:, None]) & (column < self.last[:, None])


def block_form(system: System, *, modal: bool = True, highest_hz: float | None = None) -> BlockForm:
    """Return a system in block form.

    Parameters
    ----------
    system : System
    modal : bool
        False keeps the coordinates.
    highest_hz : float, optional
        Leave out the modes above this natural frequency: for large finite-element models.
    """
    n = system.states
    whole = BlockForm(
        core=system.core,
        force_columns=system.force_columns,
        motion_rows=system.motion_rows,
        probe_rows=system.probe_rows,
        basis=np.eye(n),
        inverse=np.eye(n),
        first=np.zeros(n, dtype=np.int64),
        last=np.full(n, n, dtype=np.int64),
        is_blocks=False,
    )
    if not modal:
        return whole
    columns, rows, first, last, blocks = [], [], [], [], []
    for modes in _all_modes(system, highest_hz):
        if modes is None:
            return whole
        for value, vector, row in zip(modes.values, modes.vectors.T, modes.left, strict=True):
            at, size, pair = len(columns), np.linalg.norm(vector), value.imag > 0
            own_columns = (vector.real, vector.imag) if pair else (vector.real,)
            columns += [_spread(own / size, modes.part, n) for own in own_columns]
            own_rows = (2 * row.real * size, -2 * row.imag * size) if pair else (row.real * size,)
            rows += [_spread(own, modes.part, n) for own in own_rows]
            first += [at] * len(own_rows)
            last += [at + len(own_rows)] * len(own_rows)
            blocks.append((at, value))
    if not columns:
        return whole
    basis = np.array(columns).T
    # Displacements and velocities differ by orders of magnitude; only with rows of equal size it is meaningful.
    scale = np.abs(basis).max(axis=1, keepdims=True)
    if np.linalg.cond(basis / np.where(scale > 0, scale, 1.0)) > WORST_CONDITION:
        return whole
    inverse = np.array(rows)
    return BlockForm(
        core=_block_core(blocks, len(columns)),
        force_columns=inverse @ system.force_columns,
        motion_rows=system.motion_rows @ basis,
        probe_rows=system.probe_rows @ basis,
        basis=basis,
        inverse=inverse,
        first=np.array(first, dtype=np.int64),
        last=np.array(last, dtype=np.int64),
        is_blocks=True,
    )


def _all_modes(system: System, highest_hz: float | None) -> Iterator[Modes | None]:
    """Give the modes of each group of states that the others do not touch, None where they are dependent."""
    if highest_hz is not None and not system.state_blocks:
        own = (system.mass_matrix, system.damping_matrix, system.gyroscopic_matrix, system.stiffness_matrix)
        parts = separate_parts(np.abs(own).sum(axis=0))
        found = [low_modes(system, part, highest_hz) for part in parts if part.size >= FEW]
        if len(found) == len(parts) and all(found):
            yield from found
            return
    for part in separate_parts(system.core):
        eigen = np.linalg.eig(system.core[np.ix_(part, part)])
        values, vectors = eigen.eigenvalues.astype(complex), eigen.eigenvectors.astype(complex)
        left = _left_vectors(vectors)
        if left is None:
            yield None
            return
        # One column for a real eigenvalue, real and imaginary part for a conjugate pair.
        keep = np.imag(values) >= 0
        if highest_hz is not None:
            keep &= np.abs(values) <= 2 * np.pi * highest_hz
        yield Modes(part, values[keep], vectors[:, keep], left[keep])


def separate_parts(core: np.ndarray) -> list[np.ndarray]:
    """Return groups of states that do not act on each other: eigenvalues of each by itself cost far less."""
    linked = (core != 0) | (core.T != 0)
    left = np.ones(core.shape[0], dtype=bool)
    parts = []
    while left.any():
        reached = np.zeros(left.size, dtype=bool)
        fresh = np.flatnonzero(left)[:1]
        while fresh.size:
            reached[fresh] = True
            fresh = np.flatnonzero(linked[fresh].any(axis=0) & ~reached)
        left &= ~reached
        parts.append(np.flatnonzero(reached))
    return parts


def _left_vectors(vectors: np.ndarray) -> np.ndarray | None:
    """Return the inverse of the eigenvectors, or None where they are dependent."""
    try:
        return np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return None


def _spread(values: np.ndarray, part: np.ndarray, size: int) -> np.ndarray:
    whole = np.zeros(size)
    whole[part] = values
    return whole


def _block_core(blocks: list[tuple[int, complex]], size: int) -> np.ndarray:
    """Return the core in modal coordinates: [[a, b], [-b, a]] for a pair a + i b."""
    core = np.zeros((size, size))
    for at, value in blocks:
        core[at, at] = value.real
        if value.imag > 0:
            core[at + 1, at + 1] = value.real
            core[at, at + 1], core[at + 1, at] = value.imag, -value.imag
    return core
