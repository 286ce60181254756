"""The force of a bolted flange from its exact potential; see `bolted_flange`.

With F = -grad U, E1 = e^(i phi1), E2 = e^(i phi2) and W = K r W1:

    force on rotor 2, minus on rotor 1:  -K W0 D - W (E2 - E1)
    torque on rotor 2:  -K W0 [ Re((z + s)* i h E2) + r^2 sin(phi2 - phi1) ] - Re((i h E2)* W (E2 - E1)) - Re(D* i W E2)
    torque on rotor 1:   K W0 r^2 sin(phi2 - phi1) + Re(D* i W E1)

The springs of an aligned flange, K W0 z and K W0 r^2 (phi2 - phi1), stand in the linear core and are left out here.
"""

from __future__ import annotations

import math

import numpy as np

from ..law import Law, Timeline, compiled_force


def _signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    return np.stack(timeline.cos_sin(parameters[8]))


@compiled_force
def _force(signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    for lane in range(x.shape[1]):
        stiffness, torsional = parameters[0, lane], parameters[3, lane]
        uneven = complex(parameters[1, lane], parameters[2, lane])
        hole = complex(parameters[4, lane], parameters[5, lane])
        axis = complex(parameters[6, lane], parameters[7, lane])
        angle = complex(signals[0, lane], signals[1, lane])
        relative = complex(x[inputs[0], lane], x[inputs[1], lane])
        turn_1, turn_2 = x[inputs[2], lane], x[inputs[3], lane]
        first = angle * complex(math.cos(turn_1), math.sin(turn_1))
        second = angle * complex(math.cos(turn_2), math.sin(turn_2))
        hole = hole * second
        gap = relative + axis + hole
        unequal = uneven * (second - first)
        push = stiffness * (axis + hole) + unequal
        twist = turn_2 - turn_1
        shear = torsional * (math.sin(twist) - twist)
        # Re(a* i b) = imag(a) real(b) - real(a) imag(b).
        from_offset = stiffness * ((relative + axis).imag * hole.real - (relative + axis).real * hole.imag)
        from_twist = hole.real * unequal.imag - hole.imag * unequal.real
        one, two = uneven * first, uneven * second
        u[outputs[0], lane] -= push.real
        u[outputs[1], lane] -= push.imag
        u[outputs[2], lane] += shear + gap.imag * one.real - gap.real * one.imag
        u[outputs[3], lane] -= shear + from_offset + from_twist + gap.imag * two.real - gap.real * two.imag


EXACT_FLANGE = Law("bolted flange", _signals, _force, nearly_linear=True)
