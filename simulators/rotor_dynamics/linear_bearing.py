"""Rolling bearing as a linear spring and damper between its rings: a Hertz bearing for small motion about its load.

A ball bearing without play and with radial load W on Z balls of contact stiffness K (N/m^1.5) yields by
delta = (W / (K s))^(2/3), where s = sum of cos(theta_i)^2.5 over the loaded balls, about Z / 4.37. Its stiffness for
small motion along the load is therefore

    k = dW / d delta = 1.5 W / delta = 1.5 (K s)^(2/3) W^(1/3).

Source: T. A. Harris, "Rolling Bearing Analysis", 4th ed., Wiley 2001, sections 7.2 and 8.2 (Stribeck's sum 4.37).
Damping of about 1e-5 s times the stiffness: E. Kraemer, "Dynamics of Rotors and Foundations", Springer 1993.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..assembly import Assembly
from ..errors import InvalidValueError
from ..law import Direction
from .bearing_damage import BearingDamage
from .rolling_bearing import BearingGeometry

_STRENGTHS = (
    "stiffness_x_n_m",
    "stiffness_y_n_m",
    "axial_stiffness_n_m",
    "damping_n_s_m",
    "axial_damping_n_s_m",
)


@dataclass
class LinearBearing:
    """A rolling bearing that acts as springs and dampers. A component with the role "bearing".

    Parameters
    ----------
    name : str
    geometry : BearingGeometry
        For the orders at which its defects strike; the springs do not depend on it.
    x, y, axial : Direction
        Motion of the inner ring less motion of the outer ring.
    stiffness_x_n_m, stiffness_y_n_m, axial_stiffness_n_m : float
        At least 0.
    damping_n_s_m, axial_damping_n_s_m : float
        In x and y, and along the shaft, at least 0.
    shaft_ratio : float
        Speed of the inner ring over the reference shaft's; the outer ring stands still.
    load_angle_rad : float
        Direction of the steady load from x: where a pit of the outer race is felt. The force does not depend on it.
    damage : BearingDamage
        Empty for a sound bearing. A relieved ball loses at most its share of the spring's force, 4 k / Z times its
        approach.
    """

    name: str
    geometry: BearingGeometry
    x: Direction
    y: Direction
    stiffness_x_n_m: float
    stiffness_y_n_m: float
    damping_n_s_m: float
    axial: Direction = field(default_factory=dict)
    axial_stiffness_n_m: float = 0.0
    axial_damping_n_s_m: float = 0.0
    shaft_ratio: float = 1.0
    load_angle_rad: float = -math.pi / 2
    damage: BearingDamage = field(default_factory=BearingDamage)
    roles: frozenset[str] = frozenset({"bearing"})

    def __post_init__(self) -> None:
        for name in _STRENGTHS:
            value = getattr(self, name)
            if not 0.0 <= value < math.inf:
                raise InvalidValueError(f"Bearing {self.name}: {name} = {value}; allowed: at least 0.")

    @property
    def ball_pass_order(self) -> float:
        """Order of the reference shaft at which balls pass a point of the outer ring."""
        return self.geometry.defect_orders().outer_race * self.shaft_ratio

    def scale_stiffness(self, *, x: float = 1.0, y: float = 1.0) -> None:
        """Multiply the radial stiffness in x and y; factors of several effects multiply."""
        if not (0.0 <= x < 1e6 and 0.0 <= y < 1e6):
            raise InvalidValueError(
                f"Bearing {self.name}: stiffness times {x:g} in x and {y:g} in y; allowed: factors from 0 to 1e6."
            )
        self.stiffness_x_n_m *= x
        self.stiffness_y_n_m *= y

    def finish(self, assembly: Assembly) -> None:
        """Add springs and dampers to the linear core."""
        assembly.add_spring(self.x, stiffness=self.stiffness_x_n_m, damping=self.damping_n_s_m)
        assembly.add_spring(self.y, stiffness=self.stiffness_y_n_m, damping=self.damping_n_s_m)
        assembly.add_spring(self.axial, stiffness=self.axial_stiffness_n_m, damping=self.axial_damping_n_s_m)
        # A machine that puts Hertz contacts beside these springs leaves them none to share among balls.
        mean = (self.stiffness_x_n_m + self.stiffness_y_n_m) / 2
        if self.damage.is_present and mean > 0:
            assembly.forces.append(
                self.damage.interface_force(
                    self.name,
                    self.geometry,
                    (self.x, self.y),
                    contact_stiffness=4 * mean / self.geometry.balls,
                    hertz=False,
                    clearance_m=0.0,
                    core_stiffness_n_m=0.0,
                    first_ball_rad=0.0,
                    shaft_ratio=self.shaft_ratio,
                )
            )


def stiffness_under_load_n_m(*, contact_stiffness: float, balls: int, load_n: float) -> float:
    """Return the stiffness in N/m of a ball bearing without play along its radial load, a ball below the shaft.

    k = 1.5 (K s)^(2/3) W^(1/3); see the module.

    Parameters
    ----------
    contact_stiffness : float
        K in N/m^1.5 of one ball on both raceways.
    balls : int
    load_n : float
        Radial load W in N, above 0.

    Examples
    --------
    >>> print(f"{stiffness_under_load_n_m(contact_stiffness=1e10, balls=8, load_n=8.0):.2g}")
    2.1e+07
    """
    angles = 2 * math.pi * np.arange(balls) / balls
    loaded = np.maximum(np.cos(angles), 0.0)
    return 1.5 * (contact_stiffness * float(np.sum(loaded**2.5))) ** (2 / 3) * load_n ** (1 / 3)
