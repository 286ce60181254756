"""Twice-line force: the motor's magnetic pull pulsates at twice the supply frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..assembly import combination
from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.fixed_frequency_force import fixed_frequency_force

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class TwiceLineForce(Effect):
    """F cos(2 pi 2 f t + psi) between rotor and stator in the direction of the narrow gap, and the same in torque.

    The pull across an air gap goes as flux squared: a field that alternates at the supply's frequency pulls twice a
    period. An even gap cancels, an uneven one (soft foot, worn bearing, bent frame) leaves a force of one direction;
    unequal phase voltages leave a pulsating torque. The frequency stays when speed or load change; the force goes as
    voltage squared and hardly with load. Parts that the machine's model lacks (a motor that only turns, a stator on
    rigid ground) take no part. Left out: the pull's constant part and its negative stiffness, lines of slots.
    """

    NAME = "twice_line_force"
    STAGE = "force"
    ROLE = "motor"
    MEANING = "An uneven air gap or unequal phase voltages make the motor pull twice in each period of the supply."
    CHECK = "Does the line vanish the moment the power is cut? Are phase voltages equal, motor feet flat, the gap even?"
    RIVALS = {
        "mains_hum": "switch off: the force goes at once, hum of the cable stays; hum has 1 and 3 times the supply too",
        "coupling_misalignment": "resolve 2X from twice the supply (a long record), or cut the power: 2X coasts down",
        "load_fluctuation": "cut the power; the frequency is exactly twice the supply",
    }
    REFERENCES = (
        "W. T. Thomson and M. Fenger, Current signature analysis to detect induction motor faults, "
        "IEEE Industry Applications Magazine 7 (2001) 26-34",
        "R. B. Randall, Vibration-based Condition Monitoring, Wiley 2011",
    )

    force_n: float = parameter(
        unit="N",
        bounds=(0.0, 1e4),
        zero=0.0,
        prior=LogNormal(10.0, 4.0),
        meaning="amplitude of the pull between rotor and stator",
        source="estimate: a tenth of the gap's mean off centre in a motor of 1 kW",
    )
    torque_n_m: float = parameter(
        unit="N.m",
        bounds=(0.0, 1000.0),
        zero=0.0,
        prior=LogNormal(0.3, 4.0),
        meaning="amplitude of the pulsating torque",
        source="estimate: some percent of a torque of 10 N.m at 2 % of voltage unbalance",
    )
    supply_hz: float = parameter(
        unit="Hz",
        bounds=(1.0, 400.0),
        default=50.0,
        meaning="frequency f of the motor's supply; of the inverter's output where there is one",
        source="known from the country or the inverter",
    )
    phase_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="phase psi at the first sample",
        source="any phase is equally likely",
    )
    direction_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(0.0, math.pi),
        meaning="direction of the narrow gap from x (horizontal), standing still",
        source="any direction is equally likely",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add pull and torque at the motor, the opposite pull on its stator where that moves."""
        motor = assembly.place(self.ROLE, self.at)
        stators = [place for place in assembly.places.values() if "stator" in place.roles]
        acts: list[tuple[dict[str, float], float]] = []
        if "torsion" in motor.directions:
            acts.append((dict(motor.directions["torsion"]), self.torque_n_m))
        if {"x", "y"} <= set(motor.directions):
            share = {"x": math.cos(self.direction_rad), "y": math.sin(self.direction_rad)}
            pull = [(share[axis], motor.directions[axis]) for axis in share]
            pull += [(-share[axis], stator.directions[axis]) for stator in stators[:1] for axis in share]
            acts.append((combination(*pull), self.force_n))
        cos, sin = math.cos(self.phase_rad), -math.sin(self.phase_rad)
        assembly.forces.append(
            fixed_frequency_force(
                f"twice-line force at {motor.name}",
                tuple(output for output, _ in acts),
                frequency_hz=2 * self.supply_hz,
                cos=tuple(size * cos for _, size in acts),
                sin=tuple(size * sin for _, size in acts),
            )
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return twice the supply's frequency, fixed in Hz."""
        directions = machine.bare_assembly().place(self.ROLE, self.at).directions
        found = [name for name, strength in (("x", self.force_n), ("torsion", self.torque_n_m))
                 if name in directions and strength > 0]  # fmt: skip
        return tuple(
            Line(
                0.0,
                "lateral" if name == "x" else name,
                speed_exponent=0.0,
                load_exponent=0.0,
                frequency_hz=2 * self.supply_hz,
            )
            for name in found
        )
