"""What unknown forces would make of the lines: at one place or at all, by a law of speed or merely smooth in it.

A force a(speed) at a place makes the lines T(speed) a(speed), as small forces do beside the machine's own motion, with
what a stiffness that changes with the angle makes of the conjugate (`force_transfer`). Its complex amplitude is normal,
of any direction; forces at all places may also turn with the shaft, as what is fixed to it does. Over the conditions it
is either a smooth function, or grows with a power of speed that holds roughly. What is linear in a normal amplitude is
normal: a covariance of the lines, no search.
A support that has changed is such a force too, as it acts by what the machine moves there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.machine import Machine
from .force_transfer import (
    FORCES,
    force_places,
    force_transfer,
    numbers_with_phase,
    places_across,
    transfer_across,
)
from .model_error import similarity
from .predict import Predictor

#: Directions of moments that tilt a shaft.
MOMENTS = ("angle_x", "angle_y")
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
    moved : ndarray (2, conditions, orders, orders, probes, forces), complex
        Lines with phase at the first order, of unit forces of complex amplitude 1, and i, at the second.
    numbers : tuple of int
        Of these lines.
    law : ndarray (conditions, conditions)
        How alike forces are in two conditions.
    """

    at: str
    moved: np.ndarray
    numbers: tuple[int, ...]
    law: np.ndarray

    def lines(self, order: int) -> np.ndarray:
        """Return the covariance of one order's lines, real parts then imaginary parts of unit variance of force.

        Shape (2, conditions, probes, 2, conditions, probes).
        """
        at = self.numbers.index(order)
        return self._covariance(self.moved[:, :, [at], at])[:, :, 0, :, :, :, 0]

    def spread(self, order: int) -> np.ndarray:
        """Return the covariance of the lines that forces at one order make at every one that has a phase.

        Shape (2, conditions, orders, probes, 2, conditions, orders, probes).
        """
        return self._covariance(self.moved[:, :, :, self.numbers.index(order)])

    def _covariance(self, moved: np.ndarray) -> np.ndarray:
        parts = np.stack([np.real(moved), np.imag(moved)])
        return np.einsum("xacopf,yadrqf,cd->xcopydrq", parts, parts, self.law, optimize=True)


def force_kernels(machine: Machine, predictor: Predictor) -> tuple[ForceKernel, ...]:
    """Return the kernels of forces at all places, then of those at each place that the probes can tell from others.

    One place is the two halves of a flexible coupling, which push each other in every way.

    Forces at different places are independent, and so are those in different directions. All forces and moments come
    once more as ones that turn. Not so those at one place: that is what known effects are (an unbalance, a misaligned
    coupling), and what one of them does is not unknown.
    """
    phases = numbers_with_phase(predictor)
    if not phases:
        return ()
    forces, moments = _Moved.by(machine, predictor, FORCES), _Moved.by(machine, predictor, MOMENTS)
    turning, tilting = forces.turning(("x", "y")), moments.turning(MOMENTS)
    laws = _laws(predictor)
    anywhere = [forces.lines, np.concatenate([turning.lines, tilting.as_large_as(turning).lines], axis=-1)]
    found = [ForceKernel("", own, phases, law) for own in anywhere for law in laws if own.size]
    seen: list[np.ndarray] = []
    across = _across(machine, predictor)
    for place, own in [one for moved in (forces, moments, across) for one in moved.each()]:
        kernels = [ForceKernel(place, own, phases, law) for law in laws]
        smooth = np.stack([kernels[0].lines(order) for order in phases])
        largest = float(np.abs(smooth).max())
        if not largest or any(np.abs(smooth / largest - other).max() < SAME for other in seen):
            continue
        seen.append(smooth / largest)
        found += kernels
    return tuple(found)


def turning_kernels(machine: Machine, predictor: Predictor) -> tuple[ForceKernel, ...]:
    """Return the kernels of forces that turn with the shaft, at each place and between the halves of couplings."""
    forces, across = _Moved.by(machine, predictor, FORCES), _across(machine, predictor)
    turning = [one for moved in (forces, across) for one in moved.turning(("x", "y")).each()]
    phases = numbers_with_phase(predictor)
    return tuple(ForceKernel(place, own, phases, law) for place, own in turning for law in _laws(predictor))


def _across(machine: Machine, predictor: Predictor) -> _Moved:
    return _Moved(transfer_across(machine, predictor), tuple(places_across(machine))).in_one_unit(MOMENTS)


@dataclass(frozen=True, eq=False)
class _Moved:
    """The lines that unit forces make, as `ForceKernel.moved`, and where each acts: place and way."""

    lines: np.ndarray
    acts: tuple[tuple[str, str], ...]

    @classmethod
    def by(cls, machine: Machine, predictor: Predictor, ways: Sequence[str]) -> _Moved:
        return cls(force_transfer(machine, predictor, ways), tuple(force_places(machine, ways)))

    def turning(self, ways: Sequence[str]) -> _Moved:
        """Return those that turn with the shaft: across x they follow by a quarter of a turn."""
        both = [name for name in self._names if all((name, way) in self.acts for way in ways)]
        along, across = (self.lines[..., [self.acts.index((name, way)) for name in both]] for way in ways)
        # Amplitude a along goes with -i a across.
        lines = np.stack([along[0] - across[1], along[1] + across[0]])
        return _Moved(lines, tuple((name, "turning") for name in both))

    def as_large_as(self, other: _Moved) -> _Moved:
        """Return those of another unit, in which they make lines as large as others do."""
        if not (self.lines.any() and other.lines.any()):
            return self
        scale = np.sqrt((np.abs(other.lines) ** 2).mean() / (np.abs(self.lines) ** 2).mean())
        return replace(self, lines=scale * self.lines)

    def in_one_unit(self, ways: Sequence[str]) -> _Moved:
        """Return them with some ways, of another unit, made as large as the others at each place."""
        lines, own = self.lines.copy(), np.array([way in ways for _, way in self.acts], dtype=bool)
        for name in self._names:
            here = np.array([place == name for place, _ in self.acts], dtype=bool)
            if (here & own).any() and (here & ~own).any():
                some, others = ((np.abs(lines[..., here & which]) ** 2).mean() for which in (own, ~own))
                lines[..., here & own] *= np.sqrt(others / some) if some > 0 and others > 0 else 1.0
        return replace(self, lines=lines)

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


def prior_shares(kernels: Sequence[ForceKernel]) -> list[float]:
    """Return the prior probability of each kernel.

    Lines that are merely smooth, which no kernel makes, forces at all places and forces at one are alike
    probable.
    """
    anywhere = sum(not one.at for one in kernels)
    placed = len(kernels) - anywhere
    return [1 / (3 * (placed if one.at else anywhere)) for one in kernels]
