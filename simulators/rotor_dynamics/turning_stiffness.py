"""Stiffness in the plane that turns with the shaft and may open and close once a revolution.

With psi = ratio phi + angle the direction of one principal axis, and theta = psi - opening, the force on the two
outputs is, for the two motions q = (q_x, q_y) that it reads,

    F = { a w(theta) I + [b + c w(theta)] R(psi) } q,     R = [[cos 2 psi, sin 2 psi], [sin 2 psi, -cos 2 psi]],

with w = cos(theta), or more abruptly tanh(k cos(theta)) / tanh(k). For k below 0 it is the inverse of that function of
the cosine for -k, which dwells in the middle.
Every term has no mean over a revolution: the mean belongs to the linear core. b alone is an asymmetric shaft, a, b and
c together are a crack that breathes.
"""

from __future__ import annotations

import numpy as np

from ..law import Direction, InterfaceForce, Law, Timeline

#: Abruptness up to which w is the cosine to all digits: it differs by a third of its square.
GRADUAL = 1e-8


def _opened(cosine: np.ndarray, abruptness: np.ndarray) -> np.ndarray:
    """Return w of the cosine of theta; the last axis of both is that of the machines."""
    some = np.abs(abruptness) > GRADUAL
    if not np.any(some):
        return cosine
    k = np.where(some, abruptness, 1.0)
    shaped = np.where(k > 0, np.tanh(k * cosine) / np.tanh(k), np.arctanh(np.tanh(k) * cosine) / k)
    return np.where(some, shaped, cosine)


def _turning_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    ratio, cos_angle, sin_angle, cos_opening, sin_opening, a, b, c, abruptness = parameters
    cos, sin = timeline.cos_sin(ratio)
    along, across = cos * cos_angle - sin * sin_angle, sin * cos_angle + cos * sin_angle
    open_ = along * cos_opening + across * sin_opening
    open_ = _opened(open_, abruptness)
    even, uneven = a * open_, b + c * open_
    double_cos, double_sin = uneven * (along**2 - across**2), uneven * (2 * along * across)
    none = np.zeros(cos.shape)
    return np.stack([none, none, even + double_cos, double_sin, double_sin, even - double_cos])


TURNING_STIFFNESS = Law("stiffness that turns with the shaft", _turning_signals)


def turning_stiffness(
    name: str,
    pair: tuple[Direction, Direction],
    *,
    shaft_ratio: float,
    angle_rad: float,
    opening_rad: float = 0.0,
    even: float = 0.0,
    uneven: float = 0.0,
    breathing: float = 0.0,
    abruptness: float = 0.0,
) -> InterfaceForce:
    """Return the force on ``pair`` (in x, in y), which is also what it reads.

    Parameters
    ----------
    name : str
    pair : tuple of Direction
    shaft_ratio : float
        Speed of the shaft over the reference shaft's.
    angle_rad : float
        Principal axis from x at shaft angle 0.
    opening_rad : float
        Direction, fixed in space, in which theta = 0.
    even, uneven, breathing, abruptness : float
        a, b, c, k of the module.
    """
    angles = (np.cos(angle_rad), np.sin(angle_rad), np.cos(opening_rad), np.sin(opening_rad))
    values = (shaft_ratio, *angles, even, uneven, breathing, abruptness)
    return InterfaceForce(name, TURNING_STIFFNESS, tuple(map(float, values)), pair, pair)
