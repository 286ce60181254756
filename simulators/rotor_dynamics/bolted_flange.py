"""Rigid (bolted) flange coupling between two rotors whose axes and hole circles are offset.

Every bolt is a linear spring in the plane between its hole on flange 1 and its hole on flange 2. In complex form
(x + i y), with z = z2 - z1 the relative motion of the rotor centres, phi1 and phi2 the rotors' total angles,

    gap_j = D + r e^(i alpha_j) (e^(i phi2) - e^(i phi1)),    D = z + s + h e^(i phi2)
    U     = K_b/2 sum_j w_j |gap_j|^2
          = K_b { W0 [ |D|^2 / 2 + r^2 (1 - cos(phi2 - phi1)) ] + r Re[ D* W1 (e^(i phi2) - e^(i phi1)) ] }

h is the offset of the hole circle on flange 2 (it turns with the flange), s the offset of axis 2 from axis 1 (it stands
still), w_j the share of its stiffness that bolt j still has, W0 = sum w_j, W1 = sum w_j e^(i alpha_j). The closed form
holds for any number of bolts and any w_j. With equal bolts W1 = 0, and with s = -h = -i delta it is

    U = N K_b { [(X - delta sin phi2)^2 + (Y - delta + delta cos phi2)^2] / 2 - r^2 cos(phi2 - phi1) } + const.

Source: Eq (6) of "Misalignment in rigidly coupled rotors" (paper 002 of this project), derived anew; the misprints of
Eqs (2) to (18) are listed in `machines/rigid_coupling.py`.

h alone turns and gives a 1X force W0 K_b |h|; s alone is a static preload of the shafts; a torque W0 K_b |s| |h| at 1X,
and with it 2X of the lateral motion, needs both (or a static z in the place of s).
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field

import numpy as np

from ..assembly import Assembly, Place, difference
from ..effect import Line
from ..errors import InvalidValueError
from ..law import Direction, InterfaceForce

#: How the flange's force is computed: from the potential, or linear in the motion (see `bolted_flange_linear`).
EXACT, LINEARISED, PRINTED = "exact", "linearised", "printed"


@dataclass
class BoltedFlange:
    """A flange coupling with the roles "coupling", "coupling_halves" and "bolted_coupling"; see the module.

    Parameters
    ----------
    name : str
    first, second : Place
        The rotors, with "x", "y" and "torsion".
    bolts : int
        N, 3 or more, at equal angles; bolt 1 on the x axis at shaft angle 0.
    bolt_stiffness_n_m : float
        K_b of one bolt, in any direction of the plane.
    bolt_circle_radius_m : float
        r.
    hole_offset_m : complex
        h at shaft angle 0, x + i y.
    axis_offset_m : complex
        s, x + i y.
    torsional_damping_n_m_s_rad : float
        Between the flanges.
    form : str
        "exact"; "linearised" about no motion and no twist; "printed", Eqs (15), (16) as they stand.
    printed_force_y_sign : float
        1 as printed, -1 to give Eq (16) the sense of rotation of Eq (15).
    stiffness_shares : ndarray (bolts,)
        w_j.
    unevenness : complex
        u of w_j = 1 + Re(u* e^(i alpha_j)) where no shares are given.
    """

    name: str
    first: Place
    second: Place
    bolts: int
    bolt_stiffness_n_m: float
    bolt_circle_radius_m: float
    hole_offset_m: complex = 0j
    axis_offset_m: complex = 0j
    torsional_damping_n_m_s_rad: float = 0.0
    form: str = EXACT
    printed_force_y_sign: float = 1.0
    roles: frozenset[str] = frozenset({"coupling", "coupling_halves", "bolted_coupling"})
    stiffness_shares: np.ndarray = field(default_factory=lambda: np.zeros(0))
    tilt_rad: float = 0.0
    unevenness: complex = 0j

    def __post_init__(self) -> None:
        if int(self.bolts) != self.bolts or self.bolts < 3:
            raise InvalidValueError(
                f"Flange {self.name} with {self.bolts} bolts; allowed: a whole number, 3 or more. Correct the number."
            )
        self.bolts = int(self.bolts)
        if self.stiffness_shares.size == 0:
            self.stiffness_shares = 1.0 + np.real(np.conj(self.unevenness) * np.exp(1j * self.bolt_angles_rad))

    @property
    def bolt_angles_rad(self) -> np.ndarray:
        """Angles alpha_j of the bolts on flange 1, shape (bolts,)."""
        return 2 * np.pi * np.arange(self.bolts) / self.bolts

    def between(self, direction: str) -> Direction:
        """Return the motion of flange 2 less that of flange 1; empty where neither moves."""
        return difference(self.second.directions.get(direction, {}), self.first.directions.get(direction, {}))

    def bolt_at(self, angle_rad: float) -> int:
        """Return the number (from 1) of the bolt nearest to this angle."""
        return round(angle_rad * self.bolts / (2 * math.pi)) % self.bolts + 1

    def weaken(self, bolt: int, *, loss: float) -> None:
        """Take the part ``loss`` (0 to 1) of its present stiffness from a bolt; 1 is a bolt that is missing.

        Raises
        ------
        InvalidValueError
        """
        if not (1 <= bolt <= self.bolts and 0.0 <= loss <= 1.0):
            raise InvalidValueError(
                f"Flange {self.name}: bolt {bolt} loses {loss:g} of its stiffness; allowed: bolt 1 to {self.bolts}, "
                "0 to 1. Correct bolt or loss."
            )
        self.stiffness_shares[bolt - 1] *= 1.0 - loss

    def misalign(
        self,
        *,
        offset_m: float = 0.0,
        angle_rad: float = 0.0,
        offset_phase_rad: float = 0.0,
        angle_phase_rad: float = 0.0,
    ) -> None:
        """Add a misalignment: h grows by offset e^(i phase), s by its opposite, so that bolts fit at shaft angle 0.

        An angle between the axes shortens the hole circle by (1 - cos angle), in the plane an effect of second order
        that cancels over equal bolts; the bending moment it makes needs tilting rotors, which this plane model has
        not. So the angle changes nothing here, and a note of the machine says so.

        Parameters
        ----------
        offset_m : float
        angle_rad : float
        offset_phase_rad : float
            Direction of the hole circle's offset at shaft angle 0, from x towards y.
        angle_phase_rad : float
        """
        step = offset_m * cmath.exp(1j * offset_phase_rad)
        self.hole_offset_m += step
        self.axis_offset_m -= step
        self.tilt_rad = max(self.tilt_rad, abs(angle_rad))

    def misalignment_lines(self) -> tuple[Line, ...]:
        """Return the lines that an offset raises: 1X of the rotors, 1X of the twist.

        2X of the rotors rises too, with the third power of the offset; it shows near the torsional resonance only.
        """
        ratio = self.second.shaft_ratio
        return (Line(ratio, speed_exponent=0.0), Line(ratio, "torsion"))

    def stationary_misalignment_lines(self) -> tuple[Line, ...]:
        """Return the lines of an elongation that stands still (alignment, sag): 1X of the twist, 2X of the rotors."""
        ratio = self.second.shaft_ratio
        return (Line(ratio, "torsion"), Line(2 * ratio))

    def stiffness_moments(self) -> tuple[float, complex]:
        """Return W0 = sum w_j and W1 = sum w_j exp(i alpha_j)."""
        if np.all(self.stiffness_shares == self.stiffness_shares[0]):
            return float(self.stiffness_shares.sum()), 0j
        return (
            float(self.stiffness_shares.sum()),
            complex(np.sum(self.stiffness_shares * np.exp(1j * self.bolt_angles_rad))),
        )

    def potential_j(self, relative_m: complex, first_angle_rad: float, second_angle_rad: float) -> float:
        """Return the energy in the bolts for z = z2 - z1 and the total angles of both rotors, J."""
        total, first_moment = self.stiffness_moments()
        turned = cmath.exp(1j * second_angle_rad)
        twist = turned - cmath.exp(1j * first_angle_rad)
        gap = relative_m + self.axis_offset_m + self.hole_offset_m * turned
        radius = self.bolt_circle_radius_m
        even = abs(gap) ** 2 / 2 + radius**2 * (1 - math.cos(second_angle_rad - first_angle_rad))
        uneven = radius * (gap.conjugate() * first_moment * twist).real
        return self.bolt_stiffness_n_m * (total * even + uneven)

    def law_parameters(self) -> tuple[float, ...]:
        """Return what the laws need: K W0, K r W1, K W0 r^2, h, s (complex numbers as two), shaft ratio."""
        total, first_moment = self.stiffness_moments()
        stiffness, radius = self.bolt_stiffness_n_m, self.bolt_circle_radius_m
        uneven = stiffness * radius * first_moment
        hole, axis = self.hole_offset_m, self.axis_offset_m
        return (
            stiffness * total,
            *(uneven.real, uneven.imag),
            stiffness * total * radius**2,
            *(hole.real, hole.imag),
            *(axis.real, axis.imag),
            self.second.shaft_ratio,
        )

    def finish(self, assembly: Assembly) -> None:
        """Add the springs of an aligned flange to the linear core, and the rest as an interface force."""
        relative = {key: self.between(key) for key in "xy"}
        turns = (self.first.directions["torsion"], self.second.directions["torsion"])
        twist = difference(turns[1], turns[0])
        parameters = self.law_parameters()
        printed = self.form == PRINTED
        # Eqs (14), (18): a lost bolt changes the printed offset sum, not the printed mean stiffness.
        lateral = self.bolt_stiffness_n_m * self.bolts if printed else parameters[0]
        for along in relative.values():
            assembly.add_spring(along, stiffness=lateral)
        torsional = lateral * self.bolt_circle_radius_m**2
        assembly.add_spring(twist, stiffness=torsional, damping=self.torsional_damping_n_m_s_rad)
        if self.tilt_rad:
            assembly.notes.append(
                f"{self.name}: an angle of {self.tilt_rad:g} rad between the axes changes nothing here, because the "
                "rotors of this machine move in their plane and do not tilt."
            )
        if printed:
            from .bolted_flange_linear import PRINTED_FLANGE

            lines = (relative["x"], relative["y"], twist)
            assembly.forces.append(InterfaceForce(self.name, PRINTED_FLANGE, self._printed_parameters(), lines, lines))
            return
        if self.form == LINEARISED:
            from .bolted_flange_linear import LINEARISED_FLANGE as law
        else:
            from .bolted_flange_exact import EXACT_FLANGE as law
        motions = (relative["x"], relative["y"], *turns)
        assembly.forces.append(InterfaceForce(self.name, law, parameters, motions, motions))

    def _printed_parameters(self) -> tuple[float, ...]:
        """Return K_b S, delta, sign of F_y and shaft ratio, S = N delta / 2 less printed R_j of lost bolts, Eq (18)."""
        offset = self.hole_offset_m
        if abs(offset.real) > 1e-9 * abs(offset):
            raise InvalidValueError(
                f"Flange {self.name}: hole circle offset by {offset.real:g} m in x; allowed with the printed "
                "equations: a vertical offset only. Use offset_phase_rad = pi/2 or the preset plausible."
            )
        delta = offset.imag
        # Eq (3) as printed adds metres to a pure number; kept.
        radii = self.bolt_circle_radius_m * np.sqrt(1 + delta**2 + 2 * delta * np.cos(self.bolt_angles_rad))
        offset_sum = self.bolts * delta / 2 - float(np.sum((1 - self.stiffness_shares) * radii))
        return (
            self.bolt_stiffness_n_m * offset_sum,
            delta,
            self.printed_force_y_sign,
            self.second.shaft_ratio,
        )
