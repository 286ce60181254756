"""Torque ripple: the torque on a shaft fluctuates with the shaft angle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..assembly import MissingPartError
from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.harmonic_force import harmonic_force

if TYPE_CHECKING:
    from ..assembly import Assembly, Place
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class TorqueRipple(Effect):
    """T cos(p phi + psi) on a shaft: twist at pX, and through an offset bolted coupling 1 - p and 1 + p sideways.

    T is the same at every speed. Ripple of a driven machine mostly grows with its load; which way is not known in
    general, so that T is taken as given.
    """

    NAME = "torque_ripple"
    STAGE = "force"
    ROLE = "load"
    MEANING = "The torque of load or driver fluctuates p times a revolution."
    CHECK = "Does load or driver pulsate: pump vanes, cylinders, an inverter? Measure motor current or shaft torque."
    RIVALS = {
        "bolt_loss": "load torque changed: ripple follows the machine that makes it; bolts retightened",
        "coupling_misalignment": "alignment check; torsional vibration or motor current at the same order",
        "unbalance": "torsional vibration or motor current at the same order",
    }
    REFERENCES = (
        "A. W. Lees, Misalignment in rigidly coupled rotors, J. Sound Vib. 305 (2007) 261-271, section 3, Fig 5",
        "API RP 684, 2nd edition 2005, on train torsionals",
    )

    torque_n_m: float = parameter(
        unit="N.m",
        bounds=(0.0, 1000.0),
        zero=0.0,
        prior=LogNormal(5.0, 4.0),
        meaning="amplitude of the fluctuating torque",
        source="some percent of a rated torque from 30 N.m to 1 kN.m; Lees takes 390 N.m",
    )
    order: float = parameter(
        unit="",
        bounds=(0.1, 50.0),
        prior=LogNormal(1.0, 2.5),
        meaning="fluctuations in one revolution of the shaft on which it acts",
        source="1 in Lees' Fig 5; the number of vanes, lobes or cylinders; 6 for each pole pair of an inverter drive",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="phase at shaft angle 0",
        source="any phase is equally likely",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the torque at the chosen place; without a name at the load, else at the motor, else where it can."""
        place = _turning_place(assembly, self.at)
        along, across = self.torque_n_m * math.cos(self.angle_rad), -self.torque_n_m * math.sin(self.angle_rad)
        assembly.forces.append(
            harmonic_force(
                f"torque ripple at {place.name}",
                (place.directions["torsion"],),
                order=self.order * place.shaft_ratio,
                cos=(along,),
                sin=(across,),
            )
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return pX of the twist and, with a bolted coupling, p + 1 and p - 1 of the shaft."""
        assembly = machine.bare_assembly()
        order = self.order * _turning_place(assembly, self.at).shaft_ratio
        lines = [Line(order, "torsion", speed_exponent=0.0)]
        for part in assembly.components.values():
            if "bolted_coupling" in part.roles:
                ratio = part.second.shaft_ratio
                lines += [Line(side) for side in (order + ratio, abs(order - ratio)) if side > 0]
        return tuple(lines)


def _turning_place(assembly: Assembly, name: str) -> Place:
    turning = [place for place in assembly.places.values() if "torsion" in place.directions]
    if name:
        turning = [place for place in turning if place.name == name]
    for role in ("load", "motor"):
        fitting = [place for place in turning if role in place.roles]
        if fitting:
            return fitting[0]
    if turning:
        return turning[0]
    able = [place.name for place in assembly.places.values() if "torsion" in place.directions]
    raise MissingPartError(
        f"No shaft that twists{f' at {name!r}' if name else ''} in this machine; "
        f"allowed: {', '.join(able) or 'none, its torsion is not modelled'}. Choose one or use another machine."
    )
