"""Support anisotropy: supports are not equally stiff in both directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import Uniform, parameter
from ..rotor_dynamics.support import chosen_supports

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class SupportAnisotropy(Effect):
    """k_x -> (1 + fraction) k_x: a turning force then makes an elliptic orbit, a part of which turns backward.

    Between the two natural frequencies that the difference makes, the backward part is the larger one. No force is
    added: lines grow with speed and load as what excites them.
    """

    NAME = "support_anisotropy"
    STAGE = "structure"
    ROLE = "support"
    MEANING = "The supports are stiffer in one direction than in the other; most are softer sideways."
    CHECK = "Compare 1X, its phase and the natural frequencies in x and y (bump test); look at the pedestal's shape."
    RIVALS = {
        "coupling_misalignment": "bump test in x and y; alignment corrected",
        "housing_resonance": "run-up: a resonance passes, a difference of stiffness stays at every speed",
    }
    REFERENCES = ("M. I. Friswell et al., Dynamics of Rotating Machines, Cambridge 2010, chapter 3",)

    fraction: float = parameter(
        unit="",
        bounds=(-0.9, 2.0),
        zero=0.0,
        prior=Uniform(-0.6, 0.0),
        meaning="change of the horizontal stiffness k_x over its value; negative is softer",
        source="a guess: most pedestals are softer sideways, by up to a half, seldom more",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Scale k_x of the named support, or of all supports when no name is given."""
        for support in chosen_supports(assembly, self.at):
            support.scale_stiffness(x=1.0 + self.fraction)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 2X of the twist and 3X of the shaft with a bolted coupling, the mesh line with gears, else 1X in x.

        With an offset flange the backward part of the orbit at 1X makes a torque at 2X, and that makes 3X. Otherwise
        no line is new: those that the machine has anyway change in x.
        """
        parts = machine.bare_assembly().components.values()
        for part in parts:
            if "bolted_coupling" in part.roles:
                ratio = part.second.shaft_ratio
                return (Line(2 * ratio, "torsion"), Line(3 * ratio))
        for part in parts:
            if "mesh" in part.roles:
                return (Line(part.mesh_order),)
        return (Line(1.0, "x"),)
