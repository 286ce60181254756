"""The force of a bolted flange, linear in the motion: derived from its potential, and as printed. See `bolted_flange`.

Linearised about no relative motion and no twist, with E = e^(i phi), phi the ideal shaft angle, W = K r W1:

    force on rotor 2:  -K W0 (s + h E) - i (K W0 h + W) E e2 + i W E e1
    torque on rotor 2: -K W0 Re(s* i h E) - Re((s + h E)* i W E) - Re(z* i (K W0 h + W) E)
                       + [K W0 Re(s* h E) - Re(h* W) + Re(s* W E)] e2 + Re(h* W) e1
    torque on rotor 1:  Re((s + h E)* i W E) + Re(z* i W E) + Re(h* W) e2 - Re((s + h E)* W E) e1

What is left out is of second order: relative to the terms kept, about |z| / |s| and the twist in radians.
"""

from __future__ import annotations

import numpy as np

from ..law import Law, Timeline


def _linearised_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    stiffness, uneven_x, uneven_y, _, hole_x, hole_y, axis_x, axis_y, ratio = parameters
    cos, sin = timeline.cos_sin(ratio)
    turn = cos + 1j * sin
    hole, axis, uneven = (hole_x + 1j * hole_y) * turn, axis_x + 1j * axis_y, (uneven_x + 1j * uneven_y) * turn
    gap, both = axis + hole, stiffness * hole + uneven
    cross = np.real(np.conj(hole) * uneven)
    torque = np.real(np.conj(gap) * 1j * uneven)
    push = -stiffness * gap
    zero = np.zeros_like(cos)
    x, y = np.real, np.imag
    own_2 = stiffness * x(np.conj(axis) * hole) - cross + x(np.conj(axis) * uneven)
    return np.stack(
        [
            *(x(push), y(push), torque, -stiffness * x(np.conj(axis) * 1j * hole) - torque),
            *(zero, zero, x(1j * uneven), -x(1j * both)),
            *(zero, zero, y(1j * uneven), -y(1j * both)),
            *(x(1j * uneven), y(1j * uneven), -x(np.conj(gap) * uneven), cross),
            *(-x(1j * both), -y(1j * both), cross, own_2),
        ]
    )


def _printed_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    """Return Eq (16), then the coefficients of -Eq (15), for X, Y and the twist; stiffness[0] stands for N K_b d/2."""
    factor, offset, sign, ratio = parameters
    cos, sin = timeline.cos_sin(ratio)
    zero = np.zeros_like(cos)
    force = [-factor * cos, -sign * factor * sin, -factor * offset + zero]
    slope = [zero, zero, -factor * sin, zero, zero, -factor * cos, -factor * sin, -factor * cos, zero]
    return np.stack([*force, *slope])


LINEARISED_FLANGE = Law("bolted flange, linearised", _linearised_signals)
PRINTED_FLANGE = Law("bolted flange, as printed", _printed_signals)
