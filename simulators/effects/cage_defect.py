"""Cage defect: one ball runs out of its place because its pocket is worn or the cage is cracked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Line
from ..parameter import LogNormal, parameter
from ._bearing_defect import RANDALL, BearingEffect, pass_order, pulse_line

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class CageDefect(BearingEffect):
    """One ball lags its even place by s along the pitch circle: lines at the cage order FTF and at BPFO +- m FTF.

    The support is then softer on one side, and the soft side turns with the cage. The lines are weak, low in frequency
    and grow with load (exponent 1; with Hertz contacts the displacement only as load^(2/3)); with speed the force
    stays, acceleration grows as speed^2. Left out: blows of balls on the pockets, rub of the cage on a ring, bunching
    of balls that changes within a turn, all of which a broken cage has as well.
    """

    NAME = "cage_defect"
    MEANING = "A worn pocket or cracked cage lets one ball run out of its place; the support pulses with the cage."
    CHECK = "Acceleration or displacement at 0.35 to 0.45 X and its multiples; is the cage worn, is it starved of oil?"
    RIVALS = {
        "oil_whirl": "rolling bearing, constant fraction at every speed, multiples of the cage order round BPFO",
        "looseness": "no exact half orders; sidebands of the cage round the ball-pass order",
        "ball_defect": "no raised resonance: the lines are the cage order itself and sidebands of the ball pass",
    }
    REFERENCES = (RANDALL, "T. A. Harris, Rolling Bearing Analysis, 4th ed., Wiley 2001")

    size_m: float = parameter(
        unit="m",
        bounds=(0.0, 5e-3),
        zero=0.0,
        prior=LogNormal(1e-3, 2.0),
        meaning="distance s by which the first ball lags its even place, along the pitch circle",
        source="estimate: new pockets have some tenths of a millimetre of play, worn ones a multiple",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Shift the first ball of the chosen bearing; all balls are alike."""
        part = assembly.component(self.ROLE, self.at)
        part.damage.shift_ball(ball=0, distance_m=self.size_m)
        part.damage.add_slip(slip=self.slip, wander=self.slip_wander, seed=int(self.seed))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the cage order and the ball pass of the outer race with its sidebands."""
        part = self.bearing(machine)
        cage = part.damage.cage_order(part.geometry, part.shaft_ratio)
        order = pass_order(part, inner=False)
        multiples = [k * cage for k in range(1, part.geometry.balls)]
        return tuple(pulse_line(value) for value in (*multiples, order, order + cage, order + 2 * cage))
