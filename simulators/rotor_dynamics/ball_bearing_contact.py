"""Ball bearing as a ring of Hertz contacts that turn with the cage.

With u = x_inner - x_outer, v = y_inner - y_outer, ball angles theta_i = 2 pi i / Z + (1 - g)/2 ratio phi + theta_0
and g = (d/D) cos(contact angle):

    approach_i = max(u cos theta_i + v sin theta_i - clearance, 0)
    force on the outer ring = K sum_i approach_i^1.5 (cos theta_i, sin theta_i), the opposite on the inner ring

The linear core holds a spring of constant stiffness instead, in x and y alike; the interface force is the difference.
Without that spring the core would not hold the shaft at all.

There is no damping here: it belongs to the linear parts around the bearing. The force never leaves the plane and has a
potential for a given cage angle. Because the balls carry the load in turn, the bearing's stiffness pulses at the
ball-pass order of the outer race even when nothing is damaged.

Source: the bearing-rotor-gear study (paper 001 of this project), Eqs (2)-(5); Eq (5) tests a delta_i that is nowhere
defined, it must be epsilon_i of Eq (4). T. A. Harris, "Rolling Bearing Analysis", 4th ed., Wiley 2001, chapter 7.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..assembly import Assembly
from ..errors import InvalidValueError
from ..law import Direction, InterfaceForce, Law, Timeline, compiled_force
from .bearing_damage import BearingDamage
from .rolling_bearing import BearingGeometry

#: Rows of the parameters ahead of the balls' own angles.
_STIFFNESS, _CLEARANCE, _CAGE_ORDER, _CORE, _FIRST_BALL = 0, 1, 2, 3, 4


def _cage_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    return np.stack(timeline.cos_sin(parameters[_CAGE_ORDER]))


@compiled_force
def _contact_force(signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    across, upward = inputs[0], inputs[1]
    on_x, on_y = outputs[0], outputs[1]
    balls = (parameters.shape[0] - _FIRST_BALL) // 2
    # Multiplying out the sum of angles spares a cosine and a sine for every ball at every instant.
    if u.shape[1] == 1:
        # The same sums with the balls innermost: a single lane has nothing to fill the vector registers with.
        right, up, c, s = x[across, 0], x[upward, 0], signals[0, 0], signals[1, 0]
        sum_x, sum_y = u[on_x, 0] + parameters[_CORE, 0] * right, u[on_y, 0] + parameters[_CORE, 0] * up
        for ball in range(_FIRST_BALL, _FIRST_BALL + 2 * balls, 2):
            cos = c * parameters[ball, 0] - s * parameters[ball + 1, 0]
            sin = s * parameters[ball, 0] + c * parameters[ball + 1, 0]
            approach = right * cos + up * sin - parameters[_CLEARANCE, 0]
            if approach > 0.0:
                load = parameters[_STIFFNESS, 0] * approach * math.sqrt(approach)
                sum_x -= load * cos
                sum_y -= load * sin
        u[on_x, 0], u[on_y, 0] = sum_x, sum_y
        return
    for lane in range(u.shape[1]):
        u[on_x, lane] += parameters[_CORE, lane] * x[across, lane]
        u[on_y, lane] += parameters[_CORE, lane] * x[upward, lane]
    for ball in range(_FIRST_BALL, _FIRST_BALL + 2 * balls, 2):
        for lane in range(u.shape[1]):
            cos = signals[0, lane] * parameters[ball, lane] - signals[1, lane] * parameters[ball + 1, lane]
            sin = signals[1, lane] * parameters[ball, lane] + signals[0, lane] * parameters[ball + 1, lane]
            approach = x[across, lane] * cos + x[upward, lane] * sin - parameters[_CLEARANCE, lane]
            approach = approach if approach > 0.0 else 0.0
            load = parameters[_STIFFNESS, lane] * approach * math.sqrt(approach)
            u[on_x, lane] -= load * cos
            u[on_y, lane] -= load * sin


HERTZ_BALLS = Law("Hertz contacts of a ball bearing", _cage_signals, _contact_force)


@dataclass
class BallBearingContact:
    """A ball bearing between an inner and an outer ring that move in the plane. See the module for the law.

    Parameters
    ----------
    name : str
    geometry : BearingGeometry
    contact_stiffness : float
        K in N/m^1.5, both contacts of one ball together, above 0.
    clearance_m : float
        Radial clearance: half the play between the rings. Negative for a preload.
    x, y : Direction
        Motion of the inner ring less motion of the outer ring.
    shaft_ratio : float
        Speed of the inner ring over the reference shaft's; the outer ring stands still.
    first_ball_rad : float
        Angle of the first ball from x at shaft angle 0.
    core_load_n : float
        The spring of the linear core is as stiff as one ball under this load. The answer does not depend on it.
    load_angle_rad : float
        Direction of the steady load from x: where a pit of the outer race is felt. The force does not depend on it.
    damage : BearingDamage
        Empty for a sound bearing.
    """

    name: str
    geometry: BearingGeometry
    contact_stiffness: float
    clearance_m: float
    x: Direction
    y: Direction
    shaft_ratio: float = 1.0
    first_ball_rad: float = 0.0
    core_load_n: float = 200.0
    load_angle_rad: float = -math.pi / 2
    damage: BearingDamage = field(default_factory=BearingDamage)
    roles: frozenset[str] = frozenset({"bearing", "bearing_with_clearance"})

    def __post_init__(self) -> None:
        if not 0 < self.contact_stiffness < math.inf:
            raise InvalidValueError(
                f"Contact stiffness {self.contact_stiffness} N/m^1.5 of {self.name}; allowed: more than 0. "
                "A deep-groove bearing has about 1e10."
            )

    @property
    def ball_pass_order(self) -> float:
        """Order of the reference shaft at which balls pass a point of the outer ring."""
        return self.geometry.defect_orders().outer_race * self.shaft_ratio

    @property
    def core_stiffness_n_m(self) -> float:
        """Stiffness that the linear core holds: 1.5 K^(2/3) load^(1/3)."""
        return 1.5 * self.contact_stiffness ** (2 / 3) * self.core_load_n ** (1 / 3)

    def grow_clearance(self, growth_m: float) -> None:
        """Add to the radial clearance; growths of several effects add."""
        if not -1e-3 < growth_m < 1e-2:
            raise InvalidValueError(
                f"Bearing {self.name}: clearance grows by {growth_m:g} m; allowed: -1e-3 to 1e-2 m. Check the unit."
            )
        self.clearance_m += growth_m

    def interface_force(self) -> InterfaceForce:
        """Return the contacts less the core's spring, as an interface force."""
        if self.damage.is_present:
            return self.damage.interface_force(
                self.name,
                self.geometry,
                (self.x, self.y),
                contact_stiffness=self.contact_stiffness,
                hertz=True,
                clearance_m=self.clearance_m,
                core_stiffness_n_m=self.core_stiffness_n_m,
                first_ball_rad=self.first_ball_rad,
                shaft_ratio=self.shaft_ratio,
            )
        cage_order = self.geometry.defect_orders().cage * self.shaft_ratio
        angles = self.first_ball_rad + 2 * math.pi * np.arange(self.geometry.balls) / self.geometry.balls
        pairs = np.stack([np.cos(angles), np.sin(angles)], axis=1).ravel()
        return InterfaceForce(
            self.name,
            HERTZ_BALLS,
            (self.contact_stiffness, self.clearance_m, cage_order, self.core_stiffness_n_m, *pairs.tolist()),
            (self.x, self.y),
            (self.x, self.y),
        )

    def finish(self, assembly: Assembly) -> None:
        """Add the contacts to the assembly."""
        for along in (self.x, self.y):
            assembly.add_spring(along, stiffness=self.core_stiffness_n_m)
        assembly.forces.append(self.interface_force())
