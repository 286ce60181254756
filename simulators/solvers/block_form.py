"""The linear core in coordinates where it is block diagonal, so that a step costs little.

In modal coordinates e^(hL) has one or two entries a row instead of as many as there are states. The change of
coordinates is used only while its condition number leaves the answer accurate; otherwise the core stays as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..system import System

#: Above this condition number of the modal basis rounding would show; the core is then used as it is.
WORST_CONDITION = 1e9


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
    """

    core: np.ndarray
    force_columns: np.ndarray
    motion_rows: np.ndarray
    probe_rows: np.ndarray
    basis: np.ndarray
    inverse: np.ndarray
    first: np.ndarray
    last: np.ndarray

    @property
    def is_blocks(self) -> bool:
        """Whether every block has one or two rows."""
        return bool(np.all(self.last - self.first <= 2))

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
    )
    if not modal:
        return whole
    eigen = np.linalg.eig(system.core)
    values, vectors = eigen.eigenvalues.astype(complex), eigen.eigenvectors.astype(complex)
    # One column for a real eigenvalue, real and imaginary part for a conjugate pair.
    keep = np.imag(values) >= 0
    if highest_hz is not None:
        keep &= np.abs(values) <= 2 * np.pi * highest_hz
    columns, first, last = [], [], []
    for value, vector in zip(values[keep], vectors.T[keep], strict=True):
        at = len(columns)
        parts = [vector.real, vector.imag] if value.imag > 0 else [vector.real]
        columns += [part / np.linalg.norm(vector) for part in parts]
        first += [at] * len(parts)
        last += [at + len(parts)] * len(parts)
    basis = np.array(columns).T
    # Displacements and velocities differ by orders of magnitude; only with rows of equal size it is meaningful.
    scale = np.abs(basis).max(axis=1, keepdims=True)
    if not np.all(scale > 0) or np.linalg.cond(basis / scale) > WORST_CONDITION:
        return whole
    inverse = _inverse(values[keep], vectors, keep)
    core = inverse @ system.core @ basis
    form = BlockForm(
        core=core,
        force_columns=inverse @ system.force_columns,
        motion_rows=system.motion_rows @ basis,
        probe_rows=system.probe_rows @ basis,
        basis=basis,
        inverse=inverse,
        first=np.array(first, dtype=np.int64),
        last=np.array(last, dtype=np.int64),
    )
    core[~form.pattern] = 0.0
    return form


def _inverse(kept: np.ndarray, vectors: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """Return the rows of the modal basis' inverse: left eigenvectors, right also when modes are left out."""
    left = np.linalg.inv(vectors)[keep]
    rows = []
    for value, row, vector in zip(kept, left, vectors.T[keep], strict=True):
        size = np.linalg.norm(vector)
        rows += [2 * row.real * size, -2 * row.imag * size] if value.imag > 0 else [row.real * size]
    return np.array(rows)
