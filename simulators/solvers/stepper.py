"""Runs a group of lanes through the compiled loop: tables, start, blocks, decimation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..law import RUN
from ..machine import Machine
from ..speed_profile import SpeedProfile
from ..system import System
from .block_form import block_form
from .decimation import Decimator, filter_half_length
from .equilibrium import static_equilibrium
from .layout import jump_layout, step_layout
from .open_loop import open_loop
from .plan import ForcePlan, Room, block_signals, force_plan
from .products_of_parts import in_order_of_parts
from .tables import step_tables

#: Numbers in the signals of one block. Fewer leave 64 lanes with blocks so short that preparing them costs as much as
#: what is prepared (a seventh of the run at 2 million), more leave the caches.
BLOCK_NUMBERS = 8_000_000
#: Without forces that read the motion a block is one matrix product, whose bits may depend on its length.
OPEN_LOOP_BLOCK = 1024


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
        self.system = in_order_of_parts(group.systems[0])
        self.step_s, self.start_s, self.done = step_s, start_s, 0
        self.form = block_form(self.system, modal=modal, highest_hz=highest_hz)
        self.plan = force_plan([self.system, *group.systems[1:]], group.profiles)
        tables = step_tables(self.form, step_s)
        self._open_loop = open_loop(self.form, self.system, self.plan, tables)
        self.states = static_equilibrium(self.system, self.plan, start_s, self.form)
        self._layout = step_layout(self.form, self.system, tables, self.plan.lanes)
        self._jump = jump_layout(self.form, self.plan, self._layout, step_s)
        self._plan = _kernel_plan(self.plan)
        self._room = Room()
        linear, compiled, jumping = self.plan.signal_counts
        numbers = (2 * (self.plan.columns + linear + compiled) + 3 * jumping) * self.plan.lanes
        # A whole number of runs of `Timeline.cos_sin`: how many lanes there are then does not show in the bits.
        self.block = RUN * int(np.clip(BLOCK_NUMBERS // max(1, numbers) // RUN, 1, 4096 // RUN))
        if self._open_loop is not None:
            self.block = OPEN_LOOP_BLOCK

    def advance(self, steps: int) -> np.ndarray:
        """Advance by ``steps`` and return the probes at the start of each step, shape (steps, probes, lanes)."""
        signals = block_signals(self.plan, self.start_s, self.step_s, steps, self._room, done=self.done)
        self.done += steps
        if self._open_loop is not None:
            return self._open_loop(signals.pushes, self.states)
        from .kernel import run_block

        layout = self._layout
        self._enter_states()
        record = np.empty((steps, len(self.system.probes), self.plan.lanes))
        run_block(
            layout.memory,
            layout.work,
            tuple(layout.rows.tolist()),
            layout.program,
            layout.parts,
            layout.diagonals,
            self._plan,
            self.plan.parameters,
            (signals.pushes, signals.coefficients, signals.halves, signals.jumped),
            self._jump,
            signals.events,
            signals.branches,
            record,
        )
        self.states[:] = layout.states
        return record

    def _enter_states(self) -> None:
        """Put the states into the work matrix, and their motions where they were changed from outside."""
        if np.array_equal(self._layout.states, self.states):
            return
        self._layout.states[:] = self.states
        # In the order of the compiled sums, whatever the number of lanes.
        motions = self._layout.motions
        motions[:] = 0.0
        for column, state in zip(self.form.motion_rows.T, self.states, strict=True):
            motions += column[:, None] * state


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
    shape = len(stepper.system.probes), stepper.plan.lanes
    signals = np.empty((shape[1], shape[0], samples))
    done = 0
    while stepper.done < wanted:
        record = stepper.advance(min(stepper.block, wanted - stepper.done))
        part = decimate(record.reshape(record.shape[0], -1))[: samples - done]
        # Turned while it is in the cache: of the whole run, this costs ten times as much.
        signals[:, :, done : done + part.shape[0]] = part.reshape(-1, *shape).transpose(2, 1, 0)
        done += part.shape[0]
        if not np.all(np.isfinite(stepper.states)):
            break
    signals[:, :, done:] = np.nan
    return list(signals)


def _kernel_plan(plan: ForcePlan) -> tuple[np.ndarray, ...]:
    addresses: list[int] = []
    if plan.laws:
        from .law_call import address_of

        addresses = [address_of(law.compiled) for law in plan.laws]
    return plan.rows, plan.inputs, plan.outputs, np.array(addresses, dtype=np.int64)
