"""Rigid base plate on four soft mounts: six degrees of freedom, carrying everything that stands on it.

A point r = (x, y, z) from the plate's mass centre moves by t + theta x r (small angles):

    x: t_x + theta_y z - theta_z y,     y: t_y + theta_z x - theta_x z,     axial: t_z + theta_x y - theta_y x.

Above its mount modes a machine on such a plate is held by its own inertia: the acceleration of an unbalance grows as
speed^2. On rigid ground it would grow as speed^4 below the housings' modes.

Reference: C. M. Harris, A. G. Piersol, "Harris' Shock and Vibration Handbook", 5th ed., McGraw-Hill 2002, chapter 3
(rigid body on resilient supports).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from itertools import product

from ..assembly import Assembly
from .shaft_parts import require_positive

#: Mounts sit at this share of half the length and half the width.
MOUNT_SHARE = 0.9


@dataclass(frozen=True)
class BasePlate:
    """A rigid plate (for its inertia, a homogeneous box) on four equal mounts.

    Parameters
    ----------
    mass_kg : float
    length_m, width_m, height_m : float
        Of the box, along the shaft (z), across (x), upward (y).
    mount_stiffness_n_m : float
        Vertical, of one mount.
    mount_shear_ratio : float
        Horizontal over vertical stiffness of a mount.
    mount_damping_ratio : float
        Of the plate alone bouncing; the mounts' dampers are in proportion to their stiffness.
    mount_depth_m : float
        Of the mounts below the plate's mass centre; may be 0.
    """

    mass_kg: float
    length_m: float
    width_m: float
    height_m: float
    mount_stiffness_n_m: float
    mount_shear_ratio: float
    mount_damping_ratio: float
    mount_depth_m: float

    def __post_init__(self) -> None:
        for field in fields(self):
            if field.name not in ("mount_damping_ratio", "mount_depth_m"):
                require_positive(f"{field.name} of the base plate", getattr(self, field.name))

    @property
    def inertias_kg_m2(self) -> tuple[float, float, float]:
        """Moments of inertia about x, y and z through the mass centre: m (a^2 + b^2) / 12."""
        x, y, z = self.width_m**2, self.height_m**2, self.length_m**2
        return self.mass_kg * (y + z) / 12, self.mass_kg * (x + z) / 12, self.mass_kg * (x + y) / 12

    @property
    def bounce_hz(self) -> float:
        """Natural frequency of the plate alone moving up and down, sqrt(4 k / m) / (2 pi)."""
        return math.sqrt(4 * self.mount_stiffness_n_m / self.mass_kg) / (2 * math.pi)

    def point(self, *, x_m: float = 0.0, y_m: float = 0.0, z_m: float = 0.0) -> dict[str, dict[str, float]]:
        """Return the motion of a point of the plate, or rigidly fixed to it, in "x", "y" and "axial"."""
        directions = {
            "x": {"base.x": 1.0, "base.angle_y": z_m, "base.angle_z": -y_m},
            "y": {"base.y": 1.0, "base.angle_z": x_m, "base.angle_x": -z_m},
            "axial": {"base.axial": 1.0, "base.angle_x": y_m, "base.angle_y": -x_m},
        }
        return {name: {key: arm for key, arm in row.items() if arm} for name, row in directions.items()}

    def add(self, assembly: Assembly) -> None:
        """Add the plate's six degrees of freedom and its mounts to an assembly."""
        for direction in ("x", "y", "axial"):
            assembly.add_coordinate(f"base.{direction}", mass=self.mass_kg, vertical=direction == "y")
        for axis, inertia in zip("xyz", self.inertias_kg_m2, strict=True):
            assembly.add_coordinate(f"base.angle_{axis}", mass=inertia)
        delay = self.mount_damping_ratio / (math.pi * self.bounce_hz)
        for across, along in product((-1, 1), repeat=2):
            foot = self.point(
                x_m=across * MOUNT_SHARE * self.width_m / 2,
                y_m=-self.mount_depth_m,
                z_m=along * MOUNT_SHARE * self.length_m / 2,
            )
            for direction, row in foot.items():
                stiffness = self.mount_stiffness_n_m * (1.0 if direction == "y" else self.mount_shear_ratio)
                assembly.add_spring(row, stiffness=stiffness, damping=stiffness * delay)
