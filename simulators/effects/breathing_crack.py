"""Breathing crack: a transverse crack in the shaft that the weight opens and closes once a revolution."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import Normal, Uniform, parameter
from ..rotor_dynamics.crack_flexibility import DEEPEST

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class BreathingCrack(Effect):
    """A hinge in the shaft, open by (1 + w(theta)) / 2, theta the angle from the crack to the side in tension.

    w is the cosine for a crack whose faces part little by little (Mayes and Davies), and tanh(k cos theta) / tanh k for
    one that opens more at once (Gasch); the abruptness k adds 4X and higher lines.

    The static load's bending moment in the section says which side is in tension: the lower one under the weight
    between two bearings. The hinge's flexibility, along the crack's normal and across it, follows from fracture
    mechanics (`rotor_dynamics.crack_flexibility`) and grows as depth^2.5 while the crack is shallow. The static moment
    then excites 1X, 2X and 3X with phases locked to the weight, proportional to the load and, far below the critical
    speed, the same at every speed. 2X peaks at half, 3X at a third of the critical speed.

    Without weight the crack breathes under whatever static load bends the shaft (gear force, belt, a static
    misalignment). Without any, it stays open: an asymmetric hinge that a whirling shaft carries round, which changes 1X
    and makes no 2X of its own. The machine's notes say so.

    Left out: opening by the vibration itself (the static load must dominate, which fails near a critical speed and for
    light or vertical rotors), coupling to torsion and axial motion, growth of the crack, and damping at its faces.
    """

    NAME = "breathing_crack"
    STAGE = "structure"
    ROLE = "shaft"
    MEANING = "A crack across the shaft opens when the load pulls on it and closes half a turn later."
    CHECK = "Does 1X or 2X drift with its phase over days? Record a run-down; test the shaft for cracks (ultrasound)."
    RIVALS = {
        "asymmetric_shaft": "run-down: a crack also raises 1X and 3X and grows; asymmetry is there from new",
        "shaft_bow": "slow-roll vector; a crack's 1X changes with the load and brings 2X",
        "unbalance": "2X peak at half the critical speed on a run-down; side load",
        "coupling_misalignment": "run uncoupled; 2X peak at half the critical speed",
        "coupling_stiffness_harmonics": "run uncoupled",
    }
    REFERENCES = (
        "I. W. Mayes, W. G. R. Davies, Analysis of the response of a multi-rotor-bearing system containing a "
        "transverse crack in a rotor, J. Vib. Acoust. 106 (1984) 139-145",
        "R. Gasch, A survey of the dynamic behaviour of a simple rotating shaft with a transverse crack, "
        "J. Sound Vib. 160 (1993) 313-332",
        "A. D. Dimarogonas, C. A. Papadopoulos, Vibration of cracked shafts in bending, J. Sound Vib. 91 (1983) 583",
    )
    IDEALISED = True

    depth_ratio: float = parameter(
        unit="",
        bounds=(0.0, DEEPEST),
        zero=0.0,
        prior=Uniform(0.0, 0.4),
        meaning="depth of the crack over the shaft's diameter",
        source="estimate: cracks are found from about 0.1; beyond 0.4 few shafts still run",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="direction from the shaft's centre to the crack, from x at shaft angle 0, in the sense of rotation",
        source="any angle is equally likely",
    )
    position: float = parameter(
        unit="",
        bounds=(0.05, 0.95),
        prior=Uniform(0.05, 0.95),
        meaning="place of the crack: 0 at the first bearing, 1 at the second",
        source="estimate: at a shoulder or keyway near the largest bending moment",
    )
    abruptness: float = parameter(
        unit="",
        bounds=(-4.0, 10.0),
        prior=Normal(0.0, 2.0),
        meaning="how abruptly it opens: 0 as the cosine of the angle, 5 nearly at once, below 0 it dwells half open",
        source="estimate: Gasch 1993 switches shallow cracks at once, Mayes and Davies 1984 deep ones as the cosine",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Crack the chosen shaft."""
        shaft = assembly.component(self.ROLE, self.at)
        shaft.add_crack(
            depth_ratio=self.depth_ratio,
            angle_rad=self.angle_rad,
            position=self.position,
            abruptness=self.abruptness,
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 2X, 1X, 3X of the shaft where a static load bends it there; else 1X."""
        from ..rotor_dynamics.shaft_flaws import has_static_load

        shaft = machine.bare_assembly().component(self.ROLE, self.at)
        if not has_static_load(machine, shaft.name, self.position):
            return (Line(shaft.shaft_ratio, speed_exponent=2.0),)
        return tuple(Line(n * shaft.shaft_ratio, speed_exponent=0.0, load_exponent=1.0) for n in (1, 2, 3))
