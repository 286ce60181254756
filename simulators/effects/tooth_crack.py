"""Tooth crack: one tooth of a gear has a crack at its root."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import Normal, Uniform, parameter
from ..rotor_dynamics.tooth_damage import ToothCrack as Crack
from ._gear_damage import RANDALL, WU, once_a_turn_lines, tooth_angle, tooth_of

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class ToothCrack(Effect):
    """The cracked tooth bends more: the mesh stiffness dips once a turn of its gear (potential-energy method).

    Multiples of the gear's speed in the twist and many low sidebands of the mesh, spaced by it; in the synchronous
    average a local dip with a step of phase. The transmission error of the dip is load over stiffness: the lines grow
    with load (exponent 1), which tells them from errors of the flanks. With speed the force stays, resonances apart.
    Left out: growth of the crack, its closing under reverse torque, load on the gear body near a deep crack.
    """

    NAME = "tooth_crack"
    STAGE = "structure"
    ROLE = "gear"
    MEANING = "One tooth is cracked at its root and yields more than the others once a turn."
    CHECK = "Synchronous average of the gear: a dip at one tooth? Dye-penetrant test of the roots; was there a shock?"
    RIVALS = {
        "gear_eccentricity": "synchronous average: local dip at one tooth instead of a slow wave; many sidebands",
        "pitting": "load sweep and inspection: pits are seen on the flank, a crack at the root",
        "hunting_tooth": "load sweep: an error of the flank stays when the load changes",
        "outer_race_defect": "lines on whole orders of the gear's shaft, no slip",
    }
    REFERENCES = (
        WU,
        "F. Chaari, T. Fakhfakh, M. Haddar, Analytical modelling of spur gear tooth crack and influence on gearmesh "
        "stiffness, Eur. J. Mech. A/Solids 28 (2009) 461-468",
        RANDALL,
    )

    depth: float = parameter(
        unit="",
        bounds=(0.0, 0.65),
        zero=0.0,
        prior=Uniform(0.0, 0.65),
        meaning="length of the crack over the thickness of the tooth's root; 0.5 straight across is its middle",
        source="from nothing to a tooth about to break, all equally likely",
    )
    crack_angle_rad: float = parameter(
        unit="rad",
        bounds=(0.2, math.pi / 2),
        prior=Normal(math.pi / 4, 0.2),
        meaning="angle between the crack and the tooth's centre line",
        source="estimate: studies of cracked teeth mostly take 45 degrees",
    )
    angle_rad: float = tooth_angle()

    def contribute(self, assembly: Assembly) -> None:
        """Crack one tooth of the chosen gear."""
        mesh, teeth, number, is_wheel = tooth_of(assembly, self.ROLE, self.at, self.angle_rad)
        if self.depth > 0:
            mesh.add_tooth_damage(Crack(is_wheel, self.depth, self.crack_angle_rad), every=teeth, first=number)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return multiples of the gear's speed in the twist and sidebands of the mesh."""
        return once_a_turn_lines(machine, self.ROLE, self.at, load_exponent=1.0)
