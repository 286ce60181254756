"""Bolt loss: one bolt of a flange coupling is loose, cracked or missing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import Uniform, parameter

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class BoltLoss(Effect):
    """K_j -> (1 - loss) K_j of one bolt: its share of the torque becomes a force turning with the shaft.

    A steady torque T over N bolts on the radius r then pushes the shaft with about loss T / (N r) at 1X. Where the axes
    are offset by s as well, the uneven flange makes a torque loss K r |s| at 1X, and with it 2X of the shaft. The push
    grows with the load, the torque with the offset; neither grows with speed.
    """

    NAME = "bolt_loss"
    STAGE = "structure"
    ROLE = "bolted_coupling"
    MEANING = "One bolt of a flange coupling carries less than its share, or nothing."
    CHECK = "Are all coupling bolts there and tight? Check their torque or elongation, the nuts' marks, the bolt holes."
    RIVALS = {
        "unbalance": "two or more speeds at the same load: the force of unbalance grows as speed^2",
        "rotating_coupling_force": "torsional 1X and 2X; they belong to the lost bolt only",
        "coupling_misalignment": "alignment check; retighten the bolts one by one",
        "torque_ripple": "load torque constant, speed changed: lines of a lost bolt stay on 1X and 2X of the coupling",
    }
    REFERENCES = ("A. W. Lees, Misalignment in rigidly coupled rotors, J. Sound Vib. 305 (2007) 261-271, Eq (18)",)

    loss: float = parameter(
        unit="",
        bounds=(0.0, 1.0),
        zero=0.0,
        prior=Uniform(0.0, 1.0),
        meaning="share of the bolt's stiffness that is gone; 1 for a missing bolt",
        source="from slightly loose to missing, all equally likely",
    )
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="angle of the bolt from x at shaft angle 0, in the sense of rotation; the nearest bolt is meant",
        source="any bolt is equally likely",
        chooses=True,
    )

    def contribute(self, assembly: Assembly) -> None:
        """Weaken the bolt nearest to the angle."""
        flange = assembly.component(self.ROLE, self.at)
        flange.weaken(flange.bolt_at(self.angle_rad), loss=self.loss)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X of the twist and 2X of the shaft (1X rises or falls, by load and offset)."""
        ratio = machine.bare_assembly().component(self.ROLE, self.at).second.shaft_ratio
        return (Line(ratio, "torsion"), Line(2 * ratio))
