"""What the effects on a rolling bearing share: size, slip of the cage, the bearing's orders, its lines."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.bearing_damage import pit_half_angle_rad

if TYPE_CHECKING:
    from ..machine import Machine

RANDALL = (
    "R. B. Randall and J. Antoni, Rolling element bearing diagnostics - a tutorial, Mech. Syst. Signal Process. 25 "
    "(2011) 485-520"
)
SAWALHI = (
    "N. Sawalhi and R. B. Randall, Simulating gear and bearing interactions in the presence of faults, "
    "Mech. Syst. Signal Process. 22 (2008) 1924-1951"
)
MCFADDEN = (
    "P. D. McFadden and J. D. Smith, Model for the vibration produced by a single point defect in a rolling element "
    "bearing, J. Sound Vib. 96 (1984) 69-82"
)
#: More harmonics than this say nothing new.
MOST_HARMONICS = 40


def size_parameter(meaning: str) -> Any:
    """Return the declaration of a defect's size along its race."""
    return parameter(
        unit="m",
        bounds=(0.0, 5e-3),
        zero=0.0,
        prior=LogNormal(1e-3, 2.0),
        meaning=meaning,
        source="estimate: spalls are found at 0.5 to 2 mm; the Case Western tests seed 0.18 to 0.7 mm",
    )


@dataclass(frozen=True, kw_only=True)
class BearingEffect(Effect):
    """An effect in a rolling bearing whose cage slips. See `rotor_dynamics.bearing_damage` for the laws."""

    STAGE = "structure"
    ROLE = "bearing"

    slip: float = parameter(
        unit="",
        bounds=(0.0, 0.1),
        zero=0.0,
        prior=Uniform(0.0, 0.03),
        meaning="share by which the cage lags behind pure rolling; the largest holds where effects differ",
        source="Randall and Antoni 2011: lines deviate from their computed orders by 1 to 2 %",
    )
    slip_wander: float = parameter(
        unit="",
        bounds=(0.0, 0.05),
        zero=0.0,
        prior=Uniform(0.0, 0.01),
        meaning="standard deviation of the cage's speed over its mean, slow against a turn of the cage",
        source="estimate: a part of the 1 to 2 % of Randall and Antoni 2011 is random",
    )
    seed: float = parameter(
        unit="",
        bounds=(0.0, 1e6),
        default=1.0,
        meaning="number from which the wander is drawn; the same number gives the same run",
        source="any whole number",
    )

    def bearing(self, machine: Machine) -> Any:
        """Return the bearing that is meant, with its slip: the largest of this effect's and those of others."""
        part = self.parts(machine).component(self.ROLE, self.at)
        part.damage.add_slip(slip=self.slip, wander=0.0, seed=0)
        return part


def pass_order(part: Any, *, inner: bool) -> float:
    """Return the order of the reference shaft at which balls pass a point of a race, slip included."""
    cage = part.damage.cage_order(part.geometry, part.shaft_ratio)
    return part.geometry.balls * (part.shaft_ratio - cage if inner else cage)


def harmonics(part: Any, order: float, *, size_m: float, inner: bool) -> int:
    """Return how many harmonics of ``order`` lie below the first gap of the spectrum of one pass over the pit.

    A pulse that lasts the angle 2 a0 of relative motion has its first gap near the order 1.5 / (2 a0) turns.
    """
    cage = part.damage.cage_order(part.geometry, part.shaft_ratio)
    relative = part.shaft_ratio - cage if inner else cage
    width = 2 * pit_half_angle_rad(part.geometry, size_m=max(size_m, 1e-4), inner=inner) / relative
    return max(1, min(MOST_HARMONICS, math.floor(1.5 * 2 * math.pi / width / order)))


def pulse_line(order: float) -> Line:
    """Return a line of pulses that take away what a ball carries: in proportion to the load, whatever the speed."""
    return Line(order, speed_exponent=0.0, load_exponent=1.0)
