"""From the number of a signal to its machine, speed, chain and labels. Nothing is listed: each is computed alone.

Signals count through the machine draws; within one through the recipe's machines; within a machine through cases,
faults, speeds, loads and records, the last fastest. Every random number has a stream of its own, made from the seed,
the machine, the draw and the parameter's name: it depends neither on other parameters nor on who computes it.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass

import numpy as np

from ..simulators.effect import Effect, effect_catalogue, make_effect
from ..simulators.machine import Machine
from ..simulators.sensor_chain import SensorChain
from .errors import InvalidValueError
from .recipe import Case, MachineRecipe, Recipe
from .recipe_chain import chain_of
from .recipe_values import Choice

_MACHINE, _CONDITION, _FAULT, _CHAIN, _SEED = range(5)
_GOLDEN = (math.sqrt(5) - 1) / 2


@dataclass(frozen=True)
class Position:
    """Where a signal stands in a recipe.

    Attributes
    ----------
    number, draw : int
    recipe : MachineRecipe
    case : Case
    fault, speed, load, record : int
        Number of the fault within its case, of the speed, of the load and of the signal within its run.
    """

    number: int
    draw: int
    recipe: MachineRecipe
    case: Case
    fault: int
    speed: int
    load: int
    record: int

    @property
    def run(self) -> tuple[object, ...]:
        """What the signals of one run have in common."""
        return self.draw, self.recipe.name, self.case.name, self.fault, self.speed, self.load


@dataclass(frozen=True)
class Drawn:
    """A signal before it is simulated.

    Attributes
    ----------
    position : Position
    machine : Machine
        With all its effects.
    speed_rpm : float
    load : float or None
    chain : SensorChain
    seed : int
        Of the measuring chain.
    values : dict of str to float
        Everything that was chosen, by column.
    """

    position: Position
    machine: Machine
    speed_rpm: float
    load: float | None
    chain: SensorChain
    seed: int
    values: dict[str, float]


def position_of(recipe: Recipe, number: int) -> Position:
    """Return where a signal stands.

    Raises
    ------
    InvalidValueError
        When the recipe has no such signal.
    """
    if not 0 <= number < recipe.signals:
        raise InvalidValueError(f"Signal {number}; allowed: 0 to {recipe.signals - 1}.")
    draw, rest = divmod(number, recipe.per_round)
    for machine in recipe.machines:
        if rest < machine.per_draw:
            break
        rest -= machine.per_draw
    for case in machine.cases:
        if rest < case.faults * machine.conditions:
            break
        rest -= case.faults * machine.conditions
    fault, condition = divmod(rest, machine.conditions)
    condition, record = divmod(condition, machine.records)
    loads = machine.load.count if machine.load else 1
    return Position(number, draw, machine, case, fault, *divmod(condition, loads), record)


def draw_signal(recipe: Recipe, position: Position) -> Drawn:
    """Return the machine with its effects, its speed, its measuring chain and what was chosen for them.

    Raises
    ------
    InvalidValueError
        When the values drawn do not fit together.
    """
    own, case = position.recipe, position.case
    values = {f"machine.{name}": _machine_value(recipe, position, name, c) for name, c in own.parameters.items()}
    values |= _fault_values(recipe, position)
    speed = own.speed_rpm.draw(_stream(recipe, _CONDITION, position, position.speed, "speed"), position.speed)
    load = None
    changed = {name.removeprefix("machine."): v for name, v in values.items() if name.startswith("machine.")}
    if own.load is not None:
        load = own.load.draw(_stream(recipe, _CONDITION, position, position.load, "load"), position.load)
        changed[own.machine.definition.load_parameter] = load
    elif own.machine.definition.load_parameter:
        load = own.machine.values[own.machine.definition.load_parameter]
    effects: list[Effect] = []
    for one in case.effects:
        chosen = {name: values[f"{one.column}.{name}"] for name in one.values}
        made = make_effect(one.name, chosen, at=one.at)
        effects.append(made)
        values |= {f"{one.column}.{name}": value for name, value in made.values().items()}
    chain = {
        name: choice.draw(_stream(recipe, _CHAIN, position, position.number, name))
        for name, choice in recipe.chain.items()
    }
    values |= {f"chain.{name}": value for name, value in chain.items() if not recipe.chain[name].is_fixed}
    seed = int(np.random.SeedSequence([recipe.seed, _SEED, position.number]).generate_state(1, np.uint64)[0]) >> 1
    machine = own.machine.with_parameters(**changed).with_effects(*effects)
    return Drawn(position, machine, speed, load, chain_of(chain), seed, values)


def _machine_value(recipe: Recipe, position: Position, name: str, choice: Choice) -> float:
    return choice.draw(_stream(recipe, _MACHINE, position, 0, name))


def _fault_values(recipe: Recipe, position: Position) -> dict[str, float]:
    cell = position.fault // position.case.instances
    case = zlib.crc32(position.case.name.encode())
    found = {}
    for column, choice in reversed(position.case.choices):
        cell, own = divmod(cell, choice.count)
        found[column] = choice.draw(_stream(recipe, _FAULT, position, position.fault, column, case), own)
    return dict(reversed(found.items()))


def _stream(
    recipe: Recipe, kind: int, position: Position, number: int, name: str, case: int = 0
) -> np.random.Generator:
    words = zlib.crc32(position.recipe.name.encode()), zlib.crc32(name.encode())
    return np.random.default_rng([recipe.seed, kind, position.draw, number, case, *words])


def split_of(recipe: Recipe, draw: int) -> str:
    """Return the split of a machine draw; shares are met as closely as possible in every run of draws.

    The multiples of the golden ratio fill the interval from 0 to 1 evenly.
    """
    place, end = (draw + 1) * _GOLDEN % 1.0, 0.0
    for name, share in recipe.splits.items():
        end += share
        if place < end:
            return name
    return list(recipe.splits)[-1]


def label_columns(recipe: Recipe) -> dict[str, str]:
    """Return the columns of what is chosen and the unit of each: machine parameters, effects, chain."""
    units: dict[str, str] = {}
    known = effect_catalogue()
    for one in recipe.machines:
        declared = {p.name: p.unit for p in one.machine.definition.parameters}
        for name in [*one.parameters, *(name for case in one.cases for name in case.parameters)]:
            units.setdefault(f"machine.{name}", declared[name])
    for one in recipe.machines:
        for effect in [effect for case in one.cases for effect in case.effects]:
            for parameter in known[effect.name].parameters():
                units.setdefault(f"{effect.column}.{parameter.name}", parameter.unit)
    for name, choice in recipe.chain.items():
        if not choice.is_fixed:
            units[f"chain.{name}"] = _chain_unit(name)
    return units


def _chain_unit(name: str) -> str:
    setting, _, unit = name.partition(".")
    if unit:
        return f"{unit}/sqrt(Hz)" if setting == "noise" else unit
    return "Hz" if setting.endswith("_hz") else ""


def severity_of(recipe: Recipe, values: dict[str, float]) -> dict[str, float]:
    """Return the severity labels: the value of the first column that the signal has, else 0."""
    return {
        name: next((values[source] for source in sources if source in values), 0.0)
        for name, sources in recipe.severity.items()
    }
