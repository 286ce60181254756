"""What a shaft is made of: material, pieces of shaft, rigid discs.

Reference: G. R. Cowper, "The shear coefficient in Timoshenko's beam theory", J. Appl. Mech. 33 (1966) 335-340
(hollow circular section).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..errors import InvalidValueError


@dataclass(frozen=True)
class Material:
    """Isotropic elastic material of a shaft.

    Parameters
    ----------
    youngs_modulus_pa, density_kg_m3 : float
        Young's modulus in Pa and density in kg/m3, both above 0.
    poisson_ratio : float
        Between -1 and 0.5, both excluded.
    """

    youngs_modulus_pa: float
    density_kg_m3: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        require_positive("Young's modulus in Pa", self.youngs_modulus_pa)
        require_positive("Density in kg/m3", self.density_kg_m3)
        if not -1.0 < self.poisson_ratio < 0.5:
            raise InvalidValueError(
                f"Poisson ratio {self.poisson_ratio}; allowed: above -1 and below 0.5. Steel has 0.3."
            )

    @property
    def shear_modulus_pa(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) in Pa."""
        return self.youngs_modulus_pa / (2 * (1 + self.poisson_ratio))


@dataclass(frozen=True)
class ShaftElement:
    """A piece of shaft with constant circular section.

    Parameters
    ----------
    length_m, outer_diameter_m : float
        In metres, above 0.
    inner_diameter_m : float
        Bore in metres, 0 for a solid shaft, below the outer diameter.
    """

    length_m: float
    outer_diameter_m: float
    inner_diameter_m: float = 0.0

    def __post_init__(self) -> None:
        require_positive("Length in m", self.length_m)
        require_positive("Outer diameter in m", self.outer_diameter_m)
        if not 0.0 <= self.inner_diameter_m < self.outer_diameter_m:
            raise InvalidValueError(
                f"Inner diameter {self.inner_diameter_m} m with outer diameter {self.outer_diameter_m} m; allowed: "
                "0 <= inner < outer. Check the order of the two numbers."
            )

    @property
    def area_m2(self) -> float:
        """Area of the section in m2."""
        return math.pi / 4 * (self.outer_diameter_m**2 - self.inner_diameter_m**2)

    @property
    def second_moment_m4(self) -> float:
        """Second moment of area about a diameter, I = pi (D^4 - d^4) / 64, in m4; the polar one is twice this."""
        return math.pi / 64 * (self.outer_diameter_m**4 - self.inner_diameter_m**4)

    def shear_coefficient(self, poisson_ratio: float) -> float:
        """Return Cowper's shear coefficient of the (hollow) circular section, dimensionless.

        kappa = 6 (1+nu) (1+m^2)^2 / [(7+6nu) (1+m^2)^2 + (20+12nu) m^2] with m = inner / outer diameter.

        Examples
        --------
        >>> round(ShaftElement(0.1, 0.02).shear_coefficient(0.3), 4)
        0.8864
        """
        hollow = (self.inner_diameter_m / self.outer_diameter_m) ** 2
        square = (1 + hollow) ** 2
        nu = poisson_ratio
        return 6 * (1 + nu) * square / ((7 + 6 * nu) * square + (20 + 12 * nu) * hollow)


@dataclass(frozen=True)
class Disc:
    """A rigid disc fixed to a node, its mass centre on the shaft axis.

    Parameters
    ----------
    node : int
        Node number, counted from 0.
    mass_kg : float
        Mass, at least 0.
    diametral_inertia_kg_m2, polar_inertia_kg_m2 : float
        Moments of inertia about a diameter and about the shaft axis, at least 0; no body has a polar moment above
        twice its diametral moment.
    """

    node: int
    mass_kg: float
    diametral_inertia_kg_m2: float
    polar_inertia_kg_m2: float

    def __post_init__(self) -> None:
        values = (self.mass_kg, self.diametral_inertia_kg_m2, self.polar_inertia_kg_m2)
        if not all(math.isfinite(value) and value >= 0 for value in values):
            raise InvalidValueError(
                f"Disc at node {self.node} has mass, diametral and polar inertia {values}; allowed: numbers of at "
                "least 0. Check kg and kg m2."
            )
        if self.polar_inertia_kg_m2 > 2 * self.diametral_inertia_kg_m2 * (1 + 1e-9):
            raise InvalidValueError(
                f"Disc at node {self.node} has polar inertia {self.polar_inertia_kg_m2} kg m2, above twice the "
                f"diametral {self.diametral_inertia_kg_m2} kg m2; allowed: at most twice, as for a thin disc. Check "
                "the order of the two."
            )

    @classmethod
    def from_geometry(
        cls,
        node: int,
        *,
        width_m: float,
        outer_diameter_m: float,
        inner_diameter_m: float = 0.0,
        density_kg_m3: float,
    ) -> Disc:
        """Return the disc of a homogeneous hollow cylinder.

        m = rho pi (D^2 - d^2) w / 4, I_p = m (D^2 + d^2) / 8, I_d = I_p / 2 + m w^2 / 12.

        Examples
        --------
        >>> disc = Disc.from_geometry(3, width_m=0.02, outer_diameter_m=0.2, density_kg_m3=7850)
        >>> round(disc.mass_kg, 3), round(disc.polar_inertia_kg_m2, 5)
        (4.932, 0.02466)
        """
        ring = ShaftElement(width_m, outer_diameter_m, inner_diameter_m)
        require_positive("Density in kg/m3", density_kg_m3)
        mass = density_kg_m3 * ring.area_m2 * width_m
        polar = mass * (outer_diameter_m**2 + inner_diameter_m**2) / 8
        return cls(node, mass, polar / 2 + mass * width_m**2 / 12, polar)


def require_positive(what: str, value: float) -> None:
    """Refuse a number that is not finite or not above 0; ``what`` names quantity and unit in the message."""
    if not (math.isfinite(value) and value > 0):
        raise InvalidValueError(f"{what} is {value}; allowed: a number above 0. Check value and unit.")
