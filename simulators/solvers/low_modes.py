"""The modes below a frequency, without those above: for large finite-element models.

All eigenvalues of 272 coupled bending states cost four times as much as a run of a second. Here a symmetric problem
gives the motions from which the modes below are made, damping and gyroscopic moments bring in what the motions above
answer to them at rest, and the eigenvalues of the small system that is left are those of the large one to ten digits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..system import System

#: Motions are taken from so much above the highest frequency.
FURTHER = 3.0
#: Static motions are taken at this share of it, so that a free body has them too.
SHIFT = 0.1
#: Largest share of a mode that may be missing. What is missing is added so many times; then all eigenvalues are
#: computed.
LARGEST_RESIDUAL, MOST_ROUNDS = 1e-5, 3
#: A static motion of which less is its own is left out.
SMALLEST = 1e-8


@dataclass(frozen=True)
class Modes:
    """Modes of some states of a core.

    Attributes
    ----------
    part : ndarray of int
        The states.
    values : ndarray (modes,), complex
        Eigenvalues, of a conjugate pair the one with positive imaginary part.
    vectors : ndarray (states of the part, modes), complex
    left : ndarray (modes, states of the part), complex
        Rows with left @ vectors = 1.
    """

    part: np.ndarray
    values: np.ndarray
    vectors: np.ndarray
    left: np.ndarray


def low_modes(system: System, coordinates: np.ndarray, highest_hz: float) -> Modes | None:
    """Return the modes up to a frequency of coordinates that are linked to no others, None where they are inaccurate.

    With Phi the motions of M and the symmetric part of K up to `FURTHER` times the frequency and Psi the static motions
    under their damping forces, q = [Phi, Psi] a (Rayleigh, Ritz and Galerkin). What a mode lacks is the static motion
    under the forces that are left of its equation; it joins Psi where it is too large.
    """
    from scipy.linalg import eigh, lu_factor, lu_solve

    own = np.ix_(coordinates, coordinates)
    mass, stiffness = system.mass_matrix[own], system.stiffness_matrix[own]
    damping = (system.damping_matrix + system.speed_rad_s * system.gyroscopic_matrix)[own]
    highest = 2 * np.pi * highest_hz
    try:
        squares, motions = eigh(
            (stiffness + stiffness.T) / 2, mass, subset_by_value=(-np.inf, (FURTHER * highest) ** 2)
        )
    except np.linalg.LinAlgError:
        return None
    if motions.shape[1] > coordinates.size // 2:
        return None
    factors = lu_factor(stiffness + (SHIFT * highest) ** 2 * mass)
    basis = _with_static(motions, lu_solve(factors, damping @ motions[:, squares <= highest**2]), mass)
    for _ in range(MOST_ROUNDS):
        try:
            values, shapes, rates, left = _galerkin(basis, mass, damping, stiffness, highest)
        except np.linalg.LinAlgError:
            return None
        lacking = lu_solve(factors, mass @ shapes * values**2 + damping @ shapes * values + stiffness @ shapes)
        large = np.linalg.norm(lacking, axis=0) > LARGEST_RESIDUAL * np.linalg.norm(shapes, axis=0)
        if not large.any():
            n = len(system.coordinates)
            return Modes(np.concatenate([coordinates, n + coordinates]), values, np.concatenate([shapes, rates]), left)
        basis = _with_static(basis, np.concatenate([lacking[:, large].real, lacking[:, large].imag], axis=1), mass)
    return None


def _galerkin(
    basis: np.ndarray, mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, highest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return eigenvalues up to ``highest`` of q = basis a, displacements and velocities of the modes, left rows."""
    size = basis.shape[1]
    reduced = np.zeros((2 * size, 2 * size))
    reduced[:size, size:] = np.eye(size)
    reduced[size:, :size], reduced[size:, size:] = -basis.T @ stiffness @ basis, -basis.T @ damping @ basis
    values, vectors = (part.astype(complex) for part in np.linalg.eig(reduced))
    left = np.linalg.inv(vectors)
    keep = (np.imag(values) >= 0) & (np.abs(values) <= highest)
    values, vectors, left, back = values[keep], vectors[:, keep], left[keep], basis.T @ mass
    rows = np.concatenate([left[:, :size] @ back, left[:, size:] @ back], axis=1)
    return values, basis @ vectors[:size], basis @ vectors[size:], rows


def _with_static(motions: np.ndarray, static: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Return motions and static motions together, of unit mass each and none moved by another."""
    whole = _size(static, mass)
    # Twice: of a static motion that is nearly one of the others, the first time leaves little but rounding.
    for _ in range(2):
        static = static - motions @ (motions.T @ (mass @ static))
    own = _size(static, mass)
    static = static[:, own > SMALLEST * whole] / own[own > SMALLEST * whole]
    # Those of neighbouring modes resemble each other.
    squares, turned = np.linalg.eigh(static.T @ (mass @ static))
    distinct = squares > SMALLEST
    static = static @ (turned[:, distinct] / np.sqrt(squares[distinct]))
    static = static - motions @ (motions.T @ (mass @ static))
    return np.concatenate([motions, static], axis=1)


def _size(motions: np.ndarray, mass: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("ij,ij->j", motions, mass @ motions))
