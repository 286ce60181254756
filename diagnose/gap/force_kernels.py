"""What unknown forces would make of the lines: at one place or at all, by a law of speed or merely smooth in it.

A force a(speed) at a place makes the lines T(speed) a(speed), with the transfer T of the machine's mean matrices. Its
complex amplitude is normal, of any direction; over the conditions it is either a smooth function, or grows with a power
of speed that holds roughly. What is linear in a normal amplitude is normal: a covariance of the lines, no search.
A support that has changed is such a force too, as it acts by what the machine moves there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...simulators.machine import Machine
from .baseline import similarity
from .predict import Predictor, at_condition

#: Powers of speed: a constant force (a bow), a viscous one, one of inertia (an unbalance).
POWERS = (0.0, 1.0, 2.0)
#: Share of the variance in which such a force may leave its law, smoothly.
LOOSE = 0.05
#: Places whose kernels differ by less are one place to the probes.
SAME = 1e-6


@dataclass(frozen=True, eq=False)
class ForceKernel:
    """Covariance of the lines that one kind of unknown force makes.

    Attributes
    ----------
    at : str
        The place, or "" for independent forces at all places.
    lines : ndarray (orders, conditions, probes, conditions, probes), complex
        Of forces of unit variance.
    """

    at: str
    lines: np.ndarray


def force_kernels(machine: Machine, predictor: Predictor) -> tuple[ForceKernel, ...]:
    """Return the kernels of forces at all places, then of those at each place that the probes can tell from others.

    Forces at different places and in different directions are independent. Parametric changes of the machine are left
    out: its mean is taken.
    """
    moved = np.stack([transfer(machine, predictor, i) for i in range(len(predictor.conditions))])
    places = np.array([name for name, _ in force_places(machine)])
    laws = _laws(predictor)
    found = [ForceKernel("", _kernel(moved, law)) for law in laws]
    seen: list[np.ndarray] = []
    for place in dict.fromkeys(places.tolist()):
        own = moved[..., places == place]
        smooth = _kernel(own, laws[0])
        largest = float(np.abs(smooth).max())
        if not largest or any(np.abs(smooth / largest - other).max() < SAME for other in seen):
            continue
        seen.append(smooth / largest)
        found += [ForceKernel(place, _kernel(own, law)) for law in laws]
    return tuple(found)


def _laws(predictor: Predictor) -> list[np.ndarray]:
    """Return how alike forces of unit size are in two conditions: smooth first, then by each power of speed."""
    smooth = similarity(predictor.conditions)
    speed = np.array([condition.speed_rpm for condition in predictor.conditions])
    grown = [(speed / speed.mean()) ** power for power in POWERS]
    return [smooth, *(np.outer(one, one) * (1 - LOOSE + LOOSE * smooth) for one in grown)]


def _kernel(moved: np.ndarray, law: np.ndarray) -> np.ndarray:
    return np.einsum("ckpf,dkqf,cd->kcpdq", moved, moved.conj(), law, optimize=True)


def force_places(machine: Machine) -> list[tuple[str, str]]:
    """Return where a force can act: names of places and their directions."""
    places = machine.bare_assembly().places.values()
    return [(place.name, way) for place in places for way in ("x", "y", "axial", "torsion") if way in place.directions]


def transfer(machine: Machine, predictor: Predictor, index: int) -> np.ndarray:
    """Return the probes' lines per unit force in one condition, shape (orders, probes, forces) as `force_places`."""
    condition = predictor.conditions[index]
    loaded = at_condition(machine, condition)
    system = loaded.system(speed_rpm=condition.speed_rpm)
    places = loaded.bare_assembly().places
    directions = [places[name].directions[way] for name, way in force_places(loaded)]
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
        for order in predictor.orders
    ]
    return np.stack(found)


def prior_shares(kernels: Sequence[ForceKernel]) -> list[float]:
    """Return the prior probability of each kernel.

    Lines that are merely smooth, which no kernel makes, forces at all places and forces at one are alike
    probable.
    """
    anywhere = sum(not one.at for one in kernels)
    placed = len(kernels) - anywhere
    return [1 / (3 * (placed if one.at else anywhere)) for one in kernels]
