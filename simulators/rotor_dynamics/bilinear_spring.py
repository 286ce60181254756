"""A spring that loses part of its stiffness when it is pulled: a loose foot, a bearing housing with slack bolts.

With the elongation d (positive: pulled) and the elongation d_0 at which the joint opens, each metre beyond d_0 costs
(1 - loss) k only:

    F = - k d + loss k ramp(d - d_0).

-k d is in the linear core; the rest is the interface force, and exactly zero while the joint stays closed.
"""

from __future__ import annotations

import numpy as np

from ..law import Direction, InterfaceForce, Law, compiled_force, no_signals
from .contact import rounded_ramp


@compiled_force
def _lifted(signals, parameters, x, inputs, outputs, u):  # type: ignore[no-untyped-def]
    for lane in range(u.shape[1]):
        lift = rounded_ramp(x[inputs[0], lane] - parameters[1, lane], parameters[2, lane])
        u[outputs[0], lane] += parameters[0, lane] * lift


def _stiffest(parameters: np.ndarray) -> float:
    return float(parameters[0])


BILINEAR_SPRING = Law("spring that is softer when pulled", no_signals, _lifted, stiffest=_stiffest)


def loosened(name: str, along: Direction, *, lost_n_m: float, lift_m: float, width_m: float) -> InterfaceForce:
    """Return what a spring in the linear core loses when its elongation ``along`` exceeds ``lift_m``.

    Parameters
    ----------
    name : str
    along : Direction
    lost_n_m : float
        loss k.
    lift_m : float
        d_0.
    width_m : float
        The corner is rounded over this much to both sides.
    """
    return InterfaceForce(name, BILINEAR_SPRING, (lost_n_m, lift_m, width_m), (along,), (along,))
