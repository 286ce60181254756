"""Pole pass: broken rotor bars or an uneven rotor of an induction motor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..errors import InvalidValueError
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.harmonic_force import harmonic_force

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class PolePass(Effect):
    """F (1 + cos(q phi)) turning with the rotor, and T cos(q phi + psi) in torque; q = poles x slip / (1 - slip).

    The weak spot of the rotor (a broken bar, an eccentric core) turns at 1X; the poles of the field overtake it at the
    slip speed, so that its pull swells and fades poles x slip speed times a second, which is also twice the slip times
    the supply frequency. Lines: 1X, and 1X with both sidebands of half the height. Slip goes with the load, so that the
    sidebands move outwards and grow with it; at no load they vanish into 1X. Forces go with current, not with speed.
    Left out: higher pole-pass sidebands, lines of bar pass, the change of slip by the pulsating torque itself.
    """

    NAME = "pole_pass"
    STAGE = "force"
    ROLE = "motor"
    MEANING = "A broken bar or an uneven rotor makes the motor's 1X swell and fade with the slip."
    CHECK = "Do the sidebands go when the load goes? Does the motor current show sidebands of twice the slip frequency?"
    RIVALS = {
        "unbalance": "resolve the sidebands (a record of minutes); cut the power: electrical 1X goes at once",
        "speed_wander": "load: pole-pass sidebands move with the slip; motor current",
        "load_fluctuation": "distance of the sidebands against the slip measured by a strobe or a tacho",
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
        meaning="mean of the pull that turns with the rotor; it swings between 0 and twice that",
        source="estimate: magnetic pull of a rotor a tenth of the gap off centre in a motor of 1 kW",
    )
    torque_n_m: float = parameter(
        unit="N.m",
        bounds=(0.0, 1000.0),
        zero=0.0,
        prior=LogNormal(0.2, 4.0),
        meaning="amplitude of the pulsating torque",
        source="estimate: one of 30 bars broken takes some percent of a torque of 10 N.m",
    )
    slip: float = parameter(
        unit="",
        bounds=(0.001, 0.3),
        prior=Uniform(0.005, 0.05),
        meaning="slip: field speed less shaft speed, over field speed",
        source="name plates of small induction motors: 0.5 to 5 % at rated load",
    )
    poles: float = parameter(
        unit="",
        bounds=(2.0, 24.0),
        default=4.0,
        meaning="number of poles, even",
        source="name plate: 3000 / 1500 / 1000 rpm at 50 Hz are 2 / 4 / 6 poles",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="angle of the weak spot from x at shaft angle 0, in the sense of rotation",
        source="any angle is equally likely",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.poles % 2:
            raise InvalidValueError(f"poles = {self.poles!r}; allowed: even whole numbers from 2 to 24. Correct it.")

    @property
    def pole_pass_order(self) -> float:
        """Pole-pass frequency over the motor's speed: poles x slip / (1 - slip)."""
        return self.poles * self.slip / (1 - self.slip)

    def contribute(self, assembly: Assembly) -> None:
        """Add the turning pull and the torque at the motor."""
        motor = assembly.place(self.ROLE, self.at)
        name, ratio, apart = f"pole pass at {motor.name}", motor.shaft_ratio, self.pole_pass_order
        if "torsion" in motor.directions:
            acts = (motor.directions["torsion"],)
            assembly.forces.append(
                harmonic_force(f"{name}, torque", acts, order=ratio * apart, cos=(self.torque_n_m,), sin=(0.0,))
            )
        if not {"x", "y"} <= set(motor.directions):
            return
        both = (motor.directions["x"], motor.directions["y"])
        for order, share in ((1.0, 1.0), (1.0 + apart, 0.5), (1.0 - apart, 0.5)):
            along, across = (share * self.force_n * f(self.angle_rad) for f in (math.cos, math.sin))
            assembly.forces.append(
                harmonic_force(
                    f"{name}, {order:.4g}X", both, order=ratio * order, cos=(along, across), sin=(-across, along)
                )
            )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X and its sidebands sideways, the pole-pass frequency in torsion."""
        motor = machine.bare_assembly().place(self.ROLE, self.at)
        apart, ratio, lines = self.pole_pass_order, motor.shaft_ratio, []
        if "x" in motor.directions and self.force_n > 0:
            orders = (1.0, 1.0 + apart, 1.0 - apart)
            lines += [Line(ratio * order, speed_exponent=0.0, load_exponent=1.0) for order in orders]
        if "torsion" in motor.directions and self.torque_n_m > 0:
            lines.append(Line(ratio * apart, "torsion", speed_exponent=0.0, load_exponent=1.0))
        return tuple(lines)
