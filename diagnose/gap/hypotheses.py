"""What could be the cause: every effect of the catalogue at every part of the machine where it can act."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...simulators.effect import Effect, SensorEffect, effect_catalogue
from ...simulators.errors import RotorwiseError
from ...simulators.machine import Machine
from .coordinates import Coordinate, coordinates_of, values_at


@dataclass(frozen=True)
class Candidate:
    """One effect at one part, with its unknowns in standard coordinates.

    Attributes
    ----------
    effect : Effect
        With default values; values without a prior stay as they are, and strengths that are absent are at zero.
    coordinates : tuple of Coordinate
        Of the parameters that are searched for.
    """

    effect: Effect
    coordinates: tuple[Coordinate, ...]

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.NAME

    @property
    def strengths(self) -> tuple[int, ...]:
        """Numbers of the coordinates at which the effect can be absent."""
        return tuple(i for i, c in enumerate(self.coordinates) if c.parameter.zero is not None)

    def at(self, position: np.ndarray) -> Effect:
        """Return the effect at a position of its coordinates."""
        return self.effect.with_values(**values_at(self.coordinates, position))

    def __str__(self) -> str:
        return f"{self.name} at {self.effect.at}" if self.effect.at else self.name


def candidates(machine: Machine, *, without: frozenset[str] = frozenset()) -> tuple[Candidate, ...]:
    """Return every effect that can act on the machine, at every part, in order of name and part.

    Parameters
    ----------
    machine : Machine
    without : frozenset of str
        Names of effects to leave out.
    """
    found = []
    for name, effect in sorted(effect_catalogue().items()):
        if name in without:
            continue
        for part in _parts(machine, effect):
            one = effect(at=part)
            try:
                one.contribute(machine.bare_assembly())
            except RotorwiseError:
                continue
            found += _variants(one)
    return tuple(found)


def _variants(effect: Effect) -> list[Candidate]:
    """Return the effect with all its strengths, and with each alone: a cause need not have all of them."""
    coordinates = coordinates_of(effect.parameters())
    strengths = [c.parameter for c in coordinates if c.parameter.zero is not None]
    whole = [Candidate(effect, coordinates)]
    if len(strengths) < 2:
        return whole
    for kept in strengths:
        absent = {one.name: one.zero for one in strengths if one is not kept and one.zero is not None}
        alone = tuple(c for c in coordinates if c.parameter.name not in absent)
        whole.append(Candidate(effect.with_values(**absent), alone))
    return whole


def _parts(machine: Machine, effect: type[Effect]) -> list[str]:
    assembly = machine.bare_assembly()
    if issubclass(effect, SensorEffect):
        return list(dict.fromkeys(probe.location for probe in assembly.probes))
    parts = [*assembly.places.values(), *assembly.components.values()]
    return list(dict.fromkeys(part.name for part in parts if effect.ROLE in part.roles)) or [""]
