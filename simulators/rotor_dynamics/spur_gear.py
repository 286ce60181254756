"""One involute spur gear: geometry, and how far a loaded tooth gives (potential-energy method).

The tooth is a beam of varying section, loaded by F at the contact point in the direction of the line of action, plus
the gear body below it. Strain energy gives the displacement along F per unit of F: bending, shear, axial compression,
fillet foundation.

References: X. Liang, M. J. Zuo, T. H. Patel, "Evaluating the time-varying mesh stiffness of a planetary gear set using
the potential energy method", Proc. IMechE C 228 (2014) 535-547 (root circle below the base circle); P. Sainsot,
P. Velex, O. Duverger, "Contribution of gear body to tooth deflections - a new bidimensional analytical formula",
J. Mech. Design 126 (2004) 748-752.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..errors import InvalidValueError
from .shaft_parts import Material, require_positive

# Sainsot 2004, table 1: rows L*, M*, P*, Q*; factors of 1/theta^2, h^2, h/theta, 1/theta, h, 1.
_BODY = np.array(
    [
        [-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045],
        [60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086],
        [-50.952e-5, 185.50e-3, 0.0538e-4, 53.300e-3, 0.2895, 0.9236],
        [-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904],
    ]
)
#: Range of root radius over bore radius in which Sainsot's fit holds.
BODY_RATIO = (1.4, 7.0)
# Shear correction of a rectangular section, as in the sources.
_SHEAR_FACTOR = 1.2
# 24 points integrate the smooth beam integrands to round-off.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True)
class SpurGear:
    """An involute spur gear without profile shift.

    Parameters
    ----------
    teeth : int
        Number of teeth, at least 5.
    module_m, face_width_m : float
        Module and face width in metres.
    pressure_angle_rad : float
        At the pitch circle, 10 to 35 degrees; usually 20.
    bore_radius_m : float
        Radius in metres on which the gear body is held rigidly: of the bore, or of the shaft that it is one piece
        with. Root radius over bore radius must be 1.4 to 7, the range of the body's formula. It matters: the body
        gives about half of the compliance.
    material : Material
        Of the gear; density is not used here.
    addendum, dedendum : float
        Height of the tooth above and depth below the pitch circle, in modules; 1 and 1.25 by ISO 53.
    """

    teeth: int
    module_m: float
    face_width_m: float
    pressure_angle_rad: float
    bore_radius_m: float
    material: Material
    addendum: float = 1.0
    dedendum: float = 1.25

    def __post_init__(self) -> None:
        for name in ("module_m", "face_width_m", "bore_radius_m", "addendum", "dedendum"):
            require_positive(name, getattr(self, name))
        if self.teeth < 5:
            raise InvalidValueError(f"Gear has {self.teeth} teeth; allowed: at least 5. Check the number.")
        if not math.radians(10) <= self.pressure_angle_rad <= math.radians(35):
            raise InvalidValueError(
                f"Pressure angle {self.pressure_angle_rad} rad; allowed: 0.175 to 0.61 (10 to 35 degrees). "
                "20 degrees are 0.349 rad."
            )
        ratio = self.root_radius_m / self.bore_radius_m
        if not BODY_RATIO[0] * (1 - 1e-9) <= ratio <= BODY_RATIO[1] * (1 + 1e-9):
            low, high = (self.root_radius_m / limit for limit in reversed(BODY_RATIO))
            raise InvalidValueError(
                f"Bore radius {self.bore_radius_m} m; allowed for this gear: {low:.4g} to {high:.4g} m. Outside "
                "the formula of the gear body does not hold; give the radius at which the body is as good as rigid."
            )
        if self.tooth_half_width_m(self.tip_roll_angle_rad) <= 0:
            raise InvalidValueError(
                f"Teeth of {self.addendum} modules above the pitch circle end in a point before their tip. "
                "Give a smaller addendum."
            )

    @property
    def pitch_radius_m(self) -> float:
        """Pitch radius m z / 2."""
        return self.module_m * self.teeth / 2

    @property
    def base_radius_m(self) -> float:
        """Base radius, pitch radius times the cosine of the pressure angle."""
        return self.pitch_radius_m * math.cos(self.pressure_angle_rad)

    @property
    def tip_radius_m(self) -> float:
        """Tip radius."""
        return self.pitch_radius_m + self.addendum * self.module_m

    @property
    def root_radius_m(self) -> float:
        """Root radius."""
        return self.pitch_radius_m - self.dedendum * self.module_m

    @property
    def base_half_angle_rad(self) -> float:
        """Half of a tooth's angle on the base circle, pi / (2 z) + tan(alpha) - alpha."""
        alpha = self.pressure_angle_rad
        return math.pi / (2 * self.teeth) + math.tan(alpha) - alpha

    @property
    def tip_roll_angle_rad(self) -> float:
        """Roll angle at the tip; the roll angle is the tangent of the pressure angle at a point of the flank."""
        return math.sqrt((self.tip_radius_m / self.base_radius_m) ** 2 - 1)

    @property
    def start_roll_angle_rad(self) -> float:
        """Roll angle at which the flank starts: 0 on the base circle, more where the root circle is larger."""
        return math.sqrt(max((self.root_radius_m / self.base_radius_m) ** 2 - 1, 0.0))

    def tooth_half_width_m(self, roll_angle_rad: float) -> float:
        """Return the distance of a flank point from the tooth's centre line in metres."""
        return float(self._flank_point(np.asarray(roll_angle_rad, dtype=float))[1])

    def _flank_point(self, roll: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return height above the gear centre and half width of flank points, in metres."""
        lean = roll - self.base_half_angle_rad
        height = np.cos(lean) + roll * np.sin(lean)
        return self.base_radius_m * height, self.base_radius_m * (roll * np.cos(lean) - np.sin(lean))

    def beam_compliance_m_n(self, roll_angle_rad: np.ndarray) -> np.ndarray:
        """Return the compliance of one tooth as a beam in m/N: bending, shear and axial compression.

        With the force at the angle a = roll - base half angle from the normal of the centre line, at the height x_c
        and half width h_c: integral over the height x of the tooth from the root of
        [(x_c - x) cos a - h_c sin a]^2 / (E I) + 1.2 cos^2 a / (G A) + sin^2 a / (E A), with A = 2 h W and
        I = 2/3 h^3 W. Below the base circle the tooth keeps its width down to the root circle, without fillet; where
        the root circle is above the base circle the tooth starts there.

        Parameters
        ----------
        roll_angle_rad : numpy.ndarray
            Roll angle of the contact point (tangent of its pressure angle), any shape.

        Returns
        -------
        numpy.ndarray
            Same shape.
        """
        contact = np.asarray(roll_angle_rad, dtype=float)[..., np.newaxis]
        start, half = self.start_roll_angle_rad, (contact - self.start_roll_angle_rad) / 2
        roll = start + half * (_NODES + 1)
        height, width = self._flank_point(roll)
        lean = roll - self.base_half_angle_rad
        steps = half * _WEIGHTS * self.base_radius_m * roll * np.cos(lean)
        flank = (steps * self._energy_density(contact, height, width)).sum(axis=-1)
        low, base = self._straight_part_m()
        if low >= base:
            return flank
        heights = low + (base - low) / 2 * (_NODES + 1)
        root = self._energy_density(contact, heights, np.full_like(heights, self.tooth_half_width_m(0.0)))
        return flank + (base - low) / 2 * (_WEIGHTS * root).sum(axis=-1)

    def _straight_part_m(self) -> tuple[float, float]:
        """Return lowest and highest height of the part of constant width; equal where there is none."""
        half_width = self.base_radius_m * math.sin(self.base_half_angle_rad)
        base = self.base_radius_m * math.cos(self.base_half_angle_rad)
        if self.root_radius_m >= self.base_radius_m:
            return base, base
        return math.sqrt(self.root_radius_m**2 - half_width**2), base

    def _energy_density(self, contact: np.ndarray, height: np.ndarray, half_width: np.ndarray) -> np.ndarray:
        """Return twice the strain energy per height of the tooth for unit force, in m/N per m."""
        lean = contact - self.base_half_angle_rad
        contact_height, contact_width = self._flank_point(contact)
        return beam_energy_density(
            lever_m=(contact_height - height) * np.cos(lean) - contact_width * np.sin(lean),
            lean_rad=lean,
            half_width_m=half_width,
            face_width_m=self.face_width_m,
            material=self.material,
        )

    def crack_compliance_m_n(self, roll_angle_rad: np.ndarray, *, depth: float, crack_angle_rad: float) -> np.ndarray:
        """Return what a crack at the tooth's root adds to its compliance, in m/N.

        The crack starts at the root, is q = depth times the thickness 2 h_r of the widest section deep, and inclined by
        v to the tooth's centre line. Sections of half width h above h_c = h_r - q sin v lose what lies beyond h_c on
        the cracked side: thickness h + h_c instead of 2 h, in bending (I = t^3 W / 12) and shear (A = t W). Axial
        compression, gear body and contact stay: an open crack closes under pressure. Source: S. Wu, M. J. Zuo,
        A. Parey, "Simulation of spur gear dynamics and estimation of fault growth", J. Sound Vib. 317 (2008) 608-624.

        Parameters
        ----------
        roll_angle_rad : numpy.ndarray
            Roll angle of the contact point, any shape.
        depth : float
            Crack depth over the thickness of the tooth's root, 0 to 0.65: somewhat beyond the centre line.
        crack_angle_rad : float
            Angle v, above 0, at most pi/2.
        """
        if not (0 <= depth <= 0.65 and 0 < crack_angle_rad <= math.pi / 2 + 1e-9):
            raise InvalidValueError(
                f"Tooth crack of depth {depth:g} at {crack_angle_rad:g} rad; allowed: 0 to 0.65 of the root, "
                "above 0 to pi/2. A deeper crack is a tooth about to break."
            )
        start = self.start_roll_angle_rad
        root = self.tooth_half_width_m(self._widest_roll_rad)
        left = root * (1 - 2 * depth * math.sin(crack_angle_rad))
        contact = np.asarray(roll_angle_rad, dtype=float)[..., np.newaxis]
        half = (np.minimum(contact, self._roll_at_half_width(left)) - start) / 2
        roll = start + half * (_NODES + 1)
        height, width = self._flank_point(roll)
        steps = half * _WEIGHTS * self.base_radius_m * roll * np.cos(roll - self.base_half_angle_rad)
        added = (steps * self._crack_density(contact, height, width, left)).sum(axis=-1)
        low, base = self._straight_part_m()
        if low < base:
            heights = low + (base - low) / 2 * (_NODES + 1)
            width = np.full_like(heights, self.tooth_half_width_m(0.0))
            density = self._crack_density(contact, heights, width, left)
            added = added + (base - low) / 2 * (_WEIGHTS * density).sum(axis=-1)
        return added

    @property
    def _widest_roll_rad(self) -> float:
        """Roll angle at which the flank is widest: the involute swells by a trace above the base circle."""
        return max(self.start_roll_angle_rad, self.base_half_angle_rad)

    def _roll_at_half_width(self, half_width_m: float) -> float:
        """Return the roll angle at which the flank has this half width, at most that of the tip."""
        low, high = self._widest_roll_rad, self.tip_roll_angle_rad
        if self.tooth_half_width_m(high) >= half_width_m:
            return high
        # From the widest section to the tip the half width falls; 60 halvings leave round-off.
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if self.tooth_half_width_m(middle) > half_width_m else (low, middle)
        return low

    def _crack_density(
        self, contact: np.ndarray, height: np.ndarray, half_width: np.ndarray, left_m: float
    ) -> np.ndarray:
        """Return what the crack adds to `_energy_density`."""
        lean = contact - self.base_half_angle_rad
        contact_height, contact_width = self._flank_point(contact)
        lever = (contact_height - height) * np.cos(lean) - contact_width * np.sin(lean)
        whole, cracked = 2 * half_width, half_width + np.minimum(half_width, left_m)
        bending = 12 * lever**2 / self.material.youngs_modulus_pa * (cracked**-3 - whole**-3)
        shear = _SHEAR_FACTOR * np.cos(lean) ** 2 / self.material.shear_modulus_pa * (1 / cracked - 1 / whole)
        return (bending + shear) / self.face_width_m

    def body_compliance_m_n(self, roll_angle_rad: np.ndarray) -> np.ndarray:
        """Return the compliance of the gear body under the tooth in m/N (Sainsot, Velex and Duverger 2004).

        cos^2 a / (W E) [L* (u/S)^2 + M* u/S + P* (1 + Q* tan^2 a)], u being the distance from the root circle to where
        the line of action cuts the centre line and S the tooth thickness on the root circle. The formula was fitted
        for half tooth angles of 0.01 to 0.12 rad at the root. Neighbouring loaded teeth are taken as independent.
        """
        lean = np.asarray(roll_angle_rad, dtype=float) - self.base_half_angle_rad
        angle = self.root_half_angle_rad
        ratio = self.root_radius_m / self.bore_radius_m
        factors = _BODY @ np.array([1 / angle**2, ratio**2, ratio / angle, 1 / angle, ratio, 1.0])
        reach = (self.base_radius_m / np.cos(lean) - self.root_radius_m) / (2 * self.root_radius_m * angle)
        bracket = factors[0] * reach**2 + factors[1] * reach + factors[2] * (1 + factors[3] * np.tan(lean) ** 2)
        return np.cos(lean) ** 2 / (self.face_width_m * self.material.youngs_modulus_pa) * bracket

    @property
    def root_half_angle_rad(self) -> float:
        """Half of a tooth's angle on the root circle, seen from the gear centre."""
        start = self.start_roll_angle_rad
        if start > 0:
            return self.base_half_angle_rad - (start - math.atan(start))
        return math.asin(self.base_radius_m * math.sin(self.base_half_angle_rad) / self.root_radius_m)

    def tooth_compliance_m_n(self, roll_angle_rad: np.ndarray) -> np.ndarray:
        """Return beam and body compliance of one tooth together, in m/N, without the contact; any shape."""
        return self.beam_compliance_m_n(roll_angle_rad) + self.body_compliance_m_n(roll_angle_rad)


def beam_energy_density(
    *,
    lever_m: np.ndarray,
    lean_rad: np.ndarray,
    half_width_m: np.ndarray,
    face_width_m: float,
    material: Material,
) -> np.ndarray:
    """Return displacement along a unit force per height of a rectangular section, in m/N per m.

    lever^2 / (E I) + 1.2 cos^2 a / (G A) + sin^2 a / (E A); A = 2 h W, I = 2/3 h^3 W for the half width h.

    Parameters
    ----------
    lever_m : numpy.ndarray
        Bending moment at the section per unit force.
    lean_rad : numpy.ndarray
        Angle a between force and normal of the centre line.
    half_width_m : numpy.ndarray
        Half of the tooth's thickness at the section.
    face_width_m : float
        Width W of the section.
    material : Material
        Of the tooth.
    """
    area = 2 * half_width_m * face_width_m
    moment = 2 / 3 * half_width_m**3 * face_width_m
    bending = lever_m**2 / (material.youngs_modulus_pa * moment)
    shear = _SHEAR_FACTOR * np.cos(lean_rad) ** 2 / (material.shear_modulus_pa * area)
    return bending + shear + np.sin(lean_rad) ** 2 / (material.youngs_modulus_pa * area)
