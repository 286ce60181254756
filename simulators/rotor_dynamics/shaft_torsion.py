"""Torsional vibration of a shaft with discs: inertia and stiffness matrices, one rotation a node.

The equation of motion is inertia q'' + stiffness q = torque, q being the twist in rad at each node. Elements carry
consistent inertia, J_p = 2 I rho L: J_p / 6 [[2, 1], [1, 2]], and stiffness G 2 I / L [[1, -1], [-1, 1]]
(any textbook, e.g. M. I. Friswell et al., "Dynamics of Rotating Machines", Cambridge 2010, section 9.9).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .shaft_elements import node_count, node_positions_m, read_only, require_node
from .shaft_parts import Disc, Material, ShaftElement


@dataclass(frozen=True, eq=False)
class TorsionMatrices:
    """Matrices of a shaft free to turn, read-only, SI units.

    Attributes
    ----------
    inertia, stiffness : numpy.ndarray
        In kg m2 and N m/rad, symmetric, shape (nodes, nodes); turning as a whole has no strain energy.
    positions_m : numpy.ndarray
        Position of each node along the shaft, shape (nodes,), the first at 0.
    """

    inertia: np.ndarray
    stiffness: np.ndarray
    positions_m: np.ndarray


def assemble_torsion(
    elements: Sequence[ShaftElement], *, material: Material, discs: Sequence[Disc] = ()
) -> TorsionMatrices:
    """Return the torsional matrices of a shaft made of ``elements`` from left to right, with discs on it.

    Natural frequencies converge with the square of the element length.

    Parameters
    ----------
    elements, material, discs
        As for ``assemble_rotor``; of a disc only the polar inertia counts.

    Raises
    ------
    InvalidValueError
        Without elements, or with a disc outside the shaft.

    Examples
    --------
    >>> steel = Material(2.1e11, 7850, 0.3)
    >>> matrices = assemble_torsion([ShaftElement(0.5, 0.02)], material=steel)
    >>> round(matrices.stiffness[0, 0])
    2537
    """
    nodes = node_count(elements)
    inertia, stiffness = np.zeros((nodes, nodes)), np.zeros((nodes, nodes))
    for number, element in enumerate(elements):
        rows = slice(number, number + 2)
        polar = 2 * element.second_moment_m4
        inertia[rows, rows] += material.density_kg_m3 * polar * element.length_m / 6 * np.array([[2, 1], [1, 2]])
        stiffness[rows, rows] += material.shear_modulus_pa * polar / element.length_m * np.array([[1, -1], [-1, 1]])
    for disc in discs:
        require_node(disc.node, nodes)
        inertia[disc.node, disc.node] += disc.polar_inertia_kg_m2
    return TorsionMatrices(*map(read_only, (inertia, stiffness, node_positions_m(elements))))
