"""A turning shaft that touches a ring: radial contact with dry friction.

The ring's centre is off the shaft's by e; z is the motion of the shaft in the ring. With the distance r = |z - e| of
the two centres and n = (z - e) / r the direction of contact,

    N = k ramp(r - clearance),     force on the shaft = N (-n - mu s t),     s = v / sqrt(v^2 + v_0^2),

t = n turned by a quarter in the sense of rotation, and v = R w + t.z' the sliding speed of the surfaces, R being the
shaft's radius there. Friction drives the shaft against its rotation (reverse whirl). When it whirls backward so fast
that it rolls in the ring, v passes through 0 and friction ends. v_0 is a small speed, as friction is not a step.

The ring gets the opposite force through the reading directions. The friction's torque on the shaft is left out.

Reference: A. Muszynska, "Rotordynamics", CRC Press 2005, chapter 5; J. J. Yu, P. Goldman, D. E. Bently,
A. Muszynska, "Rotor/seal experimental and analytical study on full annular rub", J. Eng. Gas Turbines Power 124 (2002).
"""

from __future__ import annotations

import math

import numpy as np

from ..law import Direction, InterfaceForce, Law, Timeline, compiled_force
from .contact import rounded_ramp

#: Below this sliding speed (m/s) friction fades.
FADING_M_S = 0.01


def _surface_speed(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    return (parameters[7] * timeline.speed_rad_s)[None]


@compiled_force
def _touch(signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    for lane in range(u.shape[1]):
        across = x[inputs[0], lane] - parameters[3, lane]
        upward = x[inputs[1], lane] - parameters[4, lane]
        width = parameters[5, lane]
        distance = math.sqrt(across * across + upward * upward)
        if distance - parameters[2, lane] <= -width or distance == 0.0:
            continue
        load = parameters[0, lane] * rounded_ramp(distance - parameters[2, lane], width)
        right, up = across / distance, upward / distance
        sliding = signals[0, lane] - up * x[inputs[2], lane] + right * x[inputs[3], lane]
        friction = parameters[1, lane] * load * sliding / math.sqrt(sliding * sliding + parameters[6, lane] ** 2)
        u[outputs[0], lane] += -load * right + friction * up
        u[outputs[1], lane] += -load * up - friction * right


def _stiffest(parameters: np.ndarray) -> float:
    return float(parameters[0] * math.hypot(1.0, parameters[1]))


RUB = Law("shaft touching a ring", _surface_speed, _touch, stiffest=_stiffest)


def rub_contact(
    name: str,
    pair: tuple[Direction, Direction],
    *,
    stiffness_n_m: float,
    friction: float,
    clearance_m: float,
    centre_m: complex,
    width_m: float,
    shaft_radius_m: float,
    shaft_ratio: float,
) -> InterfaceForce:
    """Return the contact of a shaft with a ring. ``pair`` is the motion of the shaft in the ring, in x and in y.

    Parameters
    ----------
    name : str
    pair : tuple of Direction
    stiffness_n_m, friction : float
        k and mu.
    clearance_m : float
        Difference of the radii.
    centre_m : complex
        e, x + i y.
    width_m : float
        The contact's corner is rounded over this much to both sides.
    shaft_radius_m, shaft_ratio : float
        R, and the shaft's speed over the reference shaft's.
    """
    values = (stiffness_n_m, friction, clearance_m, centre_m.real, centre_m.imag, width_m, FADING_M_S)
    return InterfaceForce(name, RUB, (*values, shaft_radius_m * shaft_ratio), pair, pair, pair)
