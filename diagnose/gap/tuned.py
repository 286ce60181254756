"""Effects that are free to choose where their line lies, put where the recordings show one.

A search by slopes finds such a place only from close by: a line that lies beside the measured one explains nothing.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from ...simulators.effect import Effect
from ...simulators.errors import RotorwiseError
from ...simulators.machine import Machine
from ...simulators.parameter import Parameter
from .coordinates import Coordinate
from .line_sizes import SLIP
from .wanted_lines import STRUCK

#: Supplies of the world, and by how much a line may be off its multiples.
SUPPLIES_HZ, SUPPLY_WANDER = (50.0, 60.0), 0.005
#: Places of a prior that are looked at, in standard coordinates, and halvings of the interval between two of them.
PLACES, HALVINGS = np.linspace(-4.0, 4.0, 81), 40
#: A place this close is met.
EXACT = 1e-9
#: Values closer than this share are one: so well is the place of a line known.
SAME = 0.01

Tuned = tuple[Effect, frozenset[str]]


def tuned(effect: Effect, machine: Machine, found: Sequence[tuple[float, float]]) -> list[Tuned]:
    """Return the effect with a line at each place where it can have one, and the parameter that is then given.

    Parameters
    ----------
    effect : Effect
    machine : Machine
    found : sequence of tuple of float
        Lines that the recordings show and the model lacks: order, and frequency in Hz added to it.
    """
    frequencies = [added for order, added in found if order == 0]
    orders = [order for order, added in found if order > 0 and not added]
    return _at_frequencies(effect, machine, frequencies) + _at_orders(effect, machine, orders)


def in_band(effect: Effect, machine: Machine, name: str) -> tuple[float, float] | None:
    """Return between which values of a parameter the lines of a struck part stay in the band where their size is read.

    Sizes do not tell where in its band a line lies: values between these are alike. None for other parameters.
    """
    declared = next(one for one in effect.parameters() if one.name == name)
    if effect.ROLE not in STRUCK or declared.unit or declared.prior is None:
        return None
    coordinate = Coordinate(declared)
    values = [coordinate.value(z) for z in PLACES]

    # How many harmonics there are depends on the size; all move by the same share.
    places = [effect.with_values(**{name: value}).signature(machine)[0].order for value in values]
    if max(places) - min(places) < EXACT:
        return None
    nominal = type(effect)(at=effect.at).signature(machine)[0].order
    near = [v for v, place in zip(values, places, strict=True) if abs(place / nominal - 1) <= SLIP]
    return (min(near), max(near)) if near else None


def _at_frequencies(effect: Effect, machine: Machine, frequencies_hz: Sequence[float]) -> list[Tuned]:
    """A frequency with a prior may be any; one without is that of the supply, 50 or 60 Hz."""
    result = []
    for declared in effect.parameters():
        if declared.unit != "Hz":
            continue
        for value in SUPPLIES_HZ if declared.prior is None else frequencies_hz:
            if value == effect.values()[declared.name] or not declared.bounds[0] <= value <= declared.bounds[1]:
                continue
            one = effect.with_values(**{declared.name: value})
            places = [abs(line.frequency_hz) for line in one.signature(machine) if line.order == 0]
            if any(abs(place - own) <= SUPPLY_WANDER * own for place in places for own in frequencies_hz):
                result.append((one, frozenset((declared.name,))))
    return result


def _at_orders(effect: Effect, machine: Machine, orders: Sequence[float]) -> list[Tuned]:
    """A parameter without a unit and with a prior that moves a line beside the shaft's orders: a slip, a share."""
    if effect.ROLE in STRUCK or not orders:
        return []
    result = []
    for declared in effect.parameters():
        if declared.unit or declared.prior is None or declared.zero is not None:
            continue
        distinct: list[float] = []
        for value in _values_for(effect, declared, machine, orders):
            if all(abs(value - other) > SAME * abs(other) for other in distinct):
                distinct.append(value)
        result += [(effect.with_values(**{declared.name: value}), frozenset((declared.name,))) for value in distinct]
    return result


def _whole(value: float) -> float:
    """Return a whole number that bisection has come close to: the motion then repeats with the shaft."""
    return float(round(value)) if abs(value - round(value)) < 1e-9 else value


def _values_for(effect: Effect, declared: Parameter, machine: Machine, orders: Sequence[float]) -> list[float]:
    """Return the values of a parameter at which one of the effect's lines lies at one of the orders."""
    coordinate = Coordinate(declared)

    def places(z: float) -> np.ndarray:
        value = coordinate.value(z)
        lines = effect.with_values(**{declared.name: value}).signature(machine)
        return np.array([abs(line.order) for line in lines if not line.frequency_hz])

    try:
        rows = [places(z) for z in PLACES]
    except RotorwiseError:
        return []
    most = max(row.size for row in rows)
    # A line may be missing at some of the values: a difference of two orders that is 0.
    lying = np.array([np.pad(row, (0, most - row.size), constant_values=np.nan) for row in rows])
    # Lines that stay where they are, whatever the value, are not put anywhere by it.
    moving = np.flatnonzero(np.nanmax(lying, axis=0) - np.nanmin(lying, axis=0) > EXACT)
    values = []
    for order, line in itertools.product(orders, moving):
        away = lying[:, line] - order
        values += [_whole(coordinate.value(PLACES[k])) for k in np.flatnonzero(np.abs(away) < EXACT)]
        for k in np.flatnonzero(away[:-1] * away[1:] < -(EXACT**2)):
            low, high, sign = PLACES[k], PLACES[k + 1], np.sign(away[k])
            for _ in range(HALVINGS):
                middle = (low + high) / 2
                low, high = (middle, high) if np.sign(places(middle)[line] - order) == sign else (low, middle)
            values.append(_whole(coordinate.value((low + high) / 2)))
        # Just beyond what the prior allows: a line is seldom exactly where it is stated.
        near = SAME * abs(order - round(order)) if away[0] * away[-1] > 0 else 0.0
        values += [coordinate.value(PLACES[k]) for k in (0, -1) if abs(away[k]) < near]
    return values
