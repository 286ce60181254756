"""Asymmetric shaft: not equally stiff in both directions of its section."""

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
class AsymmetricShaft(Effect):
    """Bending stiffness k (1 - delta) along one direction that turns with the shaft, k (1 + delta) across it.

    A load that stands still (weight, gear force) then bends the shaft by (load / k) delta at 2X, whatever the speed as
    long as it is far below the critical speed w_n; the line grows with the load and peaks at half the critical speed.
    Between w_n sqrt(1 - delta) and w_n sqrt(1 + delta) the shaft is unstable unless the damping ratio exceeds about
    delta / 2. Unbalance alone makes no 2X in equal supports; in unequal ones its backward part makes 3X.

    The asymmetry acts on the shape that a load at ``position`` bends, so it belongs to the modes with that shape.
    Left out: unequal moments of inertia, and damping inside the shaft.
    """

    NAME = "asymmetric_shaft"
    STAGE = "structure"
    ROLE = "shaft"
    MEANING = "The shaft is stiffer one way than the other (keyway, flat, slots): a static load makes 2X."
    CHECK = "Is there a long keyway, a flat or a pole slot? Measure the sag at several shaft angles, at rest."
    RIVALS = {
        "breathing_crack": "run-down: 1X and 3X of a crack peak at the critical speed over 1 and 3; trend over weeks",
        "coupling_misalignment": "run uncoupled; 2X at half the critical speed stays with an asymmetric shaft",
        "support_anisotropy": "bump test at several shaft angles: an asymmetric shaft's frequency turns with it",
    }
    REFERENCES = (
        "M. I. Friswell et al., Dynamics of Rotating Machines, Cambridge 2010, chapter 7",
        "J. P. Den Hartog, Mechanical Vibrations, 4th ed., McGraw-Hill 1956 (secondary critical speed of weight)",
    )

    asymmetry: float = parameter(
        unit="",
        bounds=(0.0, 0.5),
        zero=0.0,
        prior=LogNormal(0.02, 2.5),
        meaning="half the difference of the two stiffnesses over their mean",
        source="estimate: a keyway takes a few percent of the second moment of area one way, a slotted body up to 0.2",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="soft direction from x at shaft angle 0, in the sense of rotation",
        source="any angle is equally likely",
        period=math.pi,
    )
    position: float = parameter(
        unit="",
        bounds=(0.05, 0.95),
        prior=Uniform(0.05, 0.95),
        meaning="point whose load feels the difference: 0 at the first bearing, 1 at the second",
        source="estimate: the body of a rotor lies between its bearings",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Make the chosen shaft's stiffness unequal."""
        shaft = assembly.component(self.ROLE, self.at)
        shaft.add_unequal_stiffness(asymmetry=self.asymmetry, angle_rad=self.angle_rad, position=self.position)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 2X of the shaft where a static load bends it; else 1X, which an asymmetric shaft changes."""
        from ..rotor_dynamics.shaft_flaws import has_static_load

        shaft = machine.bare_assembly().component(self.ROLE, self.at)
        if has_static_load(machine, shaft.name, self.position):
            return (Line(2 * shaft.shaft_ratio, speed_exponent=0.0, load_exponent=1.0),)
        return (Line(shaft.shaft_ratio, speed_exponent=2.0),)
