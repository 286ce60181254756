"""Coupling whose two hubs are offset: its housing circles at twice the shaft speed and pulls at the rotor.

The hubs turn about parallel axes, offset by the vector d. The housing slides on one hub along the direction theta and
on the other at right angles to it, so its centre stays on the circle over the diameter d (as in an Oldham coupling):

    centre = middle + conj(d)/2 exp(2 i theta),   force = -m_c centre'' = m_c conj(d) (2 w^2 - i dw/dt) exp(2 i theta)

in complex form x + i y: a force of 2 m_c w^2 |d| that turns at 2X, forward, whatever the direction of the offset.

Source: the bearing-rotor-gear study (paper 001 of this project), Eqs (9)-(13), |d| = offset + gap tan(angle). The same
as there but for two things. Its Eq (12) states a modulus that is negative; the sign used here follows from Eqs (1) and
(10). Its (sin 2 theta, cos 2 theta) measures theta from y towards x while its ball angles count from x towards y, so
that force and balls turn in opposite senses; ``against_rotation=True`` gives the printed sense.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from ..assembly import Assembly, Place
from ..effect import Line
from ..errors import InvalidValueError
from ..law import InterfaceForce
from .harmonic_force import ROTATING_MASS

#: Angular misalignment above this leaves the small-angle geometry of the source.
LARGEST_ANGLE_RAD = math.radians(30)


@dataclass
class RigidOffsetCoupling:
    """A coupling that transmits its housing's inertia force when misaligned, and nothing else.

    Parameters
    ----------
    name : str
    place : Place
        Where the force acts, with "x" and "y".
    housing_mass_kg : float
        m_c.
    gap_m : float
        Distance between the two joints, over which an angle becomes an offset.
    against_rotation : bool
        True for the sense of turning that the source prints.
    """

    name: str
    place: Place
    housing_mass_kg: float
    gap_m: float
    against_rotation: bool = False
    roles: frozenset[str] = frozenset({"coupling"})
    offset_m: complex = 0j
    is_misaligned: bool = False

    def misalign(
        self,
        *,
        offset_m: float = 0.0,
        angle_rad: float = 0.0,
        offset_phase_rad: float = 0.0,
        angle_phase_rad: float = 0.0,
    ) -> None:
        """Add a misalignment, parallel plus angular, Eq (9): d = offset e^(i phase) + gap tan(angle) e^(i phase).

        Parameters
        ----------
        offset_m : float
        angle_rad : float
            Between the two axes, up to 30 degrees.
        offset_phase_rad, angle_phase_rad : float
            Direction of each in space, from x towards y.
        """
        if not abs(angle_rad) <= LARGEST_ANGLE_RAD:
            raise InvalidValueError(
                f"Misalignment angle {angle_rad} rad; allowed: up to {LARGEST_ANGLE_RAD:.3g} rad (30 degrees). "
                "Check the unit."
            )
        self.is_misaligned = True
        self.offset_m += offset_m * cmath.exp(1j * offset_phase_rad)
        self.offset_m += self.gap_m * math.tan(angle_rad) * cmath.exp(1j * angle_phase_rad)

    def misalignment_lines(self) -> tuple[Line, ...]:
        """Return the line that a misalignment raises: 2X."""
        return (Line(2 * self.place.shaft_ratio, speed_exponent=2.0),)

    def finish(self, assembly: Assembly) -> None:
        """Add the force of the circling housing, once misaligned."""
        if not self.is_misaligned:
            return
        moment = self.housing_mass_kg * self.offset_m.conjugate() / 2
        outputs = (self.place.directions["x"], self.place.directions["y"])
        if self.against_rotation:
            outputs = outputs[::-1]
        order = 2 * self.place.shaft_ratio
        assembly.forces.append(
            InterfaceForce(f"{self.name} housing", ROTATING_MASS, (order, moment.real, moment.imag), outputs)
        )
