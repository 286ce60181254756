"""Kinematics of rolling bearings: the orders at which their defects strike.

Reference: R. B. Randall and J. Antoni, "Rolling element bearing diagnostics - a tutorial", MSSP 25 (2011),
equations (1)-(4). Inner ring turning, outer ring fixed, pure rolling.
"""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources

from ..errors import InvalidValueError


@dataclass(frozen=True)
class BearingOrders:
    """Defect orders (multiples of shaft speed) of one bearing.

    Attributes
    ----------
    outer_race : float
        Ball-pass order of the outer race (BPFO).
    inner_race : float
        Ball-pass order of the inner race (BPFI).
    ball_spin : float
        Spin order of a ball (BSF); a defect on a ball strikes both races, so it shows at twice this order.
    cage : float
        Order of the cage (FTF).
    """

    outer_race: float
    inner_race: float
    ball_spin: float
    cage: float


@dataclass(frozen=True)
class BearingGeometry:
    """Geometry of a rolling bearing.

    Parameters
    ----------
    balls : int
        Number of rolling elements in one row, at least 3.
    ball_diameter_m, pitch_diameter_m : float
        Rolling-element and pitch diameter in metres; the ball must be smaller than the pitch circle.
    contact_angle_rad : float
        Contact angle in radians, 0 for a deep-groove bearing.
    designation, source, confidence : str
        Name in the catalogue, where the numbers come from, and how sure they are (H, M or L).
    """

    balls: int
    ball_diameter_m: float
    pitch_diameter_m: float
    contact_angle_rad: float = 0.0
    designation: str = ""
    source: str = ""
    confidence: str = ""

    def __post_init__(self) -> None:
        if not 3 <= self.balls <= 500:
            raise InvalidValueError(f"Bearing has {self.balls} balls; allowed: 3 to 500. Check the geometry.")
        if not 0.0 < self.ball_diameter_m < self.pitch_diameter_m:
            raise InvalidValueError(
                f"Ball diameter {self.ball_diameter_m} m with pitch diameter {self.pitch_diameter_m} m; allowed: "
                "0 < ball < pitch, both in the same unit. Check the order of the two numbers."
            )
        if not 0.0 <= self.contact_angle_rad < math.pi / 2:
            raise InvalidValueError(
                f"Contact angle {math.degrees(self.contact_angle_rad):.3g} deg; allowed: 0 to "
                "just under 90. Check the unit."
            )

    def defect_orders(self) -> BearingOrders:
        """Return the four defect orders, with g = (d/D) cos(contact angle).

        FTF = (1-g)/2, BPFO = Z(1-g)/2, BPFI = Z(1+g)/2, BSF = (D/2d)(1-g^2).

        Examples
        --------
        >>> orders = BearingGeometry(9, 7.94e-3, 39.04e-3).defect_orders()
        >>> round(orders.outer_race, 2), round(orders.inner_race, 2)
        (3.58, 5.42)
        """
        ratio = self.ball_diameter_m / self.pitch_diameter_m * math.cos(self.contact_angle_rad)
        return BearingOrders(
            outer_race=self.balls * (1 - ratio) / 2,
            inner_race=self.balls * (1 + ratio) / 2,
            ball_spin=self.pitch_diameter_m / (2 * self.ball_diameter_m) * (1 - ratio**2),
            cage=(1 - ratio) / 2,
        )


@cache
def bearing_catalogue() -> dict[str, BearingGeometry]:
    """Return the shipped bearings by designation (upper case, without spaces).

    Rows come from ``bearings.toml``, each with its source and confidence.
    """
    text = resources.files(__name__.rpartition(".")[0]).joinpath("bearings.toml").read_text(encoding="utf-8")
    found: dict[str, BearingGeometry] = {}
    for row in tomllib.loads(text)["bearing"]:
        geometry = BearingGeometry(
            balls=row["balls"],
            ball_diameter_m=row["ball_diameter_mm"] * 1e-3,
            pitch_diameter_m=row["pitch_diameter_mm"] * 1e-3,
            contact_angle_rad=math.radians(row.get("contact_angle_deg", 0.0)),
            designation=row["designation"],
            source=row["source"],
            confidence=row["confidence"],
        )
        for name in (row["designation"], *row.get("also", ())):
            found[normalised_designation(name)] = geometry
    return found


def normalised_designation(name: str) -> str:
    """Return a bearing name without spaces, hyphens or slashes, in upper case: the catalogue's key."""
    return "".join(character for character in name.upper() if character.isalnum())


def find_bearing(designation: str) -> BearingGeometry:
    """Return the catalogue's bearing of this name; sealing and clearance suffixes are ignored.

    Raises
    ------
    InvalidValueError
        When the catalogue has no such bearing; the message lists what it has.
    """
    wanted = normalised_designation(designation)
    catalogue = bearing_catalogue()
    if wanted in catalogue:
        return catalogue[wanted]
    # Sealing, cage and clearance suffixes (6205-2RS/C3) do not change the inner geometry.
    # A maker's name in front (SKF 6205) does not either.
    for word in re.split(r"[-/ ]", designation.strip().upper()):
        if word.isdigit() and word in catalogue:
            return catalogue[word]
    known = ", ".join(sorted({geometry.designation for geometry in catalogue.values()}))
    raise InvalidValueError(
        f"Bearing {designation!r} is not in the catalogue ({known}). Give its geometry instead: "
        "balls,ball diameter mm,pitch diameter mm,contact angle deg - for example --bearing 9,7.94,39.04,0."
    )
