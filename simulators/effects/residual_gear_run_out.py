"""Residual gear run-out: what every gear keeps after cutting and mounting, as healthy recordings show it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Normal, parameter
from ._gear_damage import MARK, run_out_lines

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class ResidualGearRunOut(Effect):
    """e = a sin(n phi) + b cos(n phi) in the transmission error, n being the gear's speed over the reference shaft's.

    A part of the healthy machine, never a cause: a fault is the effect `gear_eccentricity`, as which its lines grow
    with speed and load. In components a fit can move it through zero.
    """

    NAME = "residual_gear_run_out"
    STAGE = "structure"
    ROLE = "gear"
    EMPIRICAL = True
    MEANING = "The run-out that a gear keeps after cutting and mounting, as its healthy recordings show it."
    CHECK = "What run-out does the gear's inspection report state?"
    RIVALS = {
        "gear_eccentricity": "a recording from before: only what has changed since is a fault",
        "residual_unbalance": "sidebands of the mesh, and 1X of the twist",
    }
    REFERENCES = (MARK, "ISO 1328-2:2020: permissible radial run-out of gears")

    sine_m: float = parameter(
        unit="m",
        bounds=(-2e-4, 2e-4),
        zero=0.0,
        prior=LogNormal(5e-6, 3.0),
        meaning="part of the error with the sine of the gear's angle, at shaft angle 0",
        source="fitted to healthy recordings; the prior is half of what ISO 1328-2 grade 6 allows",
    )
    cosine_m: float = parameter(
        unit="m",
        bounds=(-2e-4, 2e-4),
        zero=0.0,
        prior=Normal(0.0, 5e-6),
        meaning="part of the error with the cosine of the gear's angle",
        source="fitted to healthy recordings; the prior is half of what ISO 1328-2 grade 6 allows",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the run-out to the error of the mesh that the gear is in."""
        place = assembly.place(self.ROLE, self.at)
        size, angle = math.hypot(self.sine_m, self.cosine_m), math.atan2(self.cosine_m, self.sine_m)
        mesh = assembly.component("mesh")
        mesh.add_run_out(place.name, order=place.shaft_ratio, amplitude_m=size, angle_rad=angle)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the sidebands of the mesh and the gear's own speed."""
        return run_out_lines(machine, self.ROLE, self.at)
