"""Shaft bow: the shaft is bent even without load."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class ShaftBow(Effect):
    """Force k r turning with the shaft, at 1X, the same at every speed and load; k is what a load at the bow feels.

    At slow roll the shaft simply turns its bend: 1X displacement r (the slow-roll vector), no force on the bearings.
    Of a disc in the middle of a shaft in rigid bearings, with eccentricity e and critical speed w_n,

        z = (r + e (w / w_n)^2) / (1 - (w / w_n)^2),

    so that a bow opposite to the unbalance cancels it at w_n sqrt(r / e), where the phase turns by 180 degrees although
    no resonance is passed.

    The bend is the shape that a load at ``position`` would give (a rub's hot spot), or lies between that and a kink
    there (a knock), or an even curvature between the bearings (a shaft that lay hot, or was heated on one side). Left
    out: growth of a thermal bow with time, an S, bends beyond the bearings, and the unbalance of a bent shaft's own
    mass, which only shows near and above the critical speed. A machine whose shaft is two springs has one bend only.
    """

    NAME = "shaft_bow"
    STAGE = "force"
    ROLE = "shaft"
    MEANING = "The shaft is bent even at rest: it turns its bend round, which shakes like an unbalance of fixed force."
    CHECK = "Turn the uncoupled shaft slowly by hand with a dial gauge on it: what run-out is there, and where?"
    RIVALS = {
        "unbalance": "three or more speeds across a critical speed; slow-roll vector; a trial mass",
        "coupling_misalignment": "slow-roll vector with the coupling opened; run uncoupled",
        "rotating_coupling_force": "slow-roll vector with the coupling opened",
        "run_out": "accelerometers: an uneven surface moves nothing; turn the probe along the shaft",
    }
    REFERENCES = (
        "J. C. Nicholas, E. J. Gunter, P. E. Allaire, Effect of residual shaft bow on unbalance response and balancing "
        "of a single mass flexible rotor, J. Eng. Power 98 (1976) 171-181",
        "M. I. Friswell et al., Dynamics of Rotating Machines, Cambridge 2010",
    )

    bow_m: float = parameter(
        unit="m",
        bounds=(0.0, 2e-3),
        zero=0.0,
        prior=LogNormal(5e-5, 2.5),
        meaning="deflection of the unloaded shaft from the line through its bearings",
        source="estimate: usual straightness limits are 0.02-0.05 mm, a bow that is noticed has more",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="direction of the bow from x at shaft angle 0, in the sense of rotation",
        source="any angle is equally likely",
    )
    position: float = parameter(
        unit="",
        bounds=(0.05, 0.95),
        prior=Uniform(0.05, 0.95),
        meaning="place of the bend: 0 at the first bearing, 1 at the second",
        source="estimate: a shaft bends where its bending moment or its heating is largest, away from the bearings",
    )
    evenness: float = parameter(
        unit="",
        bounds=(-1.0, 1.0),
        prior=Uniform(-1.0, 1.0),
        meaning="shape of the bend: 0 as by a load at the place, 1 evenly curved between the bearings, -1 as a kink",
        source="estimate: a knock bends sharply, a hot spot as a load does, its own weight or uneven heat evenly",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Bend the chosen shaft."""
        shaft = assembly.component(self.ROLE, self.at)
        shaft.add_bow(bow_m=self.bow_m, angle_rad=self.angle_rad, position=self.position, evenness=self.evenness)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X of the shaft: the force does not grow with speed or load."""
        ratio = machine.bare_assembly().component(self.ROLE, self.at).shaft_ratio
        return (Line(ratio, speed_exponent=0.0, load_exponent=0.0),)
