"""Residual coupling force: what every coupling pulls unequally when it is sound, as healthy recordings show it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Normal, parameter
from ..rotor_dynamics.harmonic_force import turning_force

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class ResidualCouplingForce(Effect):
    """F = (f_x + i f_y) exp(i w t) in x + i y at the coupling: by its components, which a fit can move through zero.

    A part of the healthy machine, never a cause: a fault is the effect `rotating_coupling_force`. What turns with the
    shaft and does not grow with its speed: a hub with run-out, unequal elements, an alignment within tolerance.
    """

    NAME = "residual_coupling_force"
    STAGE = "force"
    ROLE = "coupling"
    EMPIRICAL = True
    MEANING = "The force, turning with the shaft, that a sound coupling exerts, as healthy recordings show it."
    CHECK = "What run-out do the hubs have, and what does the alignment report state?"
    RIVALS = {
        "rotating_coupling_force": "a recording from before: only what has changed since is a fault",
        "residual_unbalance": "two or more speeds: the force of unbalance grows as speed^2",
    }
    REFERENCES = (
        "C. B. Gibbons, Coupling misalignment forces, Proc. 5th Turbomachinery Symposium, Texas A&M (1976) 111-116",
    )

    force_x_n: float = parameter(
        unit="N",
        bounds=(-1e4, 1e4),
        zero=0.0,
        prior=LogNormal(8.0, 3.0),
        meaning="component of the force along x at shaft angle 0",
        source="fitted to healthy recordings; the prior is that of a rotating coupling force",
    )
    force_y_n: float = parameter(
        unit="N",
        bounds=(-1e4, 1e4),
        zero=0.0,
        prior=Normal(0.0, 8.0),
        meaning="component of the force along y at shaft angle 0",
        source="fitted to healthy recordings; the prior is that of a rotating coupling force",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the turning force at the chosen coupling."""
        place = assembly.place(self.ROLE, self.at)
        size, angle = math.hypot(self.force_x_n, self.force_y_n), math.atan2(self.force_y_n, self.force_x_n)
        if not size:
            return
        assembly.forces.append(turning_force(f"residual force at {place.name}", place, force_n=size, angle_rad=angle))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X of the coupling's shaft."""
        place = machine.bare_assembly().place(self.ROLE, self.at)
        return (Line(place.shaft_ratio, speed_exponent=0.0, load_exponent=0.0),)
