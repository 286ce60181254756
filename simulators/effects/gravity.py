"""Gravity: the weight of all parts, which sag on their supports."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..assembly import MissingPartError
from ..effect import Effect, Line
from ..parameter import Normal, parameter
from ..rotor_dynamics.weight import Weight

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine

_NAME = "weight (effect)"
#: Couplings whose stiffness turns.
_FEELS_SAG = frozenset({"flexible_coupling", "bolted_coupling"})


@dataclass(frozen=True, kw_only=True)
class Gravity(Effect):
    """F = -g M v, v the unit vertical translation of everything that has weight: a constant force downward.

    Speed and load do not change it. Alone it only shifts the mean. Where stiffness turns or depends on the position
    (offset flange, rolling bearing, clearance, crack) the sag makes lines: 1X of the twist and 2X of the shaft at an
    offset bolted coupling.
    """

    NAME = "gravity"
    STAGE = "force"
    ROLE = "rotor"
    MEANING = "All parts have weight and sag on their supports; a horizontal shaft feels it once a revolution."
    CHECK = "Is the shaft horizontal or vertical? Was it aligned at rest, cold, with the sag it has when running?"
    RIVALS = {
        "axis_misalignment": "a vertical offset acts like a sag: alignment at rest says which",
        "bolt_loss": "bolts retightened: the sag stays",
    }
    REFERENCES = ("M. I. Friswell et al., Dynamics of Rotating Machines, Cambridge 2010",)
    PERMANENT = True

    gravity_m_s2: float = parameter(
        unit="m/s2",
        bounds=(0.0, 20.0),
        zero=0.0,
        prior=Normal(9.81, 0.02),
        meaning="acceleration of gravity across the shaft: 9.81 for a horizontal shaft, 0 for a vertical one",
        source="9.78 at the equator, 9.83 at the poles",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the weight of everything, computed when all parts are in place.

        Raises
        ------
        MissingPartError
            When nothing in the machine has weight, or when the machine has its weight by itself.
        """
        if not assembly.vertical:
            raise MissingPartError("Nothing in this machine has weight (no vertical motion). Use another machine.")
        for part in assembly.components.values():
            if not isinstance(part, Weight):
                continue
            if part.name != _NAME:
                raise MissingPartError("This machine has its weight already. Leave the effect gravity out.")
            part.gravity_m_s2 += self.gravity_m_s2
            return
        assembly.add_component(Weight(name=_NAME, gravity_m_s2=self.gravity_m_s2))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the lines that a coupling makes of an elongation that stands still, else the mean in y."""
        for part in self.parts(machine).components.values():
            if part.roles & _FEELS_SAG and part.stationary_misalignment_lines():
                return part.stationary_misalignment_lines()
        return (Line(0.0, "y"),)
