"""Unbalance: the mass centre of a rotating part is off its axis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Normal, Uniform, parameter
from ..rotor_dynamics.harmonic_force import rotating_couple, rotating_mass

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class Unbalance(Effect):
    """F = m e w^2 turning with the shaft: circular forward excitation at 1X of the part's own shaft.

    The force grows as speed^2 and does not depend on the load; its angle is that of the heavy spot. What is seen turns
    by 90 degrees up to a natural frequency and by 180 beyond it. While the speed changes, m e dw/dt acts across it.

    A heavy spot beside the middle of a disc tilts it as well, by the moment of its force about the middle. A part that
    the machine does not let tilt does not feel that. Left out: a couple whose plane is not that of the force, as of
    weights at several places.
    """

    NAME = "unbalance"
    STAGE = "force"
    ROLE = "rotor"
    MEANING = "The mass centre of a rotating part is off its axis; the force turns with the shaft and grows as speed^2."
    CHECK = "Was the rotor balanced after its last repair? Is a balance weight or a blade missing, is there a deposit?"
    RIVALS = {
        "shaft_bow": "three or more speeds across a critical speed; slow-roll vector",
        "coupling_misalignment": "three or more speeds; a trial mass",
        "rotating_coupling_force": "two or more speeds: that force does not grow with speed",
    }
    REFERENCES = (
        "ISO 21940-11:2016",
        "M. I. Friswell et al., Dynamics of Rotating Machines, Cambridge 2010, chapter 6",
    )

    moment_kg_m: float = parameter(
        unit="kg.m",
        bounds=(0.0, 0.1),
        zero=0.0,
        prior=LogNormal(1e-4, 3.0),
        meaning="unbalance, mass times eccentricity",
        source="ISO 21940-11 grade G6.3 on a rotor of 3 kg at 1800 rpm is 1e-4 kg.m; field values scatter by 3",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="angle of the heavy spot from x at shaft angle 0, in the sense of rotation",
        source="any angle is equally likely",
    )
    axial_offset_m: float = parameter(
        unit="m",
        bounds=(-2.0, 2.0),
        prior=Normal(0.0, 0.01),
        meaning="distance of the heavy spot from the middle of the part, along z: from the coupling to the free end",
        source="estimate: half of a disc's width; weights are put on its faces",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the rotating force at the chosen rotor, and its moment."""
        place = assembly.place(self.ROLE, self.at)
        name, angle = f"unbalance at {place.name}", self.angle_rad
        assembly.forces.append(rotating_mass(name, place, moment_kg_m=self.moment_kg_m, angle_rad=angle))
        couple = self.moment_kg_m * self.axial_offset_m
        tilting = rotating_couple(f"couple of {name}", place, couple_kg_m2=couple, angle_rad=angle)
        if couple and tilting is not None:
            assembly.forces.append(tilting)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X of the part's shaft."""
        place = machine.bare_assembly().place(self.ROLE, self.at)
        return (Line(place.shaft_ratio, speed_exponent=2.0, load_exponent=0.0),)
