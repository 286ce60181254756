"""One part of a dataset: draw its signals, simulate them side by side, measure them, make the file's bytes.

What a part holds depends on the recipe and its number only. A draw that gives no usable signal is refused with the
reason; it is counted, and its number stays empty.
"""

from __future__ import annotations

import contextlib
import functools
import platform
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from ..simulators.solvers.blas import single_blas_thread
from .errors import RotorwiseError
from .generate_table import parquet_bytes, schema_of
from .recipe import Recipe
from .recipe_draw import Drawn, Position, draw_signal, position_of, severity_of, split_of
from .recipe_file import recipe_from_json
from .recipe_parts import Parts, part_name
from .simulated import label_of, measured, recordable

if TYPE_CHECKING:
    from ..simulators.solvers.simulate import Simulation

#: Of what a file's metadata say.
FORMAT = 1
_PACKAGES = ("rotorwise", "numpy", "scipy", "numba", "pyarrow")
_LONGEST_REASON = 400


@dataclass(frozen=True)
class Part:
    """A finished part.

    Attributes
    ----------
    number : int
    name : str
    facts : dict
        What the file's metadata say: fingerprint, first and number of signals, rows, refused draws, counts, versions.
    content : bytes
        The file; empty when it has been written already.
    """

    number: int
    name: str
    facts: dict[str, Any]
    content: bytes


@single_blas_thread
def make_part(source: str, number: int, *, limit: int | None = None) -> Part:
    """Compute one part.

    Parameters
    ----------
    source : str
        `Recipe.source`.
    number : int
    limit : int, optional
        The dataset ends before this signal.
    """
    recipe = recipe_from_json(source)
    numbers = Parts(recipe, limit).numbers(number)
    rows, refused = [], []
    for position, outcome in _outcomes(recipe, [position_of(recipe, one) for one in numbers]):
        if isinstance(outcome, str):
            refused.append({**_where(position), "reason": outcome[:_LONGEST_REASON]})
        else:
            rows.append(outcome)
    rows.sort(key=lambda row: row["signal"])
    facts = {
        "format": FORMAT,
        "fingerprint": recipe.fingerprint,
        "part": number,
        "first": numbers.start,
        "signals": len(numbers),
        "rows": len(rows),
        "refused": sorted(refused, key=lambda one: one["signal"]),
        "counts": _counts(rows),
        "versions": versions(),
    }
    return Part(number, part_name(number), facts, parquet_bytes(schema_of(recipe), rows, facts))


def warm_up(source: str) -> None:
    """Compile what the recipe's machines need, by a few steps of one signal of each case, alone and side by side."""
    from ..simulators.solvers.simulate import simulate_motion

    recipe = recipe_from_json(source)
    number = 0
    for own in recipe.machines:
        for case in own.cases:
            with contextlib.suppress(RotorwiseError, np.linalg.LinAlgError), np.errstate(all="ignore"):
                drawn = draw_signal(recipe, position_of(recipe, number))
                for lanes in (1, 2):
                    cases = [(drawn.machine, drawn.speed_rpm)] * lanes
                    simulate_motion(cases, duration_s=2 / own.rate_hz, rate_hz=own.rate_hz, settle_s=0.0)
            number += case.faults * own.conditions


@functools.cache
def versions() -> dict[str, str]:
    """Return the versions of what decides about the numbers."""
    return {**{name: version(name) for name in _PACKAGES}, "python": platform.python_version()}


def _where(position: Position) -> dict[str, Any]:
    name = position.recipe.name
    return {"signal": position.number, "machine": name, "group": f"{name}-{position.draw}", "case": position.case.name}


def _counts(rows: Sequence[dict[str, Any]]) -> list[list[Any]]:
    """Return machine, case, split and number of rows of each kind."""
    found = Counter((row["machine"], row["case"], row["split"]) for row in rows)
    return [[*kind, count] for kind, count in sorted(found.items())]


def _outcomes(recipe: Recipe, positions: Sequence[Position]) -> Iterator[tuple[Position, dict[str, Any] | str]]:
    """Yield each signal's row, or why there is none."""
    drawn: list[Drawn] = []
    for position in positions:
        try:
            drawn.append(draw_signal(recipe, position))
        except RotorwiseError as problem:
            yield position, str(problem)
    for own in recipe.machines:
        yield from _simulated(recipe, [one for one in drawn if one.position.recipe is own])


def _simulated(recipe: Recipe, drawn: Sequence[Drawn]) -> Iterator[tuple[Position, dict[str, Any] | str]]:
    runs = list({one.position.run: one for one in drawn}.values())
    motions = dict(zip((one.position.run for one in runs), _motions(runs), strict=True))
    for one in drawn:
        raw = motions[one.position.run]
        if isinstance(raw, str):
            yield one.position, raw
            continue
        try:
            yield one.position, _row(recipe, one, _record(raw, one.position))
        except RotorwiseError as problem:
            yield one.position, str(problem)


def _motions(runs: Sequence[Drawn]) -> list[Simulation | str]:
    """Return the motions side by side; where one fails, the halves by themselves until it stands alone."""
    from ..simulators.solvers.simulate import simulate_raw

    if not runs:
        return []
    own = runs[0].position.recipe
    cases = [(one.machine, one.speed_rpm) for one in runs]
    try:
        # An unstable machine leaves the number range on the way; `measured` looks at what it leaves.
        with np.errstate(over="ignore", invalid="ignore"):
            duration = own.records * own.samples / own.rate_hz
            return list(simulate_raw(cases, duration_s=duration, rate_hz=own.rate_hz, probes=own.probes))
    except (RotorwiseError, np.linalg.LinAlgError) as problem:
        if len(runs) == 1:
            return [str(problem)]
        half = len(runs) // 2
        return _motions(runs[:half]) + _motions(runs[half:])


def _record(raw: Simulation, position: Position) -> Simulation:
    """Return the stretch of a run that belongs to a signal, with what the measuring chain needs beyond its end."""
    own = position.recipe
    factor = round(raw.rate_hz / own.rate_hz)
    beyond = raw.signals.shape[1] - own.records * own.samples * factor
    part = slice(position.record * own.samples * factor, (position.record + 1) * own.samples * factor + beyond)
    return replace(raw, signals=raw.signals[:, part], phase_rad=raw.phase_rad[part], speed_rad_s=raw.speed_rad_s[part])


def _row(recipe: Recipe, drawn: Drawn, raw: Simulation) -> dict[str, Any]:
    position, own, machine = drawn.position, drawn.position.recipe, drawn.machine
    kept, _ = recordable(raw.probes, own.probes)
    chain = drawn.chain
    signals, channels = measured(
        raw, machine, kept, rate_hz=own.rate_hz, samples=own.samples, chain=chain, seed=drawn.seed
    )
    load_name = machine.definition.load_parameter
    units = {one.name: one.unit for one in machine.definition.parameters}
    effects = machine.effects[len(own.machine.effects) :]
    row: dict[str, Any] = {
        **_where(position),
        "split": split_of(recipe, position.draw),
        "fault": position.fault,
        "record": position.record,
        "label": label_of(effects),
        "effects": [effect.NAME for effect in effects],
        "speed_rpm": drawn.speed_rpm,
        "load": drawn.load,
        "load_unit": units.get(load_name),
        "seed": drawn.seed,
        "rate_hz": own.rate_hz,
        "samples": own.samples,
        "pulses_per_revolution": chain.pulses_per_revolution * chain.tacho_ratio or None,
        "step_s": raw.step_s,
        "notes": list(raw.notes),
        "chain": repr(chain),
        "machine_toml": machine.to_toml(),
    }
    row |= {f"severity.{name}": value for name, value in severity_of(recipe, drawn.values).items()}
    row |= drawn.values
    return row | {
        f"signal.{one.name}": signal for one, signal in zip(channels, signals.astype(np.float32), strict=True)
    }
