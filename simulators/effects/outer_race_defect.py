"""Outer race defect: a pit in the standing race of a rolling bearing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Line
from ..parameter import Normal, parameter
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
class OuterRaceDefect(BearingEffect):
    """Every ball sinks into the pit by up to s^2 / (8 R) and is relieved of its load there: lines at k BPFO.

    The pit stands in the load zone, so that all passes are alike and there are no sidebands. The force that a ball
    loses is at most its load: the lines grow with load (exponent 1) and, for a pit deeper than the ball's approach,
    not with its size, which changes the pulse's length. With speed the force stays and its spectrum widens, so that
    acceleration grows about as speed^2. Left out: see `rotor_dynamics.bearing_damage`.
    """

    NAME = "outer_race_defect"
    MEANING = "A pit or spall in the outer race; every ball that passes it is relieved and strikes its far edge."
    CHECK = "Envelope spectrum at the ball-pass order of the outer race; grease with metal, tapping noise, spall?"
    RIVALS = {
        "gear_eccentricity": "no whole order: lines 1-2 % below the computed ball-pass order, and they wander",
        "inner_race_defect": "no sidebands at 1X; a sensor round the housing shows one strongest direction",
        "clearance_growth": "few harmonics without a raised resonance; the envelope stays flat",
    }
    REFERENCES = (RANDALL, SAWALHI, MCFADDEN)

    size_m: float = size_parameter("length s of the pit along the outer race")
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Normal(0.0, 0.5),
        meaning="angle of the pit from the direction of the bearing's steady load, in the sense of rotation",
        source="estimate: fatigue begins where the load is highest; two thirds within 30 degrees",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Put the pit into the outer race of the chosen bearing."""
        part = assembly.component(self.ROLE, self.at)
        part.damage.add_pit(inner=False, size_m=self.size_m, angle_rad=part.load_angle_rad + self.angle_rad)
        part.damage.add_slip(slip=self.slip, wander=self.slip_wander, seed=int(self.seed))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the harmonics of the ball-pass order of the outer race that one pass excites."""
        part = self.bearing(machine)
        order = pass_order(part, inner=False)
        count = harmonics(part, order, size_m=self.size_m, inner=False)
        return tuple(pulse_line(k * order) for k in range(1, count + 1))
