"""Mesh stiffness of a spur gear pair over one tooth pitch, by the potential-energy method.

Eq (7) of the bearing-rotor-gear study (paper 001 of this project), corrected: two tooth pairs in contact act in
parallel (printed: in series), the contact of one pair counts once (printed: three times for the single pair), and its
names are exchanged there (k_h is the contact, k_a the axial, k_s the shear stiffness).

Mesh phase 0 is where a new pair of teeth comes into contact, 1 where the next one does. Two pairs carry the load in
[0, contact ratio - 1), one pair in [contact ratio - 1, 1); the stiffness jumps at 0 and at contact ratio - 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.polynomial import Polynomial

from ..errors import InvalidValueError
from .spur_gear import SpurGear

# Branches are fitted this far beyond their ends, in pitches: a solver may run past a jump within one step, and gears
# that run out move the jumps.
OVERLAP = 0.12
_FIT_ERROR = 1e-7
_DEGREES = range(3, 16)


@dataclass(frozen=True, eq=False)
class StiffnessBranch:
    """Smooth mesh stiffness while the number of pairs in contact does not change.

    Attributes
    ----------
    pairs : int
        Number of tooth pairs in contact.
    start_phase, end_phase : float
        Where the branch holds.
    coefficients : numpy.ndarray
        Polynomial in (phase - start_phase), ascending powers, N/m; smooth to any order. It follows the tooth model
        0.12 of a pitch beyond both ends.
    fit_error : float
        Largest relative deviation from the tooth model, the extensions included.
    """

    pairs: int
    start_phase: float
    end_phase: float
    coefficients: np.ndarray = field(repr=False)
    fit_error: float

    def stiffness_n_m(self, phase: np.ndarray) -> np.ndarray:
        """Return the branch in N/m at any phase of its range and 0.12 beyond; not wrapped to one pitch."""
        return np.polynomial.polynomial.polyval(np.asarray(phase, dtype=float) - self.start_phase, self.coefficients)

    @cached_property
    def integral_n_m(self) -> float:
        """Integral of the stiffness over the branch, in N/m times pitches."""
        whole = Polynomial(self.coefficients).integ()
        return float(whole(self.end_phase - self.start_phase))


@dataclass(frozen=True)
class SpurPair:
    """Two spur gears in mesh, the pinion driving.

    Parameters
    ----------
    pinion, wheel : SpurGear
        Of equal module and pressure angle. Contact ratio between 1 and 2, contact within both involutes.
    centre_growth_m : float
        Centre distance less that of the pitch circles, m (z1 + z2) / 2. Involutes still roll truly, with less contact
        and more backlash.

    Raises
    ------
    InvalidValueError
        When the gears do not mesh, interfere, or have a contact ratio outside 1 to 2.
    """

    pinion: SpurGear
    wheel: SpurGear
    centre_growth_m: float = 0.0

    def __post_init__(self) -> None:
        one, two = self.pinion, self.wheel
        for name in ("module_m", "pressure_angle_rad"):
            values = getattr(one, name), getattr(two, name)
            if not math.isclose(*values, rel_tol=1e-9):
                raise InvalidValueError(f"Gears with {name} {values[0]} and {values[1]}; allowed: equal. Correct one.")
        if min(self._start_m, self._tangents_m - self._end_m) <= 0:
            raise InvalidValueError(
                f"Gears with {one.teeth} and {two.teeth} teeth would touch inside a base circle; allowed: contact on "
                "the involutes only. Give more teeth, a larger pressure angle or a smaller addendum."
            )
        if not 1.0 < self.contact_ratio < 2.0:
            raise InvalidValueError(
                f"Contact ratio {self.contact_ratio:.4g}; allowed: above 1 and below 2. Check addendum and teeth."
            )

    @property
    def _tangents_m(self) -> float:
        """Length of the line of action between both base circles."""
        one, two = self.pinion, self.wheel
        distance = one.pitch_radius_m + two.pitch_radius_m + self.centre_growth_m
        return distance * math.sin(self.working_angle_rad)

    @property
    def working_angle_rad(self) -> float:
        """Pressure angle at the actual centre distance a': cos(alpha') = a cos(alpha) / a'."""
        if self.centre_growth_m == 0:
            return self.pinion.pressure_angle_rad
        distance = self.pinion.pitch_radius_m + self.wheel.pitch_radius_m
        ratio = distance * math.cos(self.pinion.pressure_angle_rad) / (distance + self.centre_growth_m)
        if not 0 < ratio < 1:
            raise InvalidValueError(
                f"Centre distance {distance + self.centre_growth_m:.6g} m; allowed: more than the sum of the base "
                "circles' radii. Give a smaller change."
            )
        return math.acos(ratio)

    @property
    def backlash_growth_m(self) -> float:
        """Backlash along the line of action that the centre distance adds: 2 (r_b1 + r_b2) (inv alpha' - inv alpha).

        The involute function is inv x = tan x - x.
        """
        new, old = (math.tan(a) - a for a in (self.working_angle_rad, self.pinion.pressure_angle_rad))
        return 2 * (self.pinion.base_radius_m + self.wheel.base_radius_m) * (new - old)

    @property
    def _start_m(self) -> float:
        """Distance from the pinion's base tangent point to the first contact, at the wheel's tip."""
        return self._tangents_m - self.wheel.base_radius_m * self.wheel.tip_roll_angle_rad

    @property
    def _end_m(self) -> float:
        """Distance from the pinion's base tangent point to the last contact, at the pinion's tip."""
        return self.pinion.base_radius_m * self.pinion.tip_roll_angle_rad

    @property
    def base_pitch_m(self) -> float:
        """Distance of two teeth along the line of action, pi m cos(alpha)."""
        return math.pi * self.pinion.module_m * math.cos(self.pinion.pressure_angle_rad)

    @property
    def contact_ratio(self) -> float:
        """Length of contact over base pitch: the mean number of tooth pairs in contact."""
        return (self._end_m - self._start_m) / self.base_pitch_m

    @property
    def pitch_point_phase(self) -> float:
        """Phase at which a pair touches at the pitch point, counted from its first contact."""
        return (self.pinion.base_radius_m * math.tan(self.working_angle_rad) - self._start_m) / self.base_pitch_m

    @property
    def contact_compliance_m_n(self) -> float:
        """Linear Hertz contact of two flanks, 2/(pi W) [(1-nu^2)/E of the pinion + of the wheel], in m/N.

        For equal gears 4 (1 - nu^2) / (pi E W); W is the smaller face width. Source: D. C. H. Yang and J. Y. Lin,
        "Hertzian damping, tooth friction and bending elasticity in gear impact dynamics", 1987.
        """
        soft = sum(
            (1 - gear.material.poisson_ratio**2) / gear.material.youngs_modulus_pa for gear in (self.pinion, self.wheel)
        )
        return 2 / (math.pi * min(self.pinion.face_width_m, self.wheel.face_width_m)) * soft

    def roll_angles_rad(self, pair_phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the roll angles of the contact on pinion and wheel, for the phase since a pair's first contact."""
        place = self._start_m + np.asarray(pair_phase, dtype=float) * self.base_pitch_m
        return place / self.pinion.base_radius_m, (self._tangents_m - place) / self.wheel.base_radius_m

    def pair_stiffness_n_m(self, pair_phase: np.ndarray) -> np.ndarray:
        """Return the stiffness of one tooth pair along the line of action in N/m.

        Both teeth, both gear bodies and the contact in series.

        Parameters
        ----------
        pair_phase : numpy.ndarray
            Pitches since the pair's first contact, 0 to the contact ratio, any shape.
        """
        on_pinion, on_wheel = self.roll_angles_rad(pair_phase)
        teeth = self.pinion.tooth_compliance_m_n(on_pinion) + self.wheel.tooth_compliance_m_n(on_wheel)
        return 1 / (teeth + self.contact_compliance_m_n)

    @cached_property
    def branches(self) -> tuple[StiffnessBranch, StiffnessBranch]:
        """The double-pair and the single-pair branch as polynomials."""
        change = self.contact_ratio - 1
        return self._fit(2, 0.0, change), self._fit(1, change, 1.0)

    def _fit(self, pairs: int, start: float, end: float) -> StiffnessBranch:
        """Fit the sum of the pairs in contact with the lowest degree that follows it closely."""

        def model(phase: np.ndarray) -> np.ndarray:
            return sum((self.pair_stiffness_n_m(phase + number) for number in range(pairs)), np.zeros_like(phase))

        low, high = start - OVERLAP, end + OVERLAP
        check = np.linspace(low, high, 401)
        truth = model(check)
        for degree in _DEGREES:
            fit = np.polynomial.Chebyshev.interpolate(model, degree, [low, high])
            powers = fit(Polynomial([start, 1.0])).coef
            error = float(np.abs(np.polynomial.polynomial.polyval(check - start, powers) / truth - 1).max())
            if error < _FIT_ERROR:
                break
        powers.setflags(write=False)
        return StiffnessBranch(pairs, start, end, powers, error)

    @property
    def jump_phases(self) -> tuple[float, float]:
        """Phases at which the stiffness jumps: up at 0, where a pair enters, down where one leaves."""
        return 0.0, self.contact_ratio - 1

    @property
    def mean_stiffness_n_m(self) -> float:
        """Mean of the mesh stiffness over one pitch in N/m."""
        return sum(branch.integral_n_m for branch in self.branches)

    @property
    def later_entry_per_m(self) -> float:
        """By how many pitches pairs enter later per growth of the centre distance: 1 / (sin(alpha') p_b), 1/m.

        The distance d of the base tangent points along the line of action is a' sin(alpha'), with a' cos(alpha') that
        of the base circles: its slope in a' is 1 / sin(alpha'). The wheel's tip stays where it is on that line.
        """
        return 1 / (math.sin(self.working_angle_rad) * self.base_pitch_m)

    def mesh_stiffness_n_m(self, phase: np.ndarray) -> np.ndarray:
        """Return the mesh stiffness along the line of action in N/m.

        Parameters
        ----------
        phase : numpy.ndarray
            Mesh phase in pitches (pinion angle times teeth / 2 pi), any shape and size; only the fraction counts. At
            a jump the value to its right.
        """
        phase = np.asarray(phase, dtype=float) % 1.0
        double, single = self.branches
        return np.where(phase < double.end_phase, double.stiffness_n_m(phase), single.stiffness_n_m(phase))
