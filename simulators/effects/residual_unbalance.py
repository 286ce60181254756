"""Residual unbalance: what every rotor keeps after balancing, as recordings of the healthy machine show it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Normal, parameter
from ..rotor_dynamics.harmonic_force import rotating_mass

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class ResidualUnbalance(Effect):
    """F = w^2 (m_x + i m_y) exp(i w t) in x + i y: an unbalance by its components, which a fit can move through zero.

    A part of the healthy machine, never a cause: a fault is the effect `unbalance`. It grows as speed^2 and does not
    depend on the load.
    """

    NAME = "residual_unbalance"
    STAGE = "force"
    ROLE = "rotor"
    EMPIRICAL = True
    MEANING = "The unbalance that a rotor keeps after balancing, as its healthy recordings show it."
    CHECK = "What does the balancing report state for this plane?"
    RIVALS = {
        "unbalance": "a recording from before: only what has changed since is a fault",
        "shaft_bow": "slow-roll vector: a bow is there at any speed",
    }
    REFERENCES = ("ISO 21940-11:2016: permissible residual unbalance",)

    moment_x_kg_m: float = parameter(
        unit="kg.m",
        bounds=(-1.0, 1.0),
        zero=0.0,
        prior=LogNormal(1e-4, 3.0),
        meaning="component of the unbalance along x at shaft angle 0",
        source="fitted to healthy recordings; the prior is that of an unbalance",
    )
    moment_y_kg_m: float = parameter(
        unit="kg.m",
        bounds=(-1.0, 1.0),
        zero=0.0,
        prior=Normal(0.0, 1e-4),
        meaning="component of the unbalance along y at shaft angle 0",
        source="fitted to healthy recordings; the prior is that of an unbalance",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the rotating force at the chosen rotor."""
        place = assembly.place(self.ROLE, self.at)
        size = math.hypot(self.moment_x_kg_m, self.moment_y_kg_m)
        angle = math.atan2(self.moment_y_kg_m, self.moment_x_kg_m)
        assembly.forces.append(
            rotating_mass(f"residual unbalance of {place.name}", place, moment_kg_m=size, angle_rad=angle)
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X of the part's shaft."""
        place = machine.bare_assembly().place(self.ROLE, self.at)
        return (Line(place.shaft_ratio, speed_exponent=2.0, load_exponent=0.0),)
