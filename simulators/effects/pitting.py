"""Pitting: flanks of a few neighbouring teeth have lost material to fatigue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import Uniform, parameter
from ..rotor_dynamics.tooth_damage import PittedTooth
from ._gear_damage import RANDALL, once_a_turn_lines, tooth_angle, tooth_of

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class Pitting(Effect):
    """Pits take a share of the face width away near the pitch point: the contact of these teeth yields more.

    dc = c_h share / (1 - share) (1 - q^2)^4 over the path of contact. The same lines as a cracked tooth, weaker at
    equal extent, because the contact is the smallest part of the compliance; they grow with load (exponent 1) and not
    with speed, resonances apart. Left out: edges of the pits, the noise that rough flanks make, loss of tooth section.
    """

    NAME = "pitting"
    STAGE = "structure"
    ROLE = "gear"
    MEANING = "Fatigue pits have eaten a part of the flanks of a few teeth."
    CHECK = "Look at the flanks through the inspection hole; is there steel in the oil filter, was the oil too thin?"
    RIVALS = {
        "tooth_crack": "inspection; a crack makes a deeper dip on one tooth, pits a shallow one on several",
        "wear": "sidebands at the gear's speed: wear acts on all teeth and raises the mesh harmonics only",
        "gear_eccentricity": "synchronous average: local instead of a slow wave",
    }
    REFERENCES = (
        "X. Liang, H. Zhang, L. Liu, M. J. Zuo, The influence of tooth pitting on the mesh stiffness of a pair of "
        "external spur gears, Mech. Mach. Theory 106 (2016) 1-15",
        RANDALL,
    )

    share: float = parameter(
        unit="",
        bounds=(0.0, 0.9),
        zero=0.0,
        prior=Uniform(0.0, 0.6),
        meaning="share of the face width that is lost where the pits are densest",
        source="estimate: from first pits to a flank of which the smaller part carries",
    )
    teeth: float = parameter(
        unit="",
        bounds=(1.0, 20.0),
        default=3.0,
        meaning="number of neighbouring teeth that are pitted",
        source="as inspected, a whole number",
    )
    angle_rad: float = tooth_angle()

    def contribute(self, assembly: Assembly) -> None:
        """Pit the teeth that follow the chosen one."""
        mesh, count, number, _ = tooth_of(assembly, self.ROLE, self.at, self.angle_rad)
        if self.share > 0:
            for tooth in range(number, number + min(round(self.teeth), count)):
                mesh.add_tooth_damage(PittedTooth(self.share), every=count, first=tooth)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return multiples of the gear's speed in the twist and sidebands of the mesh."""
        return once_a_turn_lines(machine, self.ROLE, self.at, load_exponent=1.0)
