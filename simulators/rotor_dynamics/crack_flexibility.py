"""How much a transverse crack softens a round shaft: local bending flexibility from fracture mechanics.

A crack with a straight front, depth a, in a shaft of radius R adds a hinge of flexibility c (rad per N.m): the bending
moment M across it turns its two faces by c M. With the strain energy release rate of plane strain, summed over strips
of height h = 2 sqrt(R^2 - w^2) at the distance w from the crack's axis of symmetry,

    c_front  = 2 (1 - nu^2) / E  int int [4 sqrt(R^2 - w^2) / (pi R^4)]^2  pi z F_2(z/h)^2 dz dw     (moment opens it)
    c_across = 2 (1 - nu^2) / E  int int [4 w               / (pi R^4)]^2  pi z F_1(z/h)^2 dz dw     (moment across)

over z = 0 .. a - R + sqrt(R^2 - w^2). F_1 and F_2 are the stress intensity functions of a strip in tension and in
bending. For a shallow crack c_front grows as a^2.5.

Sources: A. D. Dimarogonas, C. A. Papadopoulos, "Vibration of cracked shafts in bending", J. Sound Vib. 91 (1983)
583-593; H. Tada, P. C. Paris, G. R. Irwin, "The Stress Analysis of Cracks Handbook" (F_1, F_2, within 0.5 %). Strips
beside each other are taken as independent, which overestimates c near the crack's ends when a > R.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from ..errors import InvalidValueError
from .shaft_parts import Material, require_positive

#: Deepest crack over the diameter: beyond, the strips' functions are outside their range of validity.
DEEPEST = 0.5
_POINTS = 60


def crack_flexibility(*, depth_ratio: float, diameter_m: float, material: Material) -> tuple[float, float]:
    """Return (c_front, c_across) in rad/(N.m) of an open crack; see the module.

    Parameters
    ----------
    depth_ratio : float
        Depth over diameter, from 0 to 0.5.
    diameter_m : float
    material : Material

    Examples
    --------
    >>> steel = Material(2.1e11, 7850, 0.3)
    >>> front, across = crack_flexibility(depth_ratio=0.25, diameter_m=0.02, material=steel)
    >>> print(f"{front:.2g} {across:.2g}")
    5.3e-06 1.1e-06
    """
    require_positive("Diameter in m", diameter_m)
    if not 0.0 <= depth_ratio <= DEEPEST:
        raise InvalidValueError(
            f"Crack of {depth_ratio:g} diameters; allowed: 0 to {DEEPEST:g}. Give its depth over the diameter."
        )
    front, across = _unit_radius(depth_ratio)
    scale = 2 * (1 - material.poisson_ratio**2) / material.youngs_modulus_pa / (diameter_m / 2) ** 3
    return scale * front, scale * across


@functools.lru_cache(maxsize=256)
def _unit_radius(depth_ratio: float) -> tuple[float, float]:
    """Return both integrals for R = 1."""
    if depth_ratio == 0:
        return 0.0, 0.0
    depth = 2 * depth_ratio
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    half_width = math.sqrt(1 - (1 - depth) ** 2)
    w = half_width * (nodes + 1) / 2
    half_height = np.sqrt(1 - w**2)
    reach = np.maximum(depth - 1 + half_height, 0.0)
    z = reach[:, None] * (nodes + 1) / 2
    ratio = z / (2 * half_height[:, None])
    area = half_width / 2 * weights[:, None] * reach[:, None] / 2 * weights
    # Both halves of the crack, hence the factor 2.
    common = 2 * (4 / math.pi) ** 2 * math.pi * z * area
    front = np.sum(common * half_height[:, None] ** 2 * _strip_in_bending(ratio) ** 2)
    across = np.sum(common * w[:, None] ** 2 * _strip_in_tension(ratio) ** 2)
    return float(front), float(across)


def _strip_in_tension(ratio: np.ndarray) -> np.ndarray:
    angle = np.maximum(math.pi * ratio / 2, 1e-12)
    shape = 0.752 + 2.02 * ratio + 0.37 * (1 - np.sin(angle)) ** 3
    return np.sqrt(np.tan(angle) / angle) * shape / np.cos(angle)


def _strip_in_bending(ratio: np.ndarray) -> np.ndarray:
    angle = np.maximum(math.pi * ratio / 2, 1e-12)
    shape = 0.923 + 0.199 * (1 - np.sin(angle)) ** 4
    return np.sqrt(np.tan(angle) / angle) * shape / np.cos(angle)
