"""How the vectors of a step lie in one work matrix, and the products between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidValueError
from ..system import System
from .block_form import BlockForm
from .plan import ForcePlan
from .products_of_parts import pieces
from .tables import StepTables, jump_tables

#: Products work on blocks of at least so many rows; tables are filled up with zeros. Not more: tables that no longer
#: fit the cache of the first level (48 KiB, 6000 numbers) double the cost of a single lane's step.
ROWS = 4


@dataclass(frozen=True)
class Layout:
    """Work matrix and products of `kernel.run_block`.

    With n states, p motions, m forces and r probes the rows of the work matrix are: y (n), x (p), the motions at the
    stages b, a and c (3 p), the probes (r), y and x after the step (n + p), the forces u1 to u4 (4 m), and for each
    force u1, u2 + u3 and u4 (3 m).

    Attributes
    ----------
    memory : ndarray
        Tables, then the work matrix.
    work : ndarray (rows, lanes)
        View of it.
    rows : ndarray of int
        n, p, m, r, then the first row of y, x, b, the probes, y after the step, u1; address of `product.add_products`.
    program : ndarray of int (products, 5)
        Of each product: places of source, its columns, place of the target, its rows, place of the matrix.
    parts : ndarray of int (6,)
        Products of y; of u1, u2, u3; of the update: number ``parts[i]`` up to ``parts[i + 1]``.
    diagonals : ndarray (3, n)
        See `kernel.run_block`; zero where e^(hL) is a product of its own.
    """

    memory: np.ndarray
    work: np.ndarray
    rows: np.ndarray
    program: np.ndarray
    parts: np.ndarray
    diagonals: np.ndarray

    @property
    def states(self) -> np.ndarray:
        """View of the states (n, lanes)."""
        return self.work[self.rows[4] : self.rows[4] + self.rows[0]]

    @property
    def motions(self) -> np.ndarray:
        """View of the motions (p, lanes)."""
        return self.work[self.rows[5] : self.rows[5] + self.rows[1]]


def step_layout(form: BlockForm, system: System, tables: StepTables, lanes: int) -> Layout:
    """Return the layout of a step for so many lanes."""
    n, p, m, r = form.core.shape[0], form.motion_rows.shape[0], form.force_columns.shape[1], form.probe_rows.shape[0]
    from .law_call import address_of
    from .product import add_products

    # One row of zeros before and some behind: products are done in whole blocks.
    y = 1
    x, b = y + n, y + n + p
    seen = b + 3 * p
    following = seen + r
    u1 = following + n + p
    rows = np.array([n, p, m, r, y, x, b, seen, following, u1, address_of(add_products)], dtype=np.int64)
    update = np.stack([np.concatenate([own, form.motion_rows @ own]) for own in tables.update], axis=2)
    stages = tables.stages
    groups = [
        [(y, np.concatenate([tables.half_rows, tables.full_rows, form.probe_rows]), b + p)],
        [(u1, np.concatenate([stages[1], stages[0], stages[3], system.probe_columns]), b)],
        [(u1 + m, stages[2], b)],
        [(u1 + 2 * m, stages[4], b + 2 * p)],
        [(u1 + 4 * m, update.reshape(n + p, 3 * m), following)],
    ]
    diagonals = np.zeros((3, n))
    if form.is_blocks:
        index = np.arange(n)
        diagonals[1] = tables.full[index, index]
        diagonals[0, 1:], diagonals[2, :-1] = tables.full[index[1:], index[:-1]], tables.full[index[:-1], index[1:]]
    else:
        groups[0].append((y, tables.full, following))
    return _filled(groups, rows, diagonals, u1 + 7 * m + 2 * ROWS, lanes)


def _filled(groups: list[list[Any]], rows: np.ndarray, diagonals: np.ndarray, height: int, lanes: int) -> Layout:
    blocks, program, parts, at = [], [], [0], 0
    for group in groups:
        for source, matrix, target in group:
            for start, stop, first, last in pieces(matrix, rows=ROWS, lanes=lanes):
                height_of_it, columns = -(-(stop - start) // ROWS) * ROWS, last - first
                block = np.zeros((height_of_it, columns))
                block[: stop - start] = matrix[start:stop, first:last]
                blocks.append((block.T if lanes == 1 else block).ravel())
                program.append(((source + first) * lanes, columns, (target + start) * lanes, height_of_it, at))
                at += block.size
        parts.append(len(program))
    memory = np.zeros(at + height * lanes)
    memory[:at] = np.concatenate([*blocks, np.zeros(0)])
    made = np.array(program, dtype=np.int64).reshape(-1, 5)
    made[:, [0, 2]] += at
    work = memory[at:].reshape(height, lanes)
    return Layout(memory, work, rows, made, np.array(parts, dtype=np.int64), diagonals)


def jump_layout(form: BlockForm, plan: ForcePlan, layout: Layout, step_s: float) -> tuple[np.ndarray, ...]:
    """Return what `kernel_jump.apply_jump` needs: whole numbers, tables, room to work.

    The numbers are: address of the function, rows of x and of x and y after the step, n + p, the numbers k of a force's
    motions and j of its outputs, then for each jump force its number among all, then 0, 1, 2 ...
    The tables (forces x intervals, 3 j 4, k + n + p) hold the coefficients of `tables.JumpTables.cubics` for the rows
    of the force's k motions, of the states, of all motions.
    """
    if not plan.jumping:
        return np.zeros(1, dtype=np.int64), np.zeros((1, 1, 1)), np.zeros((1, 1))
    from .kernel_jump import apply_jump
    from .law_call import address_of

    reads = [plan.inputs[plan.rows[k, 1] : plan.rows[k, 2]] for k in plan.jumping]
    acts = [plan.outputs[plan.rows[k, 3] : plan.rows[k, 4]] for k in plan.jumping]
    deep, wide = reads[0].size, acts[0].size
    if any(read.size != deep for read in reads) or any(act.size != wide for act in acts):
        names = ", ".join(plan.forces[k].name for k in plan.jumping)
        raise InvalidValueError(
            f"The forces {names} jump and differ in the number of their motions or outputs; allowed: the same for all."
        )
    made = [jump_tables(form, form.force_columns[:, columns], step_s) for columns in acts]
    tables = []
    for table, read in zip(made, reads, strict=True):
        cubics = table.cubics
        motions = cubics @ form.motion_rows.T
        tables.append(np.concatenate([motions[:, :, read], cubics, motions], axis=2))
    n, p, following = int(layout.rows[0]), int(layout.rows[1]), int(layout.rows[8])
    height = n + p
    most = max(int(plan.rows[k, 8] - plan.rows[k, 7]) for k in plan.jumping)
    head = [address_of(apply_jump), int(layout.rows[5]), following + n, following, height, deep, wide]
    numbers = np.array([*head, *plan.jumping, *range(max(deep, wide))], dtype=np.int64)
    room = np.zeros((most + 6 * deep + 9 * wide + 2 * height, 1))
    return numbers, np.ascontiguousarray(np.concatenate(tables)), room
