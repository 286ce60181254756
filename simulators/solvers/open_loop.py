"""Time stepping of machines whose forces do not depend on the motion: no stages, and all forces at once.

The exponential Runge-Kutta step then is y+ = e^(hL) y + h phi-weighted forces at the start, middle and end of the step.
The weighted forces of a whole block are one matrix product, and only e^(hL) y is left to be done step by step.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np

from ..system import System
from .block_form import BlockForm
from .kernel_parts import OPTIONS
from .plan import ForcePlan
from .tables import step_tables

OpenLoop = Callable[[np.ndarray, np.ndarray], np.ndarray]


@numba.njit(**OPTIONS)
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


def open_loop(form: BlockForm, system: System, plan: ForcePlan, step_s: float) -> OpenLoop | None:
    """Return ``advance(signals, states) -> record`` as `kernel.run_block` does it, or None when a force reads motion.

    ``signals`` (steps, 3, forces, lanes); ``states`` (states, lanes) is changed; record (steps, probes, lanes).
    """
    if plan.inputs.size or not system.is_linear or not plan.forces:
        return None
    tables = step_tables(form, step_s)
    weights = np.stack([tables.update[0], 2 * tables.update[1], tables.update[2]])

    def advance(signals: np.ndarray, states: np.ndarray) -> np.ndarray:
        path = np.tensordot(weights, signals, axes=([0, 2], [1, 2])).transpose(1, 0, 2)
        path = np.ascontiguousarray(path)
        _recursion(tables.full, tables.first, tables.last, path, states)
        record = np.tensordot(form.probe_rows, path, axes=(1, 1))
        record += np.tensordot(system.probe_columns, signals[:, 0], axes=(1, 1))
        return np.ascontiguousarray(record.transpose(1, 0, 2))

    return advance
