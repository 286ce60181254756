"""A recipe: which machines with which faults, at which speeds and loads, measured how, and how often.

A *machine draw* is one machine of a kind, with parameters of its own. It is measured in every case of the recipe, at
its own speeds and loads. A *case* is a state of the machine, healthy or with one or more effects; a case may have a
grid of severities and several *instances*, each with values of its own. Splits go by machine draw: no machine is in
two of them.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from ..simulators.machine import Machine
from .recipe_values import Choice

#: Raised when the same recipe gives other content than before.
CONTENT = 1


@dataclass(frozen=True)
class EffectRecipe:
    """An effect of a case: its name, where it acts, and what is said of its parameters (the others keep theirs)."""

    name: str
    at: str
    values: Mapping[str, Choice]

    @property
    def column(self) -> str:
        """Beginning of the names of its columns."""
        return f"effect.{self.name}{f'@{self.at}' if self.at else ''}"


@dataclass(frozen=True)
class Case:
    """A state of the machine.

    Parameters
    ----------
    name : str
    effects : tuple of EffectRecipe
    parameters : mapping of str to Choice
        Of the machine, where the state is one of its parameters.
    instances : int
        How often it is drawn for each cell of the grids.
    """

    name: str
    effects: tuple[EffectRecipe, ...]
    parameters: Mapping[str, Choice]
    instances: int

    @cached_property
    def choices(self) -> tuple[tuple[str, Choice], ...]:
        """Everything that is chosen for the case, by column; grids multiply in this order."""
        own = [(f"machine.{name}", choice) for name, choice in self.parameters.items()]
        return (*own, *((f"{e.column}.{name}", choice) for e in self.effects for name, choice in e.values.items()))

    @cached_property
    def faults(self) -> int:
        """Number of different faults: cells of all grids, times the instances."""
        return self.instances * math.prod(choice.count for _, choice in self.choices)


@dataclass(frozen=True)
class MachineRecipe:
    """One kind of machine in a recipe.

    Parameters
    ----------
    name : str
    machine : Machine
        With the effects that it always has.
    probes : tuple of str
    rate_hz, duration_s : float
        Of a signal.
    speed_rpm : Choice
    load : Choice or None
        None for the machine's own load, or a machine without one.
    parameters : mapping of str to Choice
        Drawn once a machine draw.
    cases : tuple of Case
    records : int
        Signals that one run gives, one after the other: the machine settles once for all of them.
    """

    name: str
    machine: Machine
    probes: tuple[str, ...]
    rate_hz: float
    duration_s: float
    speed_rpm: Choice
    load: Choice | None
    parameters: Mapping[str, Choice]
    cases: tuple[Case, ...]
    records: int = 1

    @property
    def samples(self) -> int:
        """Samples of a channel."""
        return math.floor(self.duration_s * self.rate_hz + 1e-9)

    @cached_property
    def conditions(self) -> int:
        """Signals of one fault: speeds times loads times records."""
        return self.speed_rpm.count * (self.load.count if self.load else 1) * self.records

    @cached_property
    def per_draw(self) -> int:
        """Signals of one machine draw."""
        return self.conditions * sum(case.faults for case in self.cases)


@dataclass(frozen=True)
class Recipe:
    """What a dataset is made from.

    Parameters
    ----------
    name, meaning : str
    seed : int
    draws : int
        Machine draws of each kind.
    splits : mapping of str to float
        Name and share.
    chain : mapping of str to Choice
        Settings of the measuring chain, drawn for each signal; noise and range with their unit: ``noise.m/s2``.
    severity : mapping of str to tuple of str
        Name of a label and the columns from which it comes, of which a signal has one or none; none is 0.
    machines : tuple of MachineRecipe
    limits : tuple of str
        What the dataset does not show.
    source : str
        The recipe as JSON, with machine files inside: all that is needed to load it elsewhere.
    """

    name: str
    meaning: str
    seed: int
    draws: int
    splits: Mapping[str, float]
    chain: Mapping[str, Choice]
    severity: Mapping[str, tuple[str, ...]]
    machines: tuple[MachineRecipe, ...]
    limits: tuple[str, ...]
    source: str

    @cached_property
    def per_round(self) -> int:
        """Signals of one machine draw of every kind."""
        return sum(machine.per_draw for machine in self.machines)

    @property
    def signals(self) -> int:
        """Number of signals."""
        return self.draws * self.per_round

    @cached_property
    def fingerprint(self) -> str:
        """Sixteen letters that change with anything that changes the content, defaults and priors included."""
        resolved = [
            [one.machine.to_toml(), sorted(one.machine.values.items()), repr(one.speed_rpm), repr(one.load)]
            + [repr(choice) for choice in one.parameters.values()]
            + [repr(case.choices) for case in one.cases]
            for one in self.machines
        ]
        text = json.dumps([CONTENT, json.loads(self.source), resolved], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]
