"""Runs a group of lanes through the compiled loop: tables, start, blocks, decimation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidValueError
from ..machine import Machine
from ..speed_profile import SpeedProfile
from ..system import System
from .block_form import BlockForm, block_form
from .decimation import Decimator, filter_half_length
from .equilibrium import static_equilibrium
from .open_loop import open_loop
from .plan import ForcePlan, block_signals, force_plan, quiet
from .tables import jump_tables, step_tables

#: Numbers in the signals of one block: small enough for the cache of the second level to help.
BLOCK_NUMBERS = 2_000_000


@dataclass(frozen=True)
class LaneGroup:
    """Machines that share a linear core, with their systems and speeds."""

    machines: list[Machine]
    profiles: list[SpeedProfile]
    systems: list[System]


class Stepper:
    """The state of a group of lanes and what advances it.

    Parameters
    ----------
    group : LaneGroup
    step_s : float
    start_s : float
        Time of the first step.
    modal, highest_hz
        See `block_form`.
    """

    def __init__(
        self,
        group: LaneGroup,
        *,
        step_s: float,
        start_s: float,
        modal: bool = True,
        highest_hz: float | None = None,
    ) -> None:
        self.system = group.systems[0]
        self.step_s, self.start_s, self.done = step_s, start_s, 0
        self.form = block_form(self.system, modal=modal, highest_hz=highest_hz)
        self.plan = force_plan(group.systems, group.profiles)
        self._tables = _kernel_tables(self.form, self.system, step_s)
        self._open_loop = open_loop(self.form, self.system, self.plan, step_s)
        self._jump = _kernel_jump(self.form, self.plan, step_s)
        self.states = static_equilibrium(self.system, self.plan, start_s, self.form)
        numbers = 3 * self.plan.signals * self.plan.lanes
        self.block = int(np.clip(BLOCK_NUMBERS // max(1, numbers), 64, 4096))

    def advance(self, steps: int) -> np.ndarray:
        """Advance by ``steps`` and return the probes at the start of each step, shape (steps, probes, lanes)."""
        start = self.start_s + self.done * self.step_s
        record = self._run(*block_signals(self.plan, start, self.step_s, steps), steps)
        self.done += steps
        return record

    def _run(self, signals: np.ndarray, events: np.ndarray, branches: np.ndarray, steps: int) -> np.ndarray:
        if self._open_loop is not None:
            return self._open_loop(signals[:steps], self.states)
        from .kernel import PARTS, run_block

        record = np.empty((steps, len(self.system.probes), self.plan.lanes))
        plan = self.plan
        with quiet:
            run_block(
                PARTS,
                plan.laws,
                plan.rows,
                plan.inputs,
                plan.outputs,
                plan.parameters,
                self.step_s,
                self._tables,
                self._jump,
                signals[:steps],
                events,
                branches,
                self.states,
                record,
            )
        return record


def run_group(
    group: LaneGroup,
    *,
    duration_s: float,
    rate_hz: float,
    settle_s: float,
    factor: int,
    modal: bool,
    highest_hz: float | None,
) -> list[np.ndarray]:
    """Return the decimated probe signals of each lane, a list of (probes, samples).

    Parameters
    ----------
    group : LaneGroup
    duration_s, rate_hz, settle_s : float
    factor : int
        Steps for each output sample.
    modal, highest_hz
        See `block_form`.
    """
    step = 1.0 / (rate_hz * factor)
    before = int(np.ceil(settle_s * rate_hz)) * factor
    margin = filter_half_length(factor)
    samples = int(np.floor(duration_s * rate_hz + 1e-9))
    stepper = Stepper(group, step_s=step, start_s=-(before + margin) * step, modal=modal, highest_hz=highest_hz)
    while stepper.done < before:
        stepper.advance(min(stepper.block, before - stepper.done))
        if not np.all(np.isfinite(stepper.states)):
            break
    decimate = Decimator(factor)
    wanted = before + 2 * margin + (samples - 1) * factor + 1
    parts = []
    while stepper.done < wanted:
        record = stepper.advance(min(stepper.block, wanted - stepper.done))
        parts.append(decimate(record.reshape(record.shape[0], -1)))
        if not np.all(np.isfinite(stepper.states)):
            parts.append(np.full((samples, parts[-1].shape[1]), np.nan))
            break
    joined = np.concatenate(parts)[:samples].reshape(samples, -1, stepper.plan.lanes)
    return [np.ascontiguousarray(joined[:, :, lane].T) for lane in range(stepper.plan.lanes)]


def _kernel_tables(form: BlockForm, system: System, step_s: float) -> tuple[Any, ...]:
    tables = step_tables(form, step_s)
    ahead = np.concatenate([tables.half_rows, tables.full_rows, form.probe_rows])
    return (
        tables.full,
        tables.first,
        tables.last,
        _pair(ahead),
        tuple(_pair(stage) for stage in tables.stages),
        tuple(_pair(np.concatenate([weights, form.motion_rows @ weights])) for weights in tables.update),
        _pair(form.motion_rows),
        _pair(system.probe_columns),
    )


def _pair(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (transpose, itself), both contiguous: the compiled loop reads columns or rows."""
    return np.ascontiguousarray(matrix.T), np.ascontiguousarray(matrix)


def _kernel_jump(form: BlockForm, plan: ForcePlan, step_s: float) -> tuple[Any, ...]:
    """Return table spacing, state tables, motion-row tables, the numbers of the forces that jump, and room to work."""
    from .kernel_jump import jump_work

    n = form.core.shape[0]
    if not plan.jumping:
        empty = (np.zeros((1, 4, 2, n, 1)), np.zeros((1, 4, 2, 2, 1)))
        return step_s, *empty, np.zeros(0, dtype=np.int64), *jump_work(n, 2, 1, 1)
    reads = [plan.inputs[plan.rows[k, 1] : plan.rows[k, 2]] for k in plan.jumping]
    acts = [plan.outputs[plan.rows[k, 3] : plan.rows[k, 4]] for k in plan.jumping]
    deep, wide = reads[0].size, acts[0].size
    if any(read.size != deep for read in reads) or any(act.size != wide for act in acts):
        names = ", ".join(plan.forces[k].name for k in plan.jumping)
        raise InvalidValueError(
            f"The forces {names} jump and differ in the number of their motions or outputs; allowed: the same for all."
        )
    made = [jump_tables(form, form.force_columns[:, columns], step_s) for columns in acts]
    states = np.stack([table.states for table in made])
    rows = np.stack([form.motion_rows[read] @ table.states for table, read in zip(made, reads, strict=True)])
    most = max(int(plan.rows[k, 8] - plan.rows[k, 7]) for k in plan.jumping)
    numbers = np.array(plan.jumping, dtype=np.int64)
    return made[0].spacing_s, states, rows, numbers, *jump_work(n, deep, wide, most)
