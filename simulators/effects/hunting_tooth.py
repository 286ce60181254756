"""Hunting tooth: one damaged tooth on each of two gears, and the pulse when the two meet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.tooth_damage import ToothError
from ._gear_damage import RANDALL, mesh_with_teeth

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class HuntingTooth(Effect):
    """Tooth i of the pinion and tooth j of the wheel stand proud: a pulse whenever they meet, order mesh gcd / (z1 z2).

    Each alone makes a smaller pulse once a turn of its gear, since the sound partner's flank gives way in the lubricant
    and is worn to fit. The pulse is a displacement: its force does not grow with load, and as long as the teeth follow
    it, acceleration grows as speed^2. The line itself is very low (a growl or beat that is heard and not measured);
    its family is seen in the synchronous average over the whole hunting period. Left out: impacts of proud edges.
    """

    NAME = "hunting_tooth"
    STAGE = "structure"
    ROLE = "gear"
    SHARED = True
    MEANING = "One tooth of each gear is damaged; when the two meet, every gcd / (z1 z2) of the mesh, it knocks."
    CHECK = "A knock that comes back every some seconds? Mark the teeth in mesh at that moment and look at both."
    RIVALS = {
        "tooth_crack": "load sweep: a crack's lines grow with load; a knock at the hunting period needs both gears",
        "gear_eccentricity": "synchronous average of each gear: local instead of a slow wave",
        "torque_ripple": "the period follows the mesh and both numbers of teeth, not the load's cycle",
    }
    REFERENCES = (RANDALL,)

    error_m: float = parameter(
        unit="m",
        bounds=(0.0, 1e-4),
        zero=0.0,
        prior=LogNormal(1e-5, 2.0),
        meaning="height of the pulse when the two damaged teeth meet",
        source="estimate: dents of handling or foreign bodies raise 5 to 20 um",
    )
    alone: float = parameter(
        unit="",
        bounds=(0.0, 1.0),
        prior=Uniform(0.0, 0.8),
        meaning="share of it that either damaged tooth makes with a sound partner",
        source="estimate: no pulse with a run-in partner up to nearly the whole",
    )
    meeting: float = parameter(
        unit="",
        bounds=(0.0, 1.0),
        prior=Uniform(0.0, 1.0),
        meaning="when the two first meet, in hunting periods from shaft angle 0",
        source="any time is equally likely",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Damage the tooth of each gear that meets at the chosen pair."""
        assembly.place(self.ROLE, self.at)
        mesh = mesh_with_teeth(assembly)
        one, two = mesh.pair.pinion.teeth, mesh.pair.wheel.teeth
        period = math.lcm(one, two)
        first = math.floor(self.meeting * period) % period
        if self.error_m > 0:
            for every in (one, two):
                mesh.add_tooth_damage(ToothError(self.alone * self.error_m), every=every, first=first)
            mesh.add_tooth_damage(ToothError((1 - 2 * self.alone) * self.error_m), every=period, first=first)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return multiples of both gears' speeds in the twist, their sidebands of the mesh, and the hunting order."""
        mesh = machine.bare_assembly().component("mesh")
        one, two = mesh.pair.pinion.teeth, mesh.pair.wheel.teeth
        order = mesh.mesh_order
        ratios = (order / one, order / two)
        lines = [Line(k * ratio, "torsion", load_exponent=0.0) for k in range(1, 7) for ratio in ratios]
        lines += [Line(order + side * ratio, "any", load_exponent=0.0) for ratio in ratios for side in (1, -1)]
        return (*lines, Line(order / math.lcm(one, two), "any", load_exponent=0.0))
