"""What could be the cause: every effect of the catalogue at every part of the machine where it can act."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...simulators.assembly import Probe
from ...simulators.effect import Effect, SensorEffect, effect_catalogue
from ...simulators.errors import RotorwiseError
from ...simulators.machine import Machine
from .coordinates import Coordinate, coordinates_of, values_at
from .tuned import tuned
from .wanted_lines import parts_of

#: Links of the measuring chain that all channels share: one recorder, one clock.
SHARED_LINKS = ("recorder", "clock")
#: Links that each probe may have for itself, and of these the ones that all may share as well: earth.
SINGLE_LINKS, EARTHED_LINKS = ("mounting", "cable"), ("cable",)

#: Stages whose effects add something that depends on nothing else.
ADDING_UP = ("force", "sensor")

#: A strength that alone does less than this share of what another does alone is taken to modify that one only.
MODIFIES = 0.05


@dataclass(frozen=True)
class Candidate:
    """One effect at one part, with its unknowns in standard coordinates.

    Attributes
    ----------
    effect : Effect
        With default values; values without a prior stay as they are, and strengths that are absent are at zero.
    coordinates : tuple of Coordinate
        Of the parameters that are searched for.
    modifiers : frozenset of str
        Parameters that do nothing alone: they only change what others do.
    placed : frozenset of str
        Parameters whose value puts a line where the recordings show one.
    beside : tuple of Effect
        What the machine gets with it: weight that it was given without.
    """

    effect: Effect
    coordinates: tuple[Coordinate, ...]
    modifiers: frozenset[str] = frozenset()
    placed: frozenset[str] = frozenset()
    beside: tuple[Effect, ...] = ()

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.NAME

    @cached_property
    def strengths(self) -> tuple[int, ...]:
        """Numbers of the coordinates at which the effect can be absent."""
        return tuple(
            i
            for i, c in enumerate(self.coordinates)
            if c.parameter.zero is not None and c.parameter.name not in self.modifiers
        )

    @property
    def strength_names(self) -> frozenset[str]:
        """Names of the parameters at which the effect can be absent."""
        return frozenset(self.coordinates[i].parameter.name for i in self.strengths)

    @property
    def is_directed(self) -> bool:
        """Whether an angle is searched for: a change of stiffness has none."""
        return any(one.is_angle for one in self.coordinates)

    def with_only(self, strengths: frozenset[str]) -> Candidate:
        """Return the candidate with some of its strengths: the others are absent, and what goes with them."""
        effect, coordinates = _without(self.effect, self.coordinates, self.strength_names - strengths)
        return replace(self, effect=effect, coordinates=coordinates)

    def at(self, position: np.ndarray) -> Effect:
        """Return the effect at a position of its coordinates."""
        return self.effect.with_values(**values_at(self.coordinates, position))

    def on(self, machine: Machine, position: np.ndarray) -> Machine:
        """Return the machine with the effect at a position of its coordinates, and with what goes with it."""
        further = (one for one in self.beside if one not in machine.effects)
        return machine.with_effects(*further, self.at(position))

    def __str__(self) -> str:
        return f"{self.name} at {self.effect.at}" if self.effect.at else self.name


Reach = Callable[[Candidate], float]


def candidates(
    machine: Machine,
    *,
    without: frozenset[str] = frozenset(),
    probes: Sequence[str] | None = None,
    reach: Reach = lambda candidate: 1.0,
    found_lines: Sequence[tuple[float, float]] = (),
) -> tuple[Candidate, ...]:
    """Return every effect that can act on the machine, at every part, in order of name and part.

    Parameters
    ----------
    machine : Machine
    without : frozenset of str
        Names of effects to leave out.
    probes : sequence of str, optional
        The machine's probes that are compared, on whose chains effects can act; all when not given.
    reach : callable
        How far a candidate with a single strength moves the lines, in any unit; asked where an effect has several.
        Strengths that do next to nothing alone only modify the others.
    found_lines : sequence of tuple of float
        Order and added frequency of lines that the recordings show: effects that are free to choose where their line
        lies are tried there.
    """
    found = []
    for name, effect in sorted(effect_catalogue().items()):
        if name in without or effect.EMPIRICAL:
            continue
        for part in _parts(machine, effect, probes):
            one = effect(at=part)
            try:
                one.contribute(machine.bare_assembly())
            except RotorwiseError:
                continue
            found += _variants(one, reach)
            for other, fixed in tuned(one, machine, found_lines):
                found += [replace(one, placed=fixed) for one in _variants(other, reach, fixed)]
    return tuple(found)


def _variants(effect: Effect, reach: Reach, fixed: frozenset[str] = frozenset()) -> list[Candidate]:
    """Return the effect with all its strengths, and with each alone: a cause need not have all of them.

    Parameters in ``fixed`` keep their values.
    """
    coordinates = tuple(c for c in coordinates_of(effect.parameters()) if c.parameter.name not in fixed)
    strengths = [c.parameter for c in coordinates if c.parameter.zero is not None]
    if len(strengths) < 2:
        return [Candidate(effect, coordinates)]
    reached = {one.name: reach(_alone(effect, coordinates, one.name, frozenset())) for one in strengths}
    # Forces add up: none only modifies another, however little it does alone.
    least = 0.0 if effect.STAGE == "force" else MODIFIES * max(reached.values())
    acting = [name for name, own in reached.items() if own > least]
    modifiers = frozenset(one.name for one in strengths if one.name not in acting)
    if effect.STAGE in ADDING_UP and acting:
        # What changes no line that is compared changes none beside the others.
        idle = frozenset(name for name in modifiers if reached[name] == 0)
        effect, coordinates = _without(effect, coordinates, idle)
        modifiers -= idle
    # What shows nothing alone may show together: a mass on a spring, and that a sensor sees it move.
    together = Candidate(effect, coordinates, modifiers if acting else frozenset())
    whole = [together] if acting or reach(together) > 0 else []
    apart = [one.name for one in strengths if one.name in acting and not one.accompanies] if len(acting) > 1 else []
    return whole + [_alone(effect, coordinates, name, modifiers) for name in apart]


def _alone(effect: Effect, coordinates: tuple[Coordinate, ...], kept: str, modifiers: frozenset[str]) -> Candidate:
    """Return the effect with one strength: the others are absent, but for those that only modify it."""
    strengths = {c.parameter.name for c in coordinates if c.parameter.zero is not None}
    return Candidate(*_without(effect, coordinates, frozenset(strengths - modifiers - {kept})), modifiers)


def _without(
    effect: Effect, coordinates: tuple[Coordinate, ...], names: frozenset[str]
) -> tuple[Effect, tuple[Coordinate, ...]]:
    """Return the effect and its coordinates, some strengths being absent and what goes with them."""
    absent = {c.parameter.name: c.parameter.zero or 0.0 for c in coordinates if c.parameter.name in names}
    left = tuple(c for c in coordinates if not {c.parameter.name, c.parameter.only_with} & absent.keys())
    return effect.with_values(**absent), left


def _parts(machine: Machine, effect: type[Effect], probes: Sequence[str] | None) -> list[str]:
    if issubclass(effect, SensorEffect):
        every = machine.bare_assembly().probes
        compared = [probe for probe in every if probes is None or probe.name in probes]
        return _parts_of_chain(effect, [probe for probe in compared if effect().fits(probe)])
    return parts_of(machine, effect)


def _parts_of_chain(effect: type[SensorEffect], fitting: Sequence[Probe]) -> list[str]:
    """Return the names of probes and locations that one flaw of the measuring chain may have; "" for all probes."""
    places = [probe.location for probe in fitting]
    found = list(dict.fromkeys(places))
    if effect.LINK in SHARED_LINKS:
        return [""] if found else []
    if effect.LINK in SINGLE_LINKS:
        found += [probe.name for probe in fitting if places.count(probe.location) > 1]
    if effect.LINK in EARTHED_LINKS and len(set(places)) > 1:
        found.insert(0, "")
    return found
