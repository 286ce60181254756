"""Rub: the shaft touches a seal, a guard or a retainer ring."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Normal, Uniform, parameter
from ..rotor_dynamics.support import mesh_lines

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine

#: Height of the roughness over which the contact closes.
ROUGHNESS_M = 1e-6


@dataclass(frozen=True, kw_only=True)
class Rub(Effect):
    """The shaft in a ring off its centre: radial contact stiffness and friction against the rotation.

    The ring's centre lies ``clearance_m + interference_m`` away from the unloaded shaft's, opposite to ``angle_rad``.
    So the shaft meets the ring at that angle: at once when ``interference_m`` is positive, after that much motion when
    it is negative; with -clearance (or less) the ring is centred and touches only when the clearance is used up.

    A contact during a part of each revolution stiffens the shaft on average and makes multiples of 1X, above its
    natural frequency in contact also 1/n X; the orbit gets a part that turns backward. Friction drives the whirl
    backward; in a continuous rub around the ring it is self-excited when the friction force exceeds damping.

    No line grows by a simple law. Whether the shaft touches, and how hard, follows from its motion: with speed as it
    nears or leaves a critical speed, with the load as that pushes it towards the ring.

    Left out: heat, hence the slow turning of the 1X vector by a hot spot, wear, friction torque, and the ring's mass.
    """

    NAME = "rub"
    STAGE = "force"
    ROLE = "seal"
    MEANING = "The turning shaft touches a standing part: a seal, a guard, a retainer bearing."
    CHECK = "Are there marks, heat or dust at seals, guards and labyrinths? Does 1X drift while the speed is held?"
    RIVALS = {
        "looseness": "bolt torque; speed up and down: a rub comes and goes at different speeds; backward orbit",
        "oil_whirl": "its line lies at 1/n X exactly, or backward; whirl goes forward, below 1/2 X",
        "unbalance": "hold the speed: the 1X vector of a rub drifts; full spectrum",
        "asymmetric_shaft": "full spectrum: 2X of an asymmetric shaft goes forward; change of clearance",
    }
    REFERENCES = (
        "A. Muszynska, Rotordynamics, CRC Press 2005, chapter 5",
        "F. F. Ehrich, High order subharmonic response of high speed rotors in bearing clearance, J. Vib. Acoust. "
        "Stress Reliab. Des. 110 (1988) 9-16",
    )
    IDEALISED = True

    stiffness_n_m: float = parameter(
        unit="N/m",
        bounds=(0.0, 1e8),
        zero=0.0,
        prior=LogNormal(1e6, 3.0),
        meaning="radial stiffness of the contact with what holds it",
        source="estimate: labyrinth strips and guards 1e5-1e7 N/m, a retainer ring up to 1e8",
    )
    friction: float = parameter(
        unit="",
        bounds=(0.0, 0.5),
        prior=Uniform(0.05, 0.3),
        meaning="coefficient of dry friction",
        source="metal on metal: 0.05 with a trace of oil, 0.3 dry",
    )
    interference_m: float = parameter(
        unit="m",
        bounds=(-1e-3, 2e-4),
        prior=Normal(0.0, 2e-5),
        meaning="how far the ring reaches into the unloaded shaft at its nearest point; negative: gap there",
        source="estimate: a rub starts where the gap is used up; a wider one takes a shaft that moves as much",
    )
    clearance_m: float = parameter(
        unit="m",
        bounds=(2e-5, 5e-3),
        prior=LogNormal(2e-4, 1.7),
        meaning="radial clearance of a centred ring",
        source="estimate: seals have about 0.001 of the shaft's diameter and more",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="where the shaft meets the ring, from x",
        source="any angle is equally likely",
    )
    shaft_radius_m: float = parameter(
        unit="m",
        bounds=(2e-3, 1.0),
        prior=LogNormal(0.02, 2.0),
        meaning="radius of the shaft at the contact; it only says how fast the surfaces slide",
        source="estimate for shafts of laboratory and small industrial machines",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Put the ring round the shaft."""
        from ..rotor_dynamics.rub_contact import rub_contact

        place = assembly.place(self.ROLE, self.at)
        # -clearance is the centred ring; no gap can be wider than all round.
        apart = max(self.clearance_m + self.interference_m, 0.0)
        assembly.forces.append(
            rub_contact(
                f"rub at {place.name}",
                (place.directions["x"], place.directions["y"]),
                stiffness_n_m=self.stiffness_n_m,
                friction=self.friction,
                clearance_m=self.clearance_m,
                centre_m=-apart * cmath.exp(1j * self.angle_rad),
                width_m=ROUGHNESS_M,
                shaft_radius_m=self.shaft_radius_m,
                shaft_ratio=place.shaft_ratio,
            )
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X, 2X, 3X of the shaft, with gears the mesh line.

        1/n X and the backward whirl come with speed and are no promise.
        """
        assembly = machine.bare_assembly()
        ratio = assembly.place(self.ROLE, self.at).shaft_ratio
        return (*(Line(order * ratio) for order in (1.0, 2.0, 3.0)), *mesh_lines(assembly))
