"""What unknown forces would make of the lines: at one place or at all, by a law of speed or merely smooth in it.

A force a(speed) at a place makes the lines T(speed) a(speed), with the transfer T of the machine's mean matrices. Its
complex amplitude is normal, of any direction, or turns with the shaft, as what is fixed to it does; over the conditions
it is either a smooth function, or grows with a power of speed that holds roughly. What is linear in a normal amplitude
is normal: a covariance of the lines, no search.
A support that has changed is such a force too, as it acts by what the machine moves there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.machine import Machine
from .baseline import similarity
from .predict import Predictor, at_condition

#: Directions of forces, and of moments that tilt a shaft.
FORCES, MOMENTS = ("x", "y", "axial", "torsion"), ("angle_x", "angle_y")
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

    Forces at different places are independent, and so are those in different directions, or else x and y make one that
    turns. Moments come as turning ones beside turning forces, and alone. Parametric changes of the machine are left
    out: its mean is taken.
    """
    forces, moments = _Moved.by(machine, predictor, FORCES), _Moved.by(machine, predictor, MOMENTS)
    turning, tilting = forces.turning(("x", "y")), moments.turning(MOMENTS)
    laws = _laws(predictor)
    anywhere = [forces.lines, np.concatenate([turning.lines, tilting.as_large_as(turning).lines], axis=-1)]
    found = [ForceKernel("", _kernel(own, law)) for own in anywhere for law in laws if own.size]
    seen: list[np.ndarray] = []
    for place, own in [one for moved in (forces, turning, tilting, moments) for one in moved.each()]:
        smooth = _kernel(own, laws[0])
        largest = float(np.abs(smooth).max())
        if not largest or any(np.abs(smooth / largest - other).max() < SAME for other in seen):
            continue
        seen.append(smooth / largest)
        found += [ForceKernel(place, _kernel(own, law)) for law in laws]
    return tuple(found)


@dataclass(frozen=True, eq=False)
class _Moved:
    """The lines that unit forces make, (conditions, orders, probes, forces), and where each acts: place and way."""

    lines: np.ndarray
    acts: tuple[tuple[str, str], ...]

    @classmethod
    def by(cls, machine: Machine, predictor: Predictor, ways: Sequence[str]) -> _Moved:
        count = len(predictor.conditions)
        lines = np.stack([transfer(machine, predictor, i, ways) for i in range(count)])
        return cls(lines, tuple(force_places(machine, ways)))

    def turning(self, ways: Sequence[str]) -> _Moved:
        """Return those that turn with the shaft: across x they follow by a quarter of a turn."""
        both = [name for name in self._names if all((name, way) in self.acts for way in ways)]
        along, across = ([self.acts.index((name, way)) for name in both] for way in ways)
        return _Moved(self.lines[..., along] - 1j * self.lines[..., across], tuple((name, "turning") for name in both))

    def as_large_as(self, other: _Moved) -> _Moved:
        """Return those of another unit, in which they make lines as large as others do."""
        if not (self.lines.any() and other.lines.any()):
            return self
        scale = np.sqrt((np.abs(other.lines) ** 2).mean() / (np.abs(self.lines) ** 2).mean())
        return replace(self, lines=scale * self.lines)

    def each(self) -> list[tuple[str, np.ndarray]]:
        """Return the places, and the lines that forces there make."""
        places = np.array([name for name, _ in self.acts])
        return [(name, self.lines[..., places == name]) for name in self._names]

    @property
    def _names(self) -> list[str]:
        return list(dict.fromkeys(name for name, _ in self.acts))


def _laws(predictor: Predictor) -> list[np.ndarray]:
    """Return how alike forces of unit size are in two conditions: smooth first, then by each power of speed."""
    smooth = similarity(predictor.conditions)
    speed = np.array([condition.speed_rpm for condition in predictor.conditions])
    grown = [(speed / speed.mean()) ** power for power in POWERS]
    return [smooth, *(np.outer(one, one) * (1 - LOOSE + LOOSE * smooth) for one in grown)]


def _kernel(moved: np.ndarray, law: np.ndarray) -> np.ndarray:
    return np.einsum("ckpf,dkqf,cd->kcpdq", moved, moved.conj(), law, optimize=True)


def force_places(machine: Machine, ways: Sequence[str] = FORCES) -> list[tuple[str, str]]:
    """Return where a force can act: names of places and their directions."""
    places = machine.bare_assembly().places.values()
    return [(place.name, way) for place in places for way in ways if way in place.directions]


def transfer(machine: Machine, predictor: Predictor, index: int, ways: Sequence[str] = FORCES) -> np.ndarray:
    """Return the probes' lines per unit force in one condition, shape (orders, probes, forces) as `force_places`."""
    condition = predictor.conditions[index]
    loaded = at_condition(machine, condition)
    system = loaded.system(speed_rpm=condition.speed_rpm)
    places = loaded.bare_assembly().places
    directions = [places[name].directions[way] for name, way in force_places(loaded, ways)]
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
