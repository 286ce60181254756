"""Rotor of a motor: a rigid body on two bearings in its stator, with a torque-speed slope."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..assembly import Assembly, Place, difference
from ..law import Direction

#: Damper over spring of a ball bearing in s, the middle of the range 0.25e-5 to 2.5e-5 of E. Kraemer, "Dynamics of
#: Rotors and Foundations", Springer 1993.
BEARING_LOSS_S = 1e-5


@dataclass(frozen=True)
class MotorRotor:
    """A rigid rotor with x, y, axial, two tilting angles and torsion; its mass centre midway between its bearings.

    Parameters
    ----------
    mass_kg, polar_inertia_kg_m2 : float
    length_m : float
        Of the homogeneous cylinder that gives the diametral inertia, I_p / 2 + m L^2 / 12.
    bearing_span_m, overhang_m : float
        Between the bearings; from the front bearing to the end of the shaft.
    bearing_stiffness_n_m, axial_stiffness_n_m : float
        Radial, of one bearing; axial, of both.
    slope_n_m_s_rad : float
        Torque lost per rad/s of higher speed: a damper against the ideal rotation.
    """

    mass_kg: float
    polar_inertia_kg_m2: float
    length_m: float
    bearing_span_m: float
    overhang_m: float
    bearing_stiffness_n_m: float
    axial_stiffness_n_m: float
    slope_n_m_s_rad: float

    def at(self, arm_m: float) -> dict[str, dict[str, float]]:
        """Return the motion, in all directions, of the point ``arm_m`` from the mass centre towards the shaft's end."""
        return {
            "x": {"motor.x": 1.0, "motor.angle_y": arm_m},
            "y": {"motor.y": 1.0, "motor.angle_x": -arm_m},
            **{name: {f"motor.{name}": 1.0} for name in ("axial", "angle_x", "angle_y", "torsion")},
        }

    def add(
        self, assembly: Assembly, stator: Callable[[float], Mapping[str, Direction]]
    ) -> dict[str, dict[str, float]]:
        """Add the rotor and its place "motor" to an assembly and return the motion of the end of its shaft.

        Parameters
        ----------
        assembly : Assembly
        stator : callable
            ``stator(distance_m)`` gives the motion in "x", "y" and "axial" of the stator's point on the axis, the
            distance counted from the end of the motor's shaft into the motor.
        """
        diametral = self.polar_inertia_kg_m2 / 2 + self.mass_kg * self.length_m**2 / 12
        for direction in ("x", "y", "axial"):
            assembly.add_coordinate(f"motor.{direction}", mass=self.mass_kg, vertical=direction == "y")
        for angle in ("angle_x", "angle_y"):
            assembly.add_coordinate(f"motor.{angle}", mass=diametral)
        assembly.add_coordinate("motor.torsion", mass=self.polar_inertia_kg_m2, torsion_ratio=1.0)
        couple = self.polar_inertia_kg_m2 * np.array([[0.0, 1.0], [-1.0, 0.0]])
        assembly.add_matrix("gyroscopic", ["motor.angle_x", "motor.angle_y"], couple)
        half = self.bearing_span_m / 2
        for arm in (half, -half):
            frame = stator(self.overhang_m + half - arm)
            for direction in ("x", "y"):
                along = difference(self.at(arm)[direction], frame[direction])
                _add_bearing_spring(assembly, along, self.bearing_stiffness_n_m)
        along = difference({"motor.axial": 1.0}, stator(self.overhang_m + half)["axial"])
        _add_bearing_spring(assembly, along, self.axial_stiffness_n_m)
        assembly.add_spring({"motor.torsion": 1.0}, damping=self.slope_n_m_s_rad)
        assembly.add_place(Place("motor", frozenset({"rotor", "motor"}), self.at(0.0)))
        return self.at(half + self.overhang_m)


def _add_bearing_spring(assembly: Assembly, along: Direction, stiffness_n_m: float) -> None:
    assembly.add_spring(along, stiffness=stiffness_n_m, damping=BEARING_LOSS_S * stiffness_n_m)
