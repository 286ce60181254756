"""Whether a machine runs at all: a motion that repeats may be one that the machine leaves at the least touch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...simulators.errors import InvalidValueError
from ...simulators.machine import Machine
from ...simulators.solvers.floquet import floquet_multipliers
from ...simulators.solvers.simulate import SimulationError

#: Steps a turn: the springs and dampers that are added do not change within one.
STEPS = 16
#: A run of a machine whose forces are not linear in the motion: how long after it has settled, s and Hz.
RUN_S, RATE_HZ = 0.1, 200.0
#: About so many speeds of a campaign are asked.
MOST_ASKED = 4


def is_stable(machine: Machine, speeds_rpm: Sequence[float]) -> bool:
    """Return whether every free motion of a machine decays at all of these speeds.

    A machine whose forces are not linear in the motion is run from rest at the lowest and the highest of them: does it
    stay within bounds?
    """
    try:
        # What grows by more than numbers hold in one turn is not stable either.
        with np.errstate(over="ignore", invalid="ignore"):
            return all(floquet_multipliers(machine, speed_rpm=one, steps=STEPS).is_stable for one in speeds_rpm)
    except np.linalg.LinAlgError:
        return False
    except InvalidValueError:
        return all(_stays(machine, one) for one in {min(speeds_rpm), max(speeds_rpm)})


def unstable_words(machine: Machine, speeds_rpm: Sequence[float]) -> tuple[str, ...]:
    """Return a note on a machine that does not run at these speeds; nothing of one that does."""
    some = sorted(speeds_rpm)[:: max(len(speeds_rpm) // MOST_ASKED, 1)]
    if is_stable(machine, some):
        return ()
    return (
        f"The machine as given ({machine.name}, preset {machine.preset_name}) does not run stably at these speeds: "
        "what its simulation lacks means little. Check preset and parameters.",
    )


def _stays(machine: Machine, speed_rpm: float) -> bool:
    try:
        machine.simulate(speed_rpm=speed_rpm, duration_s=RUN_S, rate_hz=RATE_HZ)
    except SimulationError:
        return False
    return True
