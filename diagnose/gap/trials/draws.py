"""Random machines and random effects, drawn from what their declarations say and from nothing else.

Every parameter of a machine that has a prior is off by up to 10 % (evenly; an angle by up to 0.1 rad; what is normally
about 0, as supports or bolts that are unlike, by up to one standard deviation of its prior). A dimension
without prior (a length, mass, inertia or unbalance) is off by up to 1 %. Loads, counts, pure numbers and settings of
controllers without prior are as declared.

A strength of an effect lies log-evenly within a factor 10^0.75 of the median of its prior, as far as bounds and prior
allow (its range, or three standard deviations); all other parameters come from their priors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ....simulators.assembly import Probe
from ....simulators.effect import Effect, SensorEffect, effect_catalogue
from ....simulators.errors import RotorwiseError
from ....simulators.machine import Machine
from ....simulators.parameter import LogNormal, Normal, Parameter, Prior
from ..wanted_lines import parts_of

WITH_PRIOR, OF_DIMENSIONS, DRIFT = 0.10, 0.01, 0.005
_DIMENSIONS = ("m", "kg", "kg.m2", "kg.m")
#: Half of the width of a strength's distribution, in decades.
HALF_WIDTH = 0.75


def applicable(machine: Machine, *, probes: Sequence[Probe]) -> dict[str, tuple[Effect, ...]]:
    """Return the effects that can begin to act on a machine by name, each at every part, with default values.

    Effects on the measuring chain act at the locations of ``probes``, those that are recorded; those of the recorder
    and its clock act on all channels.
    """
    found: dict[str, tuple[Effect, ...]] = {}
    for name, effect in sorted(effect_catalogue().items()):
        if effect.EMPIRICAL or effect.PERMANENT:
            continue
        if issubclass(effect, SensorEffect):
            fitting = [probe.location for probe in probes if effect().fits(probe)]
            if not fitting:
                continue
            # One recorder with one clock takes all channels and the tacho.
            where = [""] if effect.LINK in ("clock", "recorder") else fitting
        else:
            where = parts_of(machine, effect)
        able = tuple(effect(at=at) for at in dict.fromkeys(where) if _fits(effect(at=at), machine))
        if able:
            found[name] = able
    return found


def _fits(effect: Effect, machine: Machine) -> bool:
    try:
        effect.contribute(machine.bare_assembly())
    except RotorwiseError:
        return False
    return True


def drawn(
    catalogue: dict[str, tuple[Effect, ...]], generator: np.random.Generator, *, besides: frozenset[str] = frozenset()
) -> Effect:
    """Return a random effect at a random part: every name equally likely, then every part."""
    names = [name for name in catalogue if name not in besides]
    parts = catalogue[names[generator.integers(len(names))]]
    effect = parts[generator.integers(len(parts))]
    values = {p.name: _value(p, generator) for p in effect.parameters() if p.prior is not None}
    return effect.with_values(**values)


def _value(parameter: Parameter, generator: np.random.Generator) -> float:
    assert parameter.prior is not None
    sample = min(max(parameter.prior.sample(generator), parameter.bounds[0]), parameter.bounds[1])
    if parameter.zero is None:
        return sample
    side = 1.0 if sample >= parameter.zero else -1.0
    low, high = likely(parameter)
    ends = sorted((side * (low - parameter.zero), side * (high - parameter.zero)))
    middle = abs(parameter.prior.median - parameter.zero)
    weakest, strongest = max(ends[0], middle * 10**-HALF_WIDTH), min(ends[1], middle * 10**HALF_WIDTH)
    share = generator.uniform()
    if not 0 < weakest < strongest:
        return sample
    return parameter.zero + side * weakest * (strongest / weakest) ** share


def likely(parameter: Parameter) -> tuple[float, float]:
    """Return the values that bounds and prior allow: the prior's range, or three standard deviations."""
    low, high = _reach(parameter.prior) if parameter.prior is not None else parameter.bounds
    return max(low, parameter.bounds[0]), min(high, parameter.bounds[1])


def _reach(prior: Prior) -> tuple[float, float]:
    if isinstance(prior, Normal):
        return prior.mean - 3 * prior.deviation, prior.mean + 3 * prior.deviation
    if isinstance(prior, LogNormal):
        return prior.median / prior.factor**3, prior.median * prior.factor**3
    return prior.low, prior.high


def weakened(effect: Effect, share: float) -> Effect:
    """Return the effect with a share of every strength, within bounds."""
    values = {}
    for p in effect.parameters():
        if p.zero is not None:
            value = p.zero + share * (effect.values()[p.name] - p.zero)
            values[p.name] = min(max(value, p.bounds[0]), p.bounds[1])
    return effect.with_values(**values)


def perturbed(machine: Machine, generator: np.random.Generator) -> Machine:
    """Return the machine as it might really be; see the module's docstring."""
    changed = {}
    for p in machine.definition.parameters:
        off = WITH_PRIOR if p.prior is not None else OF_DIMENSIONS if p.unit in _DIMENSIONS else 0.0
        if off and p.name != machine.definition.load_parameter:
            changed[p.name] = _moved(p, machine.values[p.name], off, generator)
    return machine.with_parameters(**changed)


def turned_anyhow(machine: Machine, names: Sequence[str], generator: np.random.Generator) -> Machine:
    """Return the machine with these angles anywhere."""
    return machine.with_parameters(**{name: float(generator.uniform(-math.pi, math.pi)) for name in names})


def drifted(machine: Machine, generator: np.random.Generator) -> Machine:
    """Return a machine whose changed parameters have drifted by up to 0.5 % (angles by 0.005 rad)."""
    declared = {p.name: p for p in machine.definition.parameters}
    changed = {name: _moved(declared[name], value, DRIFT, generator) for name, value in machine.changed.items()}
    return machine.with_parameters(**changed)


def _moved(parameter: Parameter, value: float, most: float, generator: np.random.Generator) -> float:
    by = generator.uniform(-most, most)
    if value == 0.0 and isinstance(parameter.prior, Normal) and parameter.unit != "rad":
        return parameter.prior.deviation * by / most
    moved = value + by if parameter.unit == "rad" else value * (1 + by)
    assert math.isfinite(moved)
    return min(max(moved, parameter.bounds[0]), parameter.bounds[1])
