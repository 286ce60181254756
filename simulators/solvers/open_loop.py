"""Time stepping of machines whose forces do not depend on the motion: no stages, and all forces at once.

The exponential Runge-Kutta step then is y+ = e^(hL) y + h phi-weighted forces at the start, middle and end of the step.
The weighted forces of a whole block are one matrix product, and only e^(hL) y is left to be done step by step.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..compiled_code import njit
from ..system import System
from .block_form import BlockForm
from .kernel_types import OPTIONS
from .plan import ForcePlan
from .tables import StepTables

OpenLoop = Callable[[np.ndarray, np.ndarray], np.ndarray]


@njit(**OPTIONS)
def _recursion(full, first, last, path, state):  # type: ignore[no-untyped-def]
    """Replace the weighted forces in ``path`` (steps, states, lanes) by the states at the start of each step.

    ``state`` (states, lanes) is the first one and becomes the one after the last step.
    """
    lanes = state.shape[1]
    for step in range(path.shape[0]):
        now = path[step]
        for i in range(state.shape[0]):
            for lane in range(lanes):
                value = now[i, lane]
                for j in range(first[i], last[i]):
                    value += full[i, j] * state[j, lane]
                # The states of this step are still needed by the other rows of the block.
                now[i, lane] = value
        for i in range(state.shape[0]):
            for lane in range(lanes):
                value = now[i, lane]
                now[i, lane] = state[i, lane]
                state[i, lane] = value


def open_loop(form: BlockForm, system: System, plan: ForcePlan, tables: StepTables) -> OpenLoop | None:
    """Return ``advance(pushes, states) -> record`` as `kernel.run_block` does it, or None when a force reads motion.

    ``pushes`` (2 steps + 1, forces, lanes); ``states`` (states, lanes) is changed; record (steps, probes, lanes).
    """
    if plan.inputs.size or not system.is_linear or not plan.forces:
        return None
    weights = np.concatenate([tables.update[0], 2 * tables.update[1], tables.update[2]], axis=1)

    def advance(pushes: np.ndarray, states: np.ndarray) -> np.ndarray:
        start = pushes[0:-1:2]
        signals = np.concatenate([start, pushes[1::2], pushes[2::2]], axis=1)
        path = np.empty((start.shape[0], states.shape[0], states.shape[1]))
        record = np.empty((start.shape[0], form.probe_rows.shape[0], states.shape[1]))
        # Lane by lane: lanes then do not change a run's bits.
        for lane in range(states.shape[1]):
            path[:, :, lane] = signals[:, :, lane] @ weights.T
        _recursion(tables.full, tables.first, tables.last, path, states)
        for lane in range(states.shape[1]):
            record[:, :, lane] = path[:, :, lane] @ form.probe_rows.T
            record[:, :, lane] += start[:, :, lane] @ system.probe_columns.T
        return record

    return advance
