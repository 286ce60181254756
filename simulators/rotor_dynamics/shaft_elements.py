"""Lateral vibration of a shaft with discs: mass, gyroscopic and stiffness matrices of Timoshenko finite elements.

Each node has four degrees of freedom in the order x, y, angle_x, angle_y; z runs along the shaft, right-handed, so
that angle_y = +dx/dz and angle_x = -dy/dz when shear is neglected. The equation of motion at the shaft speed
``speed_rad_s`` (positive from x to y) is

    mass q'' + (damping + speed_rad_s gyroscopic) q' + stiffness q = force.

Reference: H. D. Nelson, "A finite rotating shaft element using Timoshenko beam theory", J. Mech. Design 102 (1980)
793-803 (consistent matrices).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InvalidValueError
from .shaft_parts import Disc, Material, ShaftElement

#: Degrees of freedom of a node, in their order.
COORDINATES = ("x", "y", "angle_x", "angle_y")

# Rows of an element in the plane x-z and in the plane y-z; the slope dy/dz is minus angle_x.
_PLANE_X = np.array([0, 3, 4, 7])
_PLANE_Y = np.array([1, 2, 5, 6])
_SIGN_Y = np.array([1.0, -1.0, 1.0, -1.0])


@dataclass(frozen=True, eq=False)
class RotorMatrices:
    """Matrices of a free rotor, shape (4 nodes, 4 nodes), read-only, SI units.

    Attributes
    ----------
    mass, stiffness : numpy.ndarray
        Symmetric; ``stiffness`` has four rigid-body motions of no energy until supports are added.
    gyroscopic : numpy.ndarray
        Skew-symmetric; multiply by the speed in rad/s and by the velocities.
    positions_m : numpy.ndarray
        Position of each node along the shaft, shape (nodes,), the first at 0.
    """

    mass: np.ndarray
    gyroscopic: np.ndarray
    stiffness: np.ndarray
    positions_m: np.ndarray

    def index(self, node: int, coordinate: str) -> int:
        """Return the row of one degree of freedom; ``coordinate`` is x, y, angle_x or angle_y."""
        nodes = len(self.positions_m)
        require_node(node, nodes)
        if coordinate not in COORDINATES:
            raise InvalidValueError(f"Coordinate {coordinate!r}; allowed: {', '.join(COORDINATES)}. Choose one.")
        return 4 * node + COORDINATES.index(coordinate)


def assemble_rotor(
    elements: Sequence[ShaftElement], *, material: Material, discs: Sequence[Disc] = ()
) -> RotorMatrices:
    """Return the matrices of a shaft made of ``elements`` from left to right, with rigid discs on it.

    The section rotates and shears (Timoshenko) and has rotary inertia. The element is exact under end loads. Its
    natural frequencies omega are too high by about (k h)^4 / 1440 from bending, k being the wave number and h the
    element length, plus at most rho omega^2 h^2 / (24 kappa G) from shear: fourth order for slender, second
    for thick shafts. Bending and torsion are not coupled.

    Parameters
    ----------
    elements : sequence of ShaftElement
        At least one; element k lies between the nodes k and k + 1.
    material : Material
        Of the whole shaft.
    discs : sequence of Disc
        Any number, several at one node add up.

    Raises
    ------
    InvalidValueError
        Without elements, or with a disc outside the shaft.
    """
    nodes = node_count(elements)
    mass, gyroscopic, stiffness = (np.zeros((4 * nodes, 4 * nodes)) for _ in range(3))
    for number, element in enumerate(elements):
        rows = slice(4 * number, 4 * number + 8)
        translation, rotary, bending = plane_matrices(element, material)
        mass[rows, rows] += _both_planes(translation + rotary)
        gyroscopic[rows, rows] += _gyroscopic_element(rotary)
        stiffness[rows, rows] += _both_planes(bending)
    for disc in discs:
        require_node(disc.node, nodes)
        x, y, angle_x, angle_y = range(4 * disc.node, 4 * disc.node + 4)
        mass[[x, y], [x, y]] += disc.mass_kg
        mass[[angle_x, angle_y], [angle_x, angle_y]] += disc.diametral_inertia_kg_m2
        gyroscopic[angle_x, angle_y] += disc.polar_inertia_kg_m2
        gyroscopic[angle_y, angle_x] -= disc.polar_inertia_kg_m2
    return RotorMatrices(*map(read_only, (mass, gyroscopic, stiffness, node_positions_m(elements))))


def plane_matrices(element: ShaftElement, material: Material) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return translational mass, rotary inertia and stiffness of one element in one plane, each of shape (4, 4).

    Coordinates: deflection and section rotation (in the sense of the slope) at the left, then at the right end. The
    shear parameter is phi = 12 E I / (kappa G A L^2); source: Nelson 1980.
    """
    length = element.length_m
    modulus, moment = material.youngs_modulus_pa, element.second_moment_m4
    shear_area = element.shear_coefficient(material.poisson_ratio) * element.area_m2
    phi = 12 * modulus * moment / (material.shear_modulus_pa * shear_area * length**2)
    scale = np.outer(np.array([1, length, 1, length]), np.array([1, length, 1, length]))
    bending = np.array([[12, 6, -12, 6], [6, 4 + phi, -6, 2 - phi], [-12, -6, 12, -6], [6, 2 - phi, -6, 4 + phi]])
    near, far = 13 / 35 + 7 * phi / 10 + phi**2 / 3, 9 / 70 + 3 * phi / 10 + phi**2 / 6
    near_turn = 11 / 210 + 11 * phi / 120 + phi**2 / 24
    far_turn = 13 / 420 + 3 * phi / 40 + phi**2 / 24
    turn, cross = 1 / 105 + phi / 60 + phi**2 / 120, 1 / 140 + phi / 60 + phi**2 / 120
    translation = np.array(
        [
            [near, near_turn, far, -far_turn],
            [near_turn, turn, far_turn, -cross],
            [far, far_turn, near, -near_turn],
            [-far_turn, -cross, -near_turn, turn],
        ]
    )
    slope = 1 / 10 - phi / 2
    same, other = 2 / 15 + phi / 6 + phi**2 / 3, -1 / 30 - phi / 6 + phi**2 / 6
    rotary = np.array(
        [
            [1.2, slope, -1.2, slope],
            [slope, same, -slope, other],
            [-1.2, -slope, 1.2, -slope],
            [slope, other, -slope, same],
        ]
    )
    density = material.density_kg_m3
    return (
        translation * scale * (density * element.area_m2 * length / (1 + phi) ** 2),
        rotary * scale * (density * moment / length / (1 + phi) ** 2),
        bending * scale * (modulus * moment / length**3 / (1 + phi)),
    )


def _both_planes(matrix: np.ndarray) -> np.ndarray:
    """Place the matrix of one plane into both planes of an element, shape (8, 8)."""
    full = np.zeros((8, 8))
    full[np.ix_(_PLANE_X, _PLANE_X)] = matrix
    full[np.ix_(_PLANE_Y, _PLANE_Y)] = matrix * np.outer(_SIGN_Y, _SIGN_Y)
    return full


def _gyroscopic_element(rotary: np.ndarray) -> np.ndarray:
    """Couple the slopes of both planes: with polar = 2 x diametral inertia the coupling is twice ``rotary``."""
    full = np.zeros((8, 8))
    full[np.ix_(_PLANE_X, _PLANE_Y)] = 2 * rotary * _SIGN_Y
    return full - full.T


def node_count(elements: Sequence[ShaftElement]) -> int:
    """Return the number of nodes of a shaft, one more than its elements; refuses an empty shaft."""
    if not elements:
        raise InvalidValueError("The shaft has 0 elements; allowed: at least 1. Give a list of ShaftElement.")
    return len(elements) + 1


def node_positions_m(elements: Sequence[ShaftElement]) -> np.ndarray:
    """Return the position of each node along the shaft in metres, shape (nodes,), the first at 0."""
    return np.concatenate([[0.0], np.cumsum([element.length_m for element in elements])])


def require_node(node: int, nodes: int) -> None:
    """Refuse a node number outside 0 to nodes - 1."""
    if not 0 <= node < nodes:
        raise InvalidValueError(f"Node {node}; allowed: 0 to {nodes - 1}. The shaft has {nodes} nodes.")


def read_only(array: np.ndarray) -> np.ndarray:
    """Return the array itself, locked against writing."""
    array.setflags(write=False)
    return array
