"""Inner race defect: a pit in the turning race of a rolling bearing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Line
from ..parameter import Uniform, parameter
from ._bearing_defect import (
    MCFADDEN,
    RANDALL,
    SAWALHI,
    BearingEffect,
    harmonics,
    pass_order,
    pulse_line,
    size_parameter,
)

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class InnerRaceDefect(BearingEffect):
    """The pit turns with the shaft and passes the load zone once a turn: lines at k BPFI with sidebands of 1X.

    Growth with load (exponent 1), speed and size as for `outer_race_defect`. The pulses are further from the housing
    in reality, an attenuation that is left out.
    """

    NAME = "inner_race_defect"
    MEANING = "A pit or spall in the inner race; balls strike it while it passes the load zone."
    CHECK = "Envelope spectrum at the ball-pass order of the inner race with sidebands at 1X; was the fit too tight?"
    RIVALS = {
        "outer_race_defect": "sidebands at 1X round the ball-pass order; sum of both orders is the number of balls",
        "tooth_crack": "no whole order: lines 1-2 % above the computed ball-pass order, and they wander",
        "unbalance": "1X in the envelope only with the ball-pass order beside it",
    }
    REFERENCES = (RANDALL, SAWALHI, MCFADDEN)

    size_m: float = size_parameter("length s of the pit along the inner race")
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="angle of the pit from the direction of the bearing's steady load at shaft angle 0",
        source="any angle is equally likely",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Put the pit into the inner race of the chosen bearing."""
        part = assembly.component(self.ROLE, self.at)
        part.damage.add_pit(inner=True, size_m=self.size_m, angle_rad=part.load_angle_rad + self.angle_rad)
        part.damage.add_slip(slip=self.slip, wander=self.slip_wander, seed=int(self.seed))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return harmonics of the ball-pass order of the inner race, each with its sidebands of the shaft."""
        part = self.bearing(machine)
        order = pass_order(part, inner=True)
        count = harmonics(part, order, size_m=self.size_m, inner=True)
        sides = (0.0, part.shaft_ratio, -part.shaft_ratio)
        return tuple(pulse_line(k * order + side) for k in range(1, count + 1) for side in sides)
