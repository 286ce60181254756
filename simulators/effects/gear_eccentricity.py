"""Gear eccentricity: the pitch circle of a gear runs out."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.harmonic_force import rotating_mass
from ._gear_damage import run_out_lines

if TYPE_CHECKING:
    from ..assembly import Assembly, Place
    from ..law import Direction
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class GearEccentricity(Effect):
    """e = r sin(n phi + psi) in the transmission error, n being the gear's speed over the reference shaft's.

    The pulsing mesh stiffness turns the slow error into sidebands of the mesh frequency, spaced by the gear's own
    speed: in a mesh that is held, forces k_1 r / 2 at mesh +- n, k_1 being the first harmonic of the stiffness. Gears
    that are free roll along with the error; their inertia holds them back by a share that grows as speed^2 until a
    resonance is met. The error is a displacement: this part grows with no load. The centre distance changes with it,
    and each pair of teeth enters later, by some 0.05 of a pitch in 0.1 mm, or earlier: sidebands that grow with the
    load, as strong at each multiple of the mesh. A gear that was bored beside its centre has its mass off as well: a
    force m r (n w)^2 that turns with it, as of an `unbalance`. The change of the backlash is left out.
    """

    NAME = "gear_eccentricity"
    STAGE = "structure"
    ROLE = "gear"
    MEANING = "The pitch circle of a gear is off its axis of rotation; teeth engage too early, then too late."
    CHECK = "What run-out does an indicator show on the gear? Was it re-bored or mounted on a bent or worn shaft?"
    RIVALS = {
        "unbalance": "sidebands of the mesh, and not 1X alone",
        "rotating_coupling_force": "sidebands of the other shaft's speed; run uncoupled",
        "torque_ripple": "sidebands at the gear's own speed and not at the motor's supply or pole frequency",
    }
    REFERENCES = (
        "W. D. Mark, Analysis of the vibratory excitation of gear systems: basic theory, "
        "J. Acoust. Soc. Am. 63 (1978) 1409-1430",
        "P. D. McFadden, Detecting fatigue cracks in gears by amplitude and phase demodulation of the meshing "
        "vibration, J. Vib. Acoust. 108 (1986) 165-170",
    )

    run_out_m: float = parameter(
        unit="m",
        bounds=(0.0, 2e-4),
        zero=0.0,
        prior=LogNormal(1e-5, 2.0),
        meaning="eccentricity r of the pitch circle, half the radial run-out",
        source="ISO 1328-2 grade 6 allows a radial run-out of about 20 um at module 2 and 46 mm: r of 10 um",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="angle psi of the error at shaft angle 0",
        source="any angle is equally likely",
    )

    mass_share: float = parameter(
        unit="",
        bounds=(0.0, 1.0),
        prior=Uniform(0.0, 1.0),
        meaning="share of the run-out by which the gear's mass centre is off as well",
        source="0 for a gear that was balanced afterwards, 1 for one bored beside its centre",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the run-out to the error of the mesh that the gear is in, and the force of its mass."""
        place = assembly.place(self.ROLE, self.at)
        mesh = assembly.component("mesh")
        mesh.add_run_out(
            place.name,
            order=place.shaft_ratio,
            amplitude_m=self.run_out_m,
            angle_rad=self.angle_rad,
        )
        moment = self.mass_share * self.run_out_m * _mass_kg(assembly, place)
        if moment:
            if mesh.gear(place.name)[1]:
                # The driven gear turns the other way.
                place = replace(place, directions={**place.directions, "y": _opposite(place.directions["y"])})
            name = f"mass beside the axis of {place.name}"
            assembly.forces.append(rotating_mass(name, place, moment_kg_m=moment, angle_rad=self.angle_rad))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the sidebands of the mesh and the gear's own speed, in the twist and of its mass."""
        own = machine.bare_assembly().place(self.ROLE, self.at).shaft_ratio
        return (*run_out_lines(machine, self.ROLE, self.at), Line(own, speed_exponent=2.0, load_exponent=0.0))


def _opposite(direction: Direction) -> Direction:
    return {name: -share for name, share in direction.items()}


def _mass_kg(assembly: Assembly, place: Place) -> float:
    """Return the mass that moves with a gear across its axis; 0 where it cannot."""
    along = place.directions.get("x", {})
    return sum(share**2 * assembly.mass.get((name, name), 0.0) for name, share in along.items())
