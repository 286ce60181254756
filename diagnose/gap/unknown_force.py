"""The hypothesis that something acts which no effect of the catalogue explains: smooth forces, or simply smooth lines.

Order by order the unexplained part is a random function of speed: either forces at all places of the machine, each
varying smoothly, or an error of each probe's line, varying smoothly. Which of the two and how strong is what the data
say most probably (empirical Bayes); the choice costs the logarithm of the number of choices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...simulators.machine import Machine
from .baseline import similarity
from .evidence import Comparison
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
    """

    log_evidence: float
    lines: np.ndarray
    gains: np.ndarray
    as_force: tuple[bool, ...]


def unexplained(compared: Comparison, log_evidence: float, kernels: np.ndarray | None) -> Unknown:
    """Return the most probable unexplained lines.

    Parameters
    ----------
    compared : Comparison
    log_evidence : float
        Of nothing being there.
    kernels : ndarray (orders, conditions, probes, conditions, probes), complex, optional
        Covariance of the lines that forces make, from `force_kernels`.
    """
    orders = len(compared.lines.orders)
    residual = compared.factor @ compared.residual
    lines = np.zeros(compared.seen.shape, dtype=complex)
    gains, as_force = np.zeros(orders), []
    for order in range(orders):
        found = [_explained(compared, residual, order, _line_kernel(compared))]
        if kernels is not None:
            found.append(_explained(compared, residual, order, kernels[order]))
        gain, values = max(found, key=lambda one: one[0])
        as_force.append(len(found) > 1 and found[1][0] >= found[0][0])
        cost = math.log(len(found) * SIZES.size)
        if gain - cost > LEAST_GAIN:
            gains[order] = gain - cost
            lines[:, :, order] = values
    return Unknown(log_evidence + float(gains.sum()), lines, gains, tuple(as_force))


def _line_kernel(compared: Comparison) -> np.ndarray:
    smooth = similarity(compared.lines.conditions)
    size = _sizes(compared)
    return np.einsum("cd,pq->cpdq", smooth, np.diag(size**2)).astype(complex)


def _sizes(compared: Comparison) -> np.ndarray:
    """Return the scale of each probe: its largest line."""
    return np.maximum(np.abs(compared.lines.amplitudes).max(axis=(0, 2)), 1e-300)


def _explained(compared: Comparison, residual: np.ndarray, order: int, kernel: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the largest gain of evidence in one order by a random function with this kernel, and its lines."""
    shape = compared.seen.shape[:2]
    here = np.zeros(compared.seen.shape, dtype=bool)
    here[:, :, order] = compared.seen[:, :, order]
    rows = np.flatnonzero(np.tile(here[compared.seen], 2))
    if not rows.size:
        return 0.0, np.zeros(shape, dtype=complex)
    own, part = compared.covariance[np.ix_(rows, rows)], residual[rows]
    flat = compared.seen[:, :, order].ravel()
    complex_kernel = kernel.reshape(flat.size, flat.size)[np.ix_(flat, flat)]
    real = 0.5 * np.block([[complex_kernel.real, -complex_kernel.imag], [complex_kernel.imag, complex_kernel.real]])
    factor = np.linalg.cholesky(own + JITTER * np.diag(np.diag(own)))
    inverse = np.linalg.inv(factor)
    values, vectors = np.linalg.eigh(inverse @ real @ inverse.T)
    values = np.maximum(values, 0.0)
    power = (vectors.T @ (inverse @ part)) ** 2
    scale = float(np.abs(part).max()) / max(math.sqrt(float(np.diag(real).max())), 1e-300)
    with np.errstate(over="ignore"):
        grown = np.outer((SIZES * scale) ** 2, values)
    gains = 0.5 * (power * grown / (1 + grown)).sum(axis=1) - 0.5 * np.log1p(grown).sum(axis=1)
    best = int(np.argmax(gains))
    taken = factor @ vectors @ (grown[best] / (1 + grown[best]) * (vectors.T @ (inverse @ part)))
    lines = np.zeros(flat.size, dtype=complex)
    lines[flat] = taken[: flat.sum()] + 1j * taken[flat.sum() :]
    return float(gains[best]), lines.reshape(shape)


def force_kernels(machine: Machine, predictor: Predictor) -> np.ndarray:
    """Return the covariance of the lines that unit random forces at all places make, each smooth in speed.

    Shape (orders, conditions, probes, conditions, probes). Forces at different places and in different directions are
    independent. Parametric changes of the machine are left out: its mean is taken.
    """
    transfer = np.stack([_transfer(machine, predictor, i) for i in range(len(predictor.conditions))])
    smooth = similarity(predictor.conditions)
    return np.einsum("ckpf,dkqf,cd->kcpdq", transfer, transfer.conj(), smooth)


def _transfer(machine: Machine, predictor: Predictor, index: int) -> np.ndarray:
    """Return the probes' lines per unit force, shape (orders, probes, forces)."""
    condition = predictor.conditions[index]
    loaded = at_condition(machine, condition)
    system = loaded.system(speed_rpm=condition.speed_rpm)
    places = loaded.bare_assembly().places.values()
    directions = [
        place.directions[way] for place in places for way in ("x", "y", "axial", "torsion") if way in place.directions
    ]
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
