"""Critical speeds that a run-up or coast-down passes, from the 1X that ``rotorwise orders`` follows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .look import Looked
    from .orders import Orders
    from .signal.critical_speed import CriticalSpeed

#: Derivatives of displacement.
_DERIVATIVES = {"displacement": 0, "velocity": 1, "acceleration": 2}


def passed_speeds(looked: Looked, found: Orders) -> tuple[CriticalSpeed, ...]:
    """Return the critical speeds that all channels together show.

    None without a tacho's mark, as 1X then has no phase, and where the speed does not go one way.
    """
    if not found.shaft.has_mark or not found.goes_one_way:
        return ()
    from .signal.critical_speed import critical_speeds

    turning, values = 2 * np.pi * found.speed_hz, []
    for one in found.followed:
        derivative = _DERIVATIVES.get(looked.recording.channels[one.channel].quantity or "")
        if one.order == 1.0 and derivative is not None:
            values.append(one.amplitude * np.exp(1j * np.radians(one.phase_deg)) / (1j * turning) ** derivative)
    if not values:
        return ()
    # Values closer in time tell nothing new: the order filters have tied them to each other.
    stride = max(1, math.ceil(1 / (found.bandwidth_hz * float(found.time_s[1] - found.time_s[0]))))
    seen = np.flatnonzero(np.isfinite(values).all(axis=0))[::stride]
    rpm = 60 * found.speed_hz
    # Measured speeds scatter; their derivative would scatter more.
    rate = np.polynomial.Polynomial.fit(found.time_s, rpm, 3).deriv()(found.time_s)
    return critical_speeds(rpm[seen], np.array(values)[:, seen], rate_rpm_s=rate[seen])
