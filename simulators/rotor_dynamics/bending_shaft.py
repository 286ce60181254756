"""The shaft of a finite-element machine as a component: where a bow, unequal stiffness or a crack can sit."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np

from ..assembly import combination
from ..errors import InvalidValueError
from ..law import Direction
from .shaft_elements import node_count, node_positions_m, plane_matrices
from .shaft_flaws import BendingMoment, Deflection, FlawedShaft
from .shaft_parts import Material, ShaftElement


@functools.lru_cache(maxsize=16)
def _plane_stiffness(elements: tuple[ShaftElement, ...], material: Material) -> np.ndarray:
    """Return the stiffness in one plane; not to be written to. Machines are built thousands of times in a search."""
    size = 2 * len(elements) + 2
    matrix = np.zeros((size, size))
    for number, element in enumerate(elements):
        rows = slice(2 * number, 2 * number + 4)
        matrix[rows, rows] += plane_matrices(element, material)[2]
    matrix.setflags(write=False)
    return matrix


class BendingShaft(FlawedShaft):
    """A shaft of Timoshenko elements on two bearings whose matrices are in the machine already.

    Parameters
    ----------
    name : str
    prefix : str
        Its coordinates are "<prefix>_<node>.x", ".y", ".angle_x", ".angle_y".
    elements : sequence of ShaftElement
    material : Material
    bearing_nodes : tuple of int
        The first and the second bearing.
    shaft_ratio : float
        Speed over the reference shaft's.
    """

    def __init__(
        self,
        name: str,
        *,
        prefix: str,
        elements: Sequence[ShaftElement],
        material: Material,
        bearing_nodes: tuple[int, int],
        shaft_ratio: float = 1.0,
    ) -> None:
        super().__init__(name, shaft_ratio=shaft_ratio, material=material)
        self._prefix, self._elements = prefix, tuple(elements)
        self._nodes, self._bearings = node_positions_m(elements), bearing_nodes
        if not 0 <= bearing_nodes[0] < bearing_nodes[1] < node_count(elements):
            raise InvalidValueError(
                f"Shaft {name} with bearings at the nodes {bearing_nodes}; allowed: two nodes from 0 to "
                f"{len(elements)}, the smaller one first."
            )

    def deflection(self, position: float) -> Deflection:
        """Return the deflection at ``position`` relative to the line through the bearings."""
        row = self._shape_at(position)
        for node, share in zip(self._bearings, (1 - position, position), strict=True):
            row[2 * node] -= share
        free = np.setdiff1d(np.arange(row.size), [2 * node for node in self._bearings])
        stiffness = _plane_stiffness(self._elements, self.material)[np.ix_(free, free)]
        yields = float(row[free] @ np.linalg.solve(stiffness, row[free]))
        return Deflection(1 / yields, *self._planes(row))

    def bend(self, position: float, evenness: float) -> tuple[Direction, Direction]:
        """Return the forces in x and in y that bend the shaft by 1 m; see `FlawedShaft.bend`."""
        load, share = super().bend(position, evenness), abs(evenness)
        other = self._kinked(position) if evenness < 0 else self._planes(self._even_curvature())
        x, y = (combination((1 - share, one), (share, two)) for one, two in zip(load, other, strict=True))
        return x, y

    def _kinked(self, position: float) -> tuple[Direction, Direction]:
        """Return the forces of a sharp bend, 1 m deep: both parts straight, each to its bearing and beyond.

        A kink that the shaft has by itself, not by a moment, acts as its angle times what the moment there reads.
        """
        first, last = self._bearings
        angle = -1 / (position * (1 - position) * (self._nodes[last] - self._nodes[first]))
        moment = self.bending_moment(position)
        return combination((angle, moment.x)), combination((angle, moment.y))

    def _even_curvature(self) -> np.ndarray:
        """Return forces and moments of all nodes for one curvature between the bearings, 1 m deep in the middle."""
        first, last = self._bearings
        curvature = -8 / (self._nodes[last] - self._nodes[first]) ** 2
        row = np.zeros(2 * self._nodes.size)
        for number in range(first, last):
            # Each element's ends feel the moments that would hold it in this shape: the virtual work of E I u''.
            moment = self.material.youngs_modulus_pa * self._elements[number].second_moment_m4 * curvature
            row[2 * number + 1] -= moment
            row[2 * number + 3] += moment
        return row

    def bending_moment(self, position: float) -> BendingMoment:
        """Return the bending moment at ``position``: linear within its element, V z - M_left."""
        element, distance = self._element_at(position)
        part = self._elements[element]
        stiffness = plane_matrices(part, self.material)[2]
        arm = np.array([distance, -1.0])
        row = np.zeros(2 * self._nodes.size)
        row[2 * element : 2 * element + 4] = arm @ stiffness[:2]
        return BendingMoment(float(arm @ stiffness[:2, :2] @ arm), *self._planes(row), part.outer_diameter_m)

    def _element_at(self, position: float) -> tuple[int, float]:
        """Return the element that holds ``position`` and the distance from its left end."""
        if not 0.0 < position < 1.0:
            raise InvalidValueError(f"Position {position:g} of shaft {self.name}; allowed: between 0 and 1.")
        left, right = (self._nodes[node] for node in self._bearings)
        z = left + position * (right - left)
        element = int(np.searchsorted(self._nodes, z, side="right")) - 1
        return element, float(z - self._nodes[element])

    def _shape_at(self, position: float) -> np.ndarray:
        """Return the row that reads the displacement at ``position`` from displacement and slope of all nodes."""
        element, distance = self._element_at(position)
        length = self._elements[element].length_m
        s = distance / length
        row = np.zeros(2 * self._nodes.size)
        row[2 * element : 2 * element + 4] = (
            1 - 3 * s**2 + 2 * s**3,
            length * s * (1 - s) ** 2,
            s**2 * (3 - 2 * s),
            length * s**2 * (s - 1),
        )
        return row

    def _planes(self, row: np.ndarray) -> tuple[Direction, Direction]:
        """Return a row over displacement and slope of each node as directions in x and in y (slope = -angle_x)."""
        x: dict[str, float] = {}
        y: dict[str, float] = {}
        for index in np.flatnonzero(row):
            node, is_slope = divmod(int(index), 2)
            value = float(row[index])
            x[f"{self._prefix}_{node}.{'angle_y' if is_slope else 'x'}"] = value
            y[f"{self._prefix}_{node}.{'angle_x' if is_slope else 'y'}"] = -value if is_slope else value
        return x, y
