"""A light sleeve that floats on the oil film round a shaft: the least part of a machine that can whirl.

The sleeve (mass m, displacement w) sees the shaft (z) through a film that moves with the share lambda of the shaft's
speed W. With s = w - z,

    m w'' + D (s' - i lambda W s) + K_0 (1 + |s|^4 / a^4) s = 0,     the shaft gets the opposite film force.

A shaft that does not move: the sleeve is stable while lambda W < sqrt(K_0 / m). Above, it circles at exactly lambda W
with the radius a ((W / W_0)^2 - 1)^(1/4), W_0 = sqrt(K_0 / m) / lambda, and shakes the shaft with m (lambda W)^2 |w|.

A shaft that can resonate (mass M, damping C, own frequency w_r with the sleeve on it) holds the frequency at its own
when lambda W comes there: whip. With H = m w^2 / (K - M w^2 + i C w) the frequency w obeys D (w - lambda W) =
Im[m w^2 / (1 - H)], so that it can stay near w_r as long as lambda W - w < about m^2 w^3 / (C D).

The film's model (average circumferential speed lambda, direct stiffness that grows with the orbit) is that of
A. Muszynska, "Whirl and whip - rotor/bearing stability problems", J. Sound Vib. 110 (1986) 443-462.
"""

from __future__ import annotations

import numpy as np

from ..assembly import Assembly, Place, difference
from ..law import InterfaceForce, Law, Timeline, compiled_force


def _film_speed(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    return (parameters[0] * timeline.speed_rad_s)[None]


@compiled_force
def _film(signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    for lane in range(u.shape[1]):
        across, upward = x[inputs[0], lane], x[inputs[1], lane]
        square = (across * across + upward * upward) / parameters[2, lane]
        stiffer = parameters[1, lane] * square * square
        turning = signals[0, lane]
        u[outputs[0], lane] -= stiffer * across + turning * upward
        u[outputs[1], lane] -= stiffer * upward - turning * across


FILM = Law("oil film", _film_speed, _film, self_excited=True)


def add_film_sleeve(
    assembly: Assembly,
    place: Place,
    name: str,
    *,
    mass_kg: float,
    damping_n_s_m: float,
    stiffness_n_m: float,
    speed_share: float,
    orbit_m: float,
) -> None:
    """Put a sleeve with two degrees of freedom, "<name>.x" and "<name>.y", round the shaft at ``place``.

    Parameters
    ----------
    assembly : Assembly
    place : Place
        With "x" and "y" and the shaft's ratio.
    name : str
    mass_kg, damping_n_s_m, stiffness_n_m : float
        m, D, K_0. The sleeve has no weight here: a film that carries weight does not whirl.
    speed_share : float
        lambda.
    orbit_m : float
        a.
    """
    gaps = []
    for axis in ("x", "y"):
        assembly.add_coordinate(f"{name}.{axis}", mass=mass_kg)
        gap = difference({f"{name}.{axis}": 1.0}, place.directions[axis])
        assembly.add_spring(gap, stiffness=stiffness_n_m, damping=damping_n_s_m)
        gaps.append(gap)
    pair = (gaps[0], gaps[1])
    values = (damping_n_s_m * speed_share * place.shaft_ratio, stiffness_n_m, orbit_m**2)
    assembly.forces.append(InterfaceForce(f"film of {name}", FILM, values, pair, pair))
