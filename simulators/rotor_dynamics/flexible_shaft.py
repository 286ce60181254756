"""A flexible shaft with discs in an assembly: bending by finite elements, torsion, and rigid motion along its axis."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence

import numpy as np

from ..assembly import Assembly
from .shaft_elements import COORDINATES, assemble_rotor, node_count
from .shaft_parts import Disc, Material, ShaftElement
from .shaft_torsion import assemble_torsion


def bending_at(name: str, node: int) -> dict[str, dict[str, float]]:
    """Return the motion of a node in "x", "y", "angle_x" and "angle_y"."""
    return {coordinate: {f"{name}_{node}.{coordinate}": 1.0} for coordinate in COORDINATES}


def add_bending(
    assembly: Assembly,
    name: str,
    *,
    elements: Sequence[ShaftElement],
    discs: Sequence[Disc],
    material: Material,
    damping_ratio: float,
) -> None:
    """Add a shaft's bending; its coordinates are "<name>_<node>.x", ".y", ".angle_x", ".angle_y".

    Parameters
    ----------
    assembly : Assembly
    name : str
    elements, discs, material
        As for `assemble_rotor`.
    damping_ratio : float
        Of every elastic mode of the free shaft, damping that stands still.
    """
    names = [f"{name}_{node}.{coordinate}" for node in range(node_count(elements)) for coordinate in COORDINATES]
    for coordinate in names:
        assembly.add_coordinate(coordinate, vertical=coordinate.endswith(".y"))
    for kind, matrix in _bending(tuple(elements), tuple(discs), material, damping_ratio).items():
        assembly.add_matrix(kind, names, matrix)


def add_torsion(
    assembly: Assembly,
    names: Sequence[str],
    *,
    lengths_m: Sequence[float],
    diameter_m: float,
    discs: Sequence[Disc],
    material: Material,
    damping_ratio: float,
    shaft_ratio: float = 1.0,
) -> None:
    """Add a shaft's torsion; its coordinates are "<name>.torsion" for each of ``names``, one node each.

    Torsion needs fewer nodes than bending, so it has elements of its own.

    Parameters
    ----------
    assembly : Assembly
    names : sequence of str
        One more than lengths.
    lengths_m : sequence of float
        Of the shaft between the nodes.
    diameter_m : float
    discs : sequence of Disc
        Their node numbers count ``names``.
    material : Material
    damping_ratio : float
        Of every elastic mode of the free shaft.
    shaft_ratio : float
        Speed over the reference shaft's.
    """
    bars = tuple(ShaftElement(length, diameter_m) for length in lengths_m)
    twists = [f"{name}.torsion" for name in names]
    for twist in twists:
        assembly.add_coordinate(twist, torsion_ratio=shaft_ratio)
    for kind, matrix in _torsion(bars, tuple(discs), material, damping_ratio).items():
        assembly.add_matrix(kind, twists, matrix)


def total_mass_kg(elements: Sequence[ShaftElement], discs: Sequence[Disc], material: Material) -> float:
    """Return the mass of a shaft with its discs."""
    shaft = sum(material.density_kg_m3 * element.area_m2 * element.length_m for element in elements)
    return shaft + sum(disc.mass_kg for disc in discs)


# Scans of other parameters ask for the same matrices again.
@functools.lru_cache(maxsize=64)
def _bending(
    elements: tuple[ShaftElement, ...], discs: tuple[Disc, ...], material: Material, damping_ratio: float
) -> Mapping[str, np.ndarray]:
    from .shaft_damping import modal_damping

    rotor = assemble_rotor(elements, material=material, discs=discs)
    damping = modal_damping(rotor.mass, rotor.stiffness, ratios=damping_ratio)
    return {"mass": rotor.mass, "damping": damping, "gyroscopic": rotor.gyroscopic, "stiffness": rotor.stiffness}


@functools.lru_cache(maxsize=64)
def _torsion(
    bars: tuple[ShaftElement, ...], discs: tuple[Disc, ...], material: Material, damping_ratio: float
) -> Mapping[str, np.ndarray]:
    from .shaft_damping import modal_damping

    torsion = assemble_torsion(bars, material=material, discs=discs)
    damping = modal_damping(torsion.inertia, torsion.stiffness, ratios=damping_ratio)
    return {"mass": torsion.inertia, "damping": damping, "stiffness": torsion.stiffness}
