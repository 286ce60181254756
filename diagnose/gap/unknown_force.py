"""The hypothesis that something acts which no effect of the catalogue explains: smooth forces, or simply smooth lines.

Order by order the unexplained part is a random function of speed: either forces at all places of the machine, each
varying smoothly, or an error of each probe's line, varying smoothly. Which of the two and how strong is what the data
say most probably (empirical Bayes); the choice costs the logarithm of the number of choices.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...simulators.machine import Machine
from .baseline import similarity
from .evidence import Comparison
from .lines import unstacked
from .predict import Predictor, at_condition

#: Sizes tried, as shares of the largest line left in the order.
SIZES = np.geomspace(1e-3, 10.0, 17)
#: An order needs this much more evidence than the choices cost, to count as unexplained.
LEAST_GAIN = 3.0
#: Relative size, in the covariance, of what keeps it positive.
JITTER = 1e-9


@dataclass(frozen=True, eq=False)
class Unknown:
    """Lines that nothing in the catalogue explains.

    Attributes
    ----------
    log_evidence : float
    lines : ndarray (conditions, probes, orders), complex
        Their most probable values; 0 in orders that need nothing.
    gains : ndarray (orders,)
        Evidence that each order adds.
    as_force : tuple of bool
        For each order, whether forces explain it better than errors of the probes' lines.
    kernels : mapping of int to ndarray (reals, reals)
        By the number of each order that needs it: the covariance that it adds to the lines.
    prices : mapping of int to float
        Evidence that the choice of each of these cost.
    """

    log_evidence: float
    lines: np.ndarray
    gains: np.ndarray
    as_force: tuple[bool, ...]
    kernels: Mapping[int, np.ndarray]
    prices: Mapping[int, float]

    def without(self, order: int) -> tuple[np.ndarray, float]:
        """Return the covariance of all orders but one, and what choosing them cost."""
        kept = [number for number in self.kernels if number != order]
        some = next(iter(self.kernels.values()))
        added = sum((self.kernels[number] for number in kept), np.zeros_like(some))
        return added, sum(self.prices[number] for number in kept)


def unexplained(compared: Comparison, kernels: np.ndarray | None) -> Unknown:
    """Return the most probable unexplained lines.

    Parameters
    ----------
    compared : Comparison
    kernels : ndarray (orders, conditions, probes, conditions, probes), complex, optional
        Covariance of the lines that forces make, from `force_kernels`.
    """
    residual = compared.factor @ compared.residual
    free = _line_kernel(compared)
    chosen: dict[int, np.ndarray] = {}
    prices: dict[int, float] = {}
    as_force = []
    for order in range(len(compared.lines.orders)):
        options = [_embedded(compared, order, free)]
        forced = kernels is not None and compared.lines.kinds[order].phase
        options += [_embedded(compared, order, kernels[order])] if kernels is not None and forced else []
        found = [_best_size(compared, residual, option) for option in options]
        gain, size = max(found)
        price = math.log(len(found) * SIZES.size)
        as_force.append(found.index((gain, size)) == 1)
        if gain - price > LEAST_GAIN:
            chosen[order], prices[order] = size * options[int(as_force[-1])], price
    count = len(compared.lines.orders)
    if not chosen:
        # Nothing is left over: that something is there all the same has to pay for at least one order.
        nothing = compared.log_constant - 0.5 * float(compared.residual @ compared.residual)
        none = np.zeros(compared.seen.shape, dtype=complex)
        return Unknown(nothing - LEAST_GAIN, none, np.zeros(count), (False,) * count, {}, {})
    # Sizes were chosen order by order; what they are worth together is the density of all lines.
    together = sum(chosen.values(), np.zeros_like(compared.covariance))
    evidence, values = _joint(compared, residual, together)
    gains = np.zeros(count)
    for order, part in chosen.items():
        gains[order] = evidence - _joint(compared, residual, together - part)[0]
    lines = unstacked(values, compared.lines.parts)
    return Unknown(evidence - sum(prices.values()), lines, gains, tuple(as_force), chosen, prices)


def _joint(compared: Comparison, residual: np.ndarray, added: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the logarithm of the density with a further covariance, and what of the residual that explains."""
    whole = compared.covariance + added
    factor = np.linalg.cholesky(whole + JITTER * np.diag(np.diag(whole)))
    white = np.linalg.solve(factor, residual)
    density = -0.5 * float(white @ white) - float(np.log(np.diag(factor)).sum())
    return density - 0.5 * residual.size * math.log(2 * math.pi), added @ np.linalg.solve(factor.T, white)


def _embedded(compared: Comparison, order: int, kernel: np.ndarray) -> np.ndarray:
    """Return the covariance of all stacked lines that a complex kernel of one order's lines makes.

    Scaled so that its largest variance is that of the order's largest line.
    """
    parts = compared.lines.parts
    real, imaginary = (part[:, :, order].ravel() for part in parts)
    whole = kernel.reshape(real.size, real.size)
    along, across = np.real(whole), np.imag(whole)
    real_rows, imaginary_rows = (np.flatnonzero(part) for part in (real, imaginary))
    mixed = -across[np.ix_(real_rows, imaginary_rows)]
    block = 0.5 * np.block(
        [[along[np.ix_(real_rows, real_rows)], mixed], [mixed.T, along[np.ix_(imaginary_rows, imaginary_rows)]]]
    )
    here = np.zeros(compared.seen.shape, dtype=bool)
    here[:, :, order] = True
    rows = np.flatnonzero(np.concatenate([here[part] for part in parts]))
    result = np.zeros_like(compared.covariance)
    if rows.size:
        left = np.abs(compared.factor @ compared.residual)[rows].max()
        result[np.ix_(rows, rows)] = block * left**2 / max(float(np.diag(block).max()), 1e-300)
    return result


def _best_size(compared: Comparison, residual: np.ndarray, kernel: np.ndarray) -> tuple[float, float]:
    """Return the largest gain of evidence in one order alone by a random function, and its size."""
    rows = np.flatnonzero(np.diag(kernel) > 0)
    if not rows.size:
        return 0.0, 0.0
    own, part = compared.covariance[np.ix_(rows, rows)], residual[rows]
    factor = np.linalg.cholesky(own + JITTER * np.diag(np.diag(own)))
    inverse = np.linalg.inv(factor)
    values, vectors = np.linalg.eigh(inverse @ kernel[np.ix_(rows, rows)] @ inverse.T)
    power = (vectors.T @ (inverse @ part)) ** 2
    grown = np.outer(SIZES**2, np.maximum(values, 0.0))
    gains = 0.5 * (power * grown / (1 + grown)).sum(axis=1) - 0.5 * np.log1p(grown).sum(axis=1)
    best = int(np.argmax(gains))
    return float(gains[best]), float(SIZES[best] ** 2)


def _line_kernel(compared: Comparison) -> np.ndarray:
    smooth = similarity(compared.lines.conditions)
    size = _sizes(compared)
    return np.einsum("cd,pq->cpdq", smooth, np.diag(size**2)).astype(complex)


def _sizes(compared: Comparison) -> np.ndarray:
    """Return the scale of each probe: its largest line."""
    return np.maximum(np.abs(compared.lines.amplitudes).max(axis=(0, 2)), 1e-300)


def force_kernels(machine: Machine, predictor: Predictor) -> np.ndarray:
    """Return the covariance of the lines that unit random forces at all places make, each smooth in speed.

    Shape (orders, conditions, probes, conditions, probes). Forces at different places and in different directions are
    independent. Parametric changes of the machine are left out: its mean is taken.
    """
    moved = np.stack([transfer(machine, predictor, i) for i in range(len(predictor.conditions))])
    smooth = similarity(predictor.conditions)
    return np.einsum("ckpf,dkqf,cd->kcpdq", moved, moved.conj(), smooth)


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
