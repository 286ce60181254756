"""A force of constant size that turns with the shaft at a coupling."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.harmonic_force import turning_force

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class RotatingCouplingForce(Effect):
    """F (cos(phi + psi), sin(phi + psi)) at the coupling: 1X of its shaft, with the same force at every speed and load.

    A coupling whose elements pull unequally, a hub on a worn key, teeth that carry on one side push the shaft so.
    """

    NAME = "rotating_coupling_force"
    STAGE = "force"
    ROLE = "coupling"
    MEANING = "The coupling pushes the shaft sideways; the force turns with the shaft and does not grow with speed."
    CHECK = "Are the coupling's elements, bolts, key and hub seats sound and equal? Does 1X go when it is opened?"
    RIVALS = {
        "unbalance": "two or more speeds: the force of unbalance grows as speed^2",
        "coupling_misalignment": "alignment corrected: a force of the coupling itself stays",
        "shaft_bow": "slow-roll vector with the coupling opened",
    }
    REFERENCES = (
        "C. B. Gibbons, Coupling misalignment forces, Proc. 5th Turbomachinery Symposium, Texas A&M (1976) 111-116",
    )

    force_n: float = parameter(
        unit="N",
        bounds=(0.0, 1e4),
        zero=0.0,
        prior=LogNormal(8.0, 3.0),
        meaning="size of the force",
        source="8 N gives the 1X and its sidebands that a test rig with a 30 N.m gearbox showed; a guess within 3",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="direction of the force from x at shaft angle 0, in the sense of rotation",
        source="any angle is equally likely",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the turning force at the chosen coupling."""
        place = assembly.place(self.ROLE, self.at)
        if not self.force_n:
            return
        force = turning_force(f"rotating force at {place.name}", place, force_n=self.force_n, angle_rad=self.angle_rad)
        assembly.forces.append(force)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X of the coupling's shaft."""
        place = machine.bare_assembly().place(self.ROLE, self.at)
        return (Line(place.shaft_ratio, speed_exponent=0.0, load_exponent=0.0),)
