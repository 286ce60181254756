"""Housing resonance: a part of a bearing housing vibrates by itself and the sensor sits on it."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..assembly import combination
from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class HousingResonance(Effect):
    """An oscillator of mass m and frequency f in one direction n of a housing; the sensor sees q + v n (q_m - n q).

    Everything near f is raised by up to v / (2 zeta), above f it is lowered; the housing itself feels the mass as a
    tuned absorber. The excitation is not changed: lines grow with speed and load as they did, and as each passes f.
    Several such modes at one housing add. Left out: rotation of the housing, motion along the shaft.
    """

    NAME = "housing_resonance"
    STAGE = "structure"
    ROLE = "housing"
    MEANING = "A wall, bracket or cover of a bearing housing has a natural frequency near a line of the machine."
    CHECK = "Bump test at the sensor, machine at rest; does a line rise sharply at one speed, is a bolt or rib missing?"
    RIVALS = {
        "unbalance": "run-up: a resonance stays at its frequency in Hz, an unbalance follows the order",
        "support_anisotropy": "bump test beside the housing: only the part itself answers",
        "mesh_error_harmonics": "run-up; sensor moved a hand's breadth away",
    }
    REFERENCES = (
        "J. P. Den Hartog, Mechanical Vibrations, 4th ed., McGraw-Hill 1956, chapter 3",
        "ISO 20816-1:2016, on resonances of the place where a sensor is mounted",
    )

    mass_kg: float = parameter(
        unit="kg",
        bounds=(0.0, 1.0),
        zero=0.0,
        prior=LogNormal(0.02, 2.5),
        meaning="mass of the part that vibrates",
        source="estimate: a plate of 3 mm steel, 30 mm square; larger machines have more",
    )
    participation: float = parameter(
        unit="",
        bounds=(0.0, 2.0),
        zero=0.0,
        prior=Uniform(0.0, 2.0),
        meaning="what the sensor sees of the part's motion against the housing; 1 for a sensor on it",
        source="estimate: from a sensor beside the part to one at its free edge",
    )
    frequency_hz: float = parameter(
        unit="Hz",
        bounds=(5.0, 5000.0),
        prior=LogNormal(600.0, 2.0),
        meaning="natural frequency of the part on a housing at rest",
        source="estimate: covers and brackets of machines of this size, 200 to 2000 Hz",
    )
    damping_ratio: float = parameter(
        unit="",
        bounds=(0.001, 0.5),
        prior=LogNormal(0.02, 2.0),
        meaning="damping of the part",
        source="estimate: bolted plates have 1 to 5 %",
    )
    direction_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(0.0, math.pi),
        meaning="direction n of its motion from x; pi/2 is vertical",
        source="any direction is equally likely",
        period=math.pi,
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the oscillator and lead the probes of the housing over it."""
        place = assembly.place(self.ROLE, self.at)
        if self.mass_kg == 0:
            return
        weights = {"x": math.cos(self.direction_rad), "y": math.sin(self.direction_rad)}
        number = sum(name.startswith(f"{place.name} part ") for name in assembly.coordinates) + 1
        own = {f"{place.name} part {number}": 1.0}
        assembly.add_coordinate(next(iter(own)), mass=self.mass_kg)
        moves = [(-weight, place.directions[axis]) for axis, weight in weights.items()]
        against = combination((1.0, own), *moves)
        circular = 2 * math.pi * self.frequency_hz
        assembly.add_spring(
            against,
            stiffness=self.mass_kg * circular**2,
            damping=2 * self.damping_ratio * self.mass_kg * circular,
        )
        for i, probe in enumerate(assembly.probes):
            if probe.location == place.name and probe.direction in weights:
                share = self.participation * weights[probe.direction]
                row = combination((1.0, probe.row), (share, against))
                assembly.probes[i] = dataclasses.replace(probe, row=row)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the mesh harmonics of a gearbox, else 1X: no line is new, those that reach the housing change."""
        direction = "y" if abs(math.sin(self.direction_rad)) >= abs(math.cos(self.direction_rad)) else "x"
        for part in machine.bare_assembly().components.values():
            if "mesh" in part.roles:
                return tuple(Line(k * part.mesh_order, direction) for k in range(1, 8))
        return (Line(1.0, direction),)
