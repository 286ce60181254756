"""Hertz point contact of a ball with the raceways of a ball bearing: load = stiffness x approach^1.5.

Elliptic integrals are exact (scipy), not the power-law fits of Hamrock and Brewe.

References: B. J. Hamrock and D. Dowson, "Ball Bearing Lubrication", Wiley 1981, chapter 3; T. A. Harris, "Rolling
Bearing Analysis", 4th ed., Wiley 2001, chapter 6; K. L. Johnson, "Contact Mechanics", Cambridge 1985, chapter 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..errors import InvalidValueError
from .shaft_parts import require_positive


@dataclass(frozen=True)
class ContactEllipse:
    """Shape of an elliptic Hertz contact, which does not depend on the load.

    Attributes
    ----------
    ellipticity : float
        Ratio of the long to the short axis of the contact ellipse, at least 1.
    first_integral, second_integral : float
        Complete elliptic integrals of the first and second kind for the parameter 1 - 1/ellipticity^2.
    """

    ellipticity: float
    first_integral: float
    second_integral: float


@dataclass(frozen=True)
class BallContactStiffness:
    """Contact stiffness of one ball in N/m^1.5: load = stiffness x approach^1.5, approach in m.

    Attributes
    ----------
    inner, outer : float
        Of the contact with one raceway.
    combined : float
        Inner ring against outer ring through the ball: (inner^(-2/3) + outer^(-2/3))^(-3/2).
    """

    inner: float
    outer: float
    combined: float


def contact_ellipse(radius_ratio: float) -> ContactEllipse:
    """Return the contact ellipse of two bodies with parallel principal directions.

    The ellipticity k solves [k^2 E - K] / [K - E] = radius_ratio, K and E being the elliptic integrals.

    Parameters
    ----------
    radius_ratio : float
        Larger over smaller relative radius of curvature, at least 1; 1 is a circle. Up to 1e10.

    Examples
    --------
    >>> round(contact_ellipse(1.0).ellipticity, 6)
    1.0
    """
    from scipy.optimize import root_scalar
    from scipy.special import ellipe, ellipkm1

    if not 1.0 <= radius_ratio <= 1e10:
        raise InvalidValueError(
            f"Ratio of the relative radii {radius_ratio}; allowed: 1 to 1e10, the larger radius over the smaller."
        )

    def excess(logarithm: float) -> float:
        square = math.exp(2 * logarithm)
        first, second = ellipkm1(1 / square), ellipe(1 - 1 / square)
        return (square + radius_ratio) * second - (1 + radius_ratio) * first

    # Both terms are equal at a circle; nearer to it than 1e-6 the two integrals differ by round-off only.
    lowest = 1e-6
    logarithm = 0.0
    if excess(lowest) < 0:
        logarithm = root_scalar(excess, bracket=(lowest, 40.0), method="brentq", xtol=1e-14, rtol=1e-14).root
    ellipticity = math.exp(logarithm)
    remainder = 1 / ellipticity**2
    return ContactEllipse(ellipticity, float(ellipkm1(remainder)), float(ellipe(1 - remainder)))


def point_contact_stiffness(
    radius_one_m: float, radius_two_m: float, *, youngs_modulus_pa: float, poisson_ratio: float
) -> float:
    """Return the load over approach^1.5, in N/m^1.5, of two bodies of the same material.

    K = pi k E' sqrt(2 E R / (9 K^3)) with E' = modulus / (1 - nu^2), 1/R = 1/R_1 + 1/R_2, ellipticity k and the
    elliptic integrals K and E (Hamrock and Dowson 1981).

    Parameters
    ----------
    radius_one_m, radius_two_m : float
        Relative radii of curvature in the two principal directions, in m: 1/R_1 is the sum of both bodies'
        curvatures there, hollow ones negative. Both above 0, in any order.
    youngs_modulus_pa, poisson_ratio : float
        Of both bodies.

    Examples
    --------
    A steel ball of 10 mm on a plane, 4/3 E* sqrt(radius):

    >>> value = point_contact_stiffness(5e-3, 5e-3, youngs_modulus_pa=2.08e11, poisson_ratio=0.3)
    >>> print(f"{value:.3g}")
    1.08e+10
    """
    for name, value in (("radius_one_m", radius_one_m), ("radius_two_m", radius_two_m)):
        require_positive(name, value)
    require_positive("youngs_modulus_pa", youngs_modulus_pa)
    if not -1.0 < poisson_ratio < 0.5:
        raise InvalidValueError(f"Poisson ratio {poisson_ratio}; allowed: above -1 and below 0.5. Steel has 0.3.")
    small, large = sorted((radius_one_m, radius_two_m))
    shape = contact_ellipse(large / small)
    modulus = youngs_modulus_pa / (1 - poisson_ratio**2)
    radius = small * large / (small + large)
    return (
        math.pi
        * shape.ellipticity
        * modulus
        * math.sqrt(2 * shape.second_integral * radius / (9 * shape.first_integral**3))
    )


def raceway_radii_m(
    *,
    ball_diameter_m: float,
    pitch_diameter_m: float,
    race_conformity: float,
    contact_angle_rad: float = 0.0,
    inner: bool,
) -> tuple[float, float]:
    """Return the relative radii of curvature of ball and raceway along and across the rolling direction, in m.

    With d, D, f and g = (d/D) cos(contact angle): along d/2 (1 - g) on the inner and d/2 (1 + g) on the outer
    raceway, across d f / (2 f - 1).

    Parameters
    ----------
    ball_diameter_m, pitch_diameter_m : float
        0 < ball < pitch, in m.
    race_conformity : float
        Groove radius over ball diameter, above 0.5; 0.51 to 0.54 is usual.
    contact_angle_rad : float
        0 for a deep-groove bearing under radial load.
    inner : bool
        True for the inner, False for the outer raceway.
    """
    if not 0.0 < ball_diameter_m < pitch_diameter_m:
        raise InvalidValueError(
            f"Ball diameter {ball_diameter_m} m with pitch diameter {pitch_diameter_m} m; allowed: 0 < ball < pitch. "
            "Check the order of the two numbers."
        )
    if not 0.5 < race_conformity < math.inf:
        raise InvalidValueError(
            f"Race conformity {race_conformity}; allowed: above 0.5, groove radius over ball diameter. 0.52 is usual."
        )
    if not 0.0 <= contact_angle_rad < math.pi / 2:
        raise InvalidValueError(f"Contact angle {contact_angle_rad} rad; allowed: 0 to below pi/2. Check the unit.")
    ratio = ball_diameter_m / pitch_diameter_m * math.cos(contact_angle_rad)
    along = ball_diameter_m / 2 * (1 - ratio if inner else 1 + ratio)
    return along, ball_diameter_m * race_conformity / (2 * race_conformity - 1)


def ball_contact_stiffness(
    *,
    ball_diameter_m: float,
    pitch_diameter_m: float,
    inner_conformity: float,
    outer_conformity: float,
    contact_angle_rad: float = 0.0,
    youngs_modulus_pa: float,
    poisson_ratio: float,
) -> BallContactStiffness:
    """Return the contact stiffness of one ball on the inner, on the outer and on both raceways, in N/m^1.5.

    Arguments as for ``raceway_radii_m`` and ``point_contact_stiffness``; both raceways carry the same load (slow
    bearing, no centrifugal force).

    Examples
    --------
    >>> both = ball_contact_stiffness(ball_diameter_m=12.7e-3, pitch_diameter_m=65e-3, inner_conformity=0.52,
    ...     outer_conformity=0.52, youngs_modulus_pa=2.07e11, poisson_ratio=0.3)
    >>> print(f"{both.combined:.3g}")
    1.17e+10
    """
    inner, outer = (
        point_contact_stiffness(
            *raceway_radii_m(
                ball_diameter_m=ball_diameter_m,
                pitch_diameter_m=pitch_diameter_m,
                race_conformity=conformity,
                contact_angle_rad=contact_angle_rad,
                inner=is_inner,
            ),
            youngs_modulus_pa=youngs_modulus_pa,
            poisson_ratio=poisson_ratio,
        )
        for conformity, is_inner in ((inner_conformity, True), (outer_conformity, False))
    )
    return BallContactStiffness(inner, outer, (inner ** (-2 / 3) + outer ** (-2 / 3)) ** -1.5)
