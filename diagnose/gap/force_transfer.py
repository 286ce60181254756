"""What forces somewhere on a machine, or between the two halves of a coupling, make of its lines in each condition."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence

import numpy as np

from ...simulators.assembly import difference
from ...simulators.errors import RotorwiseError
from ...simulators.law import Direction
from ...simulators.machine import Machine
from ...simulators.rotor_dynamics.flexible_coupling import DIRECTIONS, FlexibleCoupling
from ...simulators.solvers.small_forces import small_force_responses
from .periodic import at_condition
from .predict import FURTHER_HARMONICS, Predictor

#: Directions of forces.
FORCES = ("x", "y", "axial", "torsion")
#: Period of what is balanced, in turns of the shaft: half orders have a phase too.
TURNS = 2
#: Highest order that is balanced: the effort grows with its cube.
HIGHEST = 12.0


def force_places(machine: Machine, ways: Sequence[str] = FORCES) -> list[tuple[str, str]]:
    """Return where a force can act: names of places and their directions."""
    places = machine.bare_assembly().places.values()
    return [(place.name, way) for place in places for way in ways if way in place.directions]


def places_across(machine: Machine) -> list[tuple[str, str]]:
    """Return the same for equal and opposite forces on the two halves of flexible couplings."""
    return [(name, way) for name, ways in _across(machine).items() for way in ways]


def _across(machine: Machine) -> dict[str, dict[str, Direction]]:
    found = {}
    for name, part in machine.bare_assembly().components.items():
        if isinstance(part, FlexibleCoupling):
            ways = [way for way in DIRECTIONS if way in {*part.driven, *part.driving}]
            found[name] = {way: difference(part.driven.get(way, {}), part.driving.get(way, {})) for way in ways}
    return found


def numbers_with_phase(predictor: Predictor) -> tuple[int, ...]:
    """Return the numbers of the lines that have a phase."""
    return tuple(number for number, kind in enumerate(predictor.kinds) if kind.phase)


def force_transfer(machine: Machine, predictor: Predictor, ways: Sequence[str] = FORCES) -> np.ndarray:
    """Return the probes' lines of unit forces, shape (2, conditions, orders, orders, probes, forces).

    Of the lines that have a phase (`numbers_with_phase`), at the first order of a force at the second; forces as
    `force_places`. First of complex amplitude 1, then of i: where a stiffness changes with the angle, one does not
    follow from the other, and a force at one order makes lines at others. At half orders up to `HIGHEST` as small
    forces beside the machine's own motion; at other orders, and where that motion does not repeat with the shaft, by
    the machine's mean matrices.
    """

    def where(loaded: Machine) -> list[Direction]:
        places = loaded.bare_assembly().places
        return [places[name].directions[way] for name, way in force_places(loaded, ways)]

    return _transfer(machine, predictor, where)


def transfer_across(machine: Machine, predictor: Predictor) -> np.ndarray:
    """Return the same of unit forces, and moments, as `places_across`."""

    def where(loaded: Machine) -> list[Direction]:
        return [direction for ways in _across(loaded).values() for direction in ways.values()]

    return _transfer(machine, predictor, where)


def _transfer(machine: Machine, predictor: Predictor, where: Callable[[Machine], list[Direction]]) -> np.ndarray:
    orders, found = np.array(predictor.orders)[list(numbers_with_phase(predictor))], []
    is_half = np.abs(TURNS * orders - np.round(TURNS * orders)) < 1e-9
    halves = np.flatnonzero(is_half & (orders > 0) & (orders <= HIGHEST))
    for index in range(len(predictor.conditions)):
        mean = _by_mean_matrices(machine, predictor, index, where, orders)
        own = np.zeros((2, orders.size, *mean.shape), dtype=complex)
        each = np.arange(orders.size)
        own[:, each, each] = np.stack([mean, 1j * mean])
        if halves.size and mean.size:
            with contextlib.suppress(RotorwiseError):
                own[np.ix_(np.arange(2), halves, halves)] = _beside_motion(
                    machine, predictor, index, where, orders[halves]
                )
        found.append(own)
    return np.stack(found, axis=1)


def _beside_motion(
    machine: Machine,
    predictor: Predictor,
    index: int,
    where: Callable[[Machine], list[Direction]],
    orders: np.ndarray,
) -> np.ndarray:
    """Return the same in one condition, (2, orders, orders, ...), as small forces beside the machine's motion."""
    condition = predictor.conditions[index]
    loaded = at_condition(machine, condition)
    parts = loaded.bare_assembly()
    found = small_force_responses(
        loaded,
        where(loaded),
        speeds_rpm=[condition.speed_rpm],
        harmonics=math.ceil(orders.max()) + FURTHER_HARMONICS,
        revolutions=TURNS,
    )
    names = [probe.name for probe in parts.probes]
    rows = [names.index(name) for name in predictor.probes]
    at = np.round(TURNS * orders).astype(int)
    return found[:, 0][:, at][:, :, at][:, :, :, rows]


def _by_mean_matrices(
    machine: Machine,
    predictor: Predictor,
    index: int,
    where: Callable[[Machine], list[Direction]],
    orders: np.ndarray,
) -> np.ndarray:
    """Return the probes' lines per unit force in one condition, shape (orders, probes, forces)."""
    condition = predictor.conditions[index]
    loaded = at_condition(machine, condition)
    system = loaded.system(speed_rpm=condition.speed_rpm)
    directions = where(loaded)
    columns = np.zeros((system.states, len(directions)))
    count = len(system.coordinates)
    inverse = np.linalg.inv(system.mass_matrix)
    for number, direction in enumerate(directions):
        columns[count : 2 * count, number] = inverse @ system.row(direction)[:count]
    names = [probe.name for probe in system.probes]
    rows = [names.index(name) for name in predictor.probes]
    direct = np.array(
        [
            system.row(probe.row)[:count] @ columns[count : 2 * count] * (probe.quantity == "acceleration")
            for probe in system.probes
        ]
    )
    speed = 2 * math.pi * condition.speed_rpm / 60
    unit = np.eye(system.states)
    found = [
        system.probe_rows[rows] @ np.linalg.solve(1j * order * speed * unit - system.core, columns) + direct[rows]
        for order in orders
    ]
    return np.array(found, dtype=complex).reshape(len(orders), len(rows), len(directions))
