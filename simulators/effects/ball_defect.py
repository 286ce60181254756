"""Ball defect: a spot on one ball of a rolling bearing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Line
from ..parameter import Uniform, parameter
from ._bearing_defect import MOST_HARMONICS, RANDALL, SAWALHI, BearingEffect, pulse_line, size_parameter

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine

#: Harmonics of the cage that the envelope of a ball's strikes holds.
CAGE_HARMONICS = 3


@dataclass(frozen=True, kw_only=True)
class BallDefect(BearingEffect):
    """The spot meets each race once a turn of the ball: lines at 2 k BSF, with sidebands of the cage, +- m FTF.

    The ball carries load only while the cage takes it through the load zone. Odd multiples of BSF stay small: the two
    races differ in curvature only. Growth with load (exponent 1), speed and size as for `outer_race_defect`. Left out:
    a ball's spin axis wanders, so that a real spot is missed for many turns and the line comes and goes.
    """

    NAME = "ball_defect"
    MEANING = "A spot on one ball strikes both races in turn while the ball is in the load zone."
    CHECK = "Envelope spectrum at twice the ball-spin order with sidebands of the cage; does the line come and go?"
    RIVALS = {
        "outer_race_defect": "order: twice the ball spin, not the ball-pass order; sidebands of the cage, not none",
        "inner_race_defect": "sidebands of the cage order instead of 1X",
        "cage_defect": "lines far above the cage order, in the envelope of a resonance",
    }
    REFERENCES = (RANDALL, SAWALHI)

    size_m: float = size_parameter("length s of the spot along the ball's track")
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="angle of the spot from the contact with the outer race at shaft angle 0, in the sense of the spin",
        source="any angle is equally likely",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Put the spot onto the first ball of the chosen bearing; all balls are alike."""
        part = assembly.component(self.ROLE, self.at)
        part.damage.add_spot(ball=0, size_m=self.size_m, angle_rad=self.angle_rad)
        part.damage.add_slip(slip=self.slip, wander=self.slip_wander, seed=int(self.seed))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return twice the ball spin with its sidebands of the cage, the cage, then harmonics of the ball spin.

        The load zone lets the strikes through once a turn of the cage: a train that comes and goes holds that rhythm
        itself, in its envelope with several harmonics as clear as the strikes' own.
        """
        part = self.bearing(machine)
        orders = part.geometry.defect_orders()
        cage = part.damage.cage_order(part.geometry, part.shaft_ratio)
        twice = 2 * orders.ball_spin / orders.cage * cage
        # One pass lasts 2 s / d of the ball's turn; see `harmonics` for races.
        lasting = 2 * max(self.size_m, 1e-4) / part.geometry.ball_diameter_m
        count = max(1, min(MOST_HARMONICS, math.floor(1.5 * math.pi / lasting)))
        struck = [pulse_line(k * twice + side) for k in range(1, count + 1) for side in (0.0, cage, -cage)]
        coming = [pulse_line(m * cage) for m in range(1, CAGE_HARMONICS + 1)]
        return (*struck[:3], *coming, *struck[3:])
