"""What no effect explains, as forces: for each order the place, the direction and the law in speed and load.

An order's unexplained lines d are set against forces at one place, d = T(speed) (speed / reference)^p a, with the
transfer T of `force_transfer`, complex amplitudes a in closed form and the exponents by least squares in
the lines' covariance. Places and directions are compared by evidence (BIC). A description, not an explanation: an order
at which no force at one place does well is shown, and none is added.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...simulators.effects.empirical_force import EmpiricalForce
from .evidence import PROBE_TOLERANCE, Comparison
from .force_transfer import force_places, force_transfer, numbers_with_phase
from .judged import TOLD_APART, judged
from .model_error import error_covariance
from .predict import Predictor
from .result import AddedForce, Estimate
from .unknown_force import LEAST_GAIN, Unknown
from .waveform import accounts_for_lines
from .words import joined_words, line_names

if TYPE_CHECKING:
    from ...simulators.machine import Machine
    from .posterior import Posterior
    from .prepared import Prepared

#: Bounds of the exponents of speed and load, and steps of the first look at them.
SPEED_POWERS, LOAD_POWERS, LOOKS = (-2.0, 4.0), (0.0, 4.0), 13
#: Speeds (loads) within this share of each other show no law.
SAME = 0.05
#: Least share of an order's unexplained power that its force takes away, for the force to be added: 6 dB.
LEAST_SHARE = 0.75
#: Half width of a 90 % interval in standard deviations.
REACH = 1.645
#: Directions in which forces act together.
TOGETHER = (("x", "y"), ("x",), ("y",), ("axial",), ("torsion",))


@dataclass(frozen=True, eq=False)
class _Order:
    """The unexplained lines of one order, whitened, and the law's variables."""

    number: int
    parts: np.ndarray
    whitening: np.ndarray
    wanted: np.ndarray
    logs: np.ndarray
    bounds: tuple[tuple[float, float], ...]

    def columns(self, lines: np.ndarray) -> np.ndarray:
        """Return lines (2, forces, conditions, probes), of amplitudes 1, then of i, whitened: (reals, 2 forces)."""
        both = lines.reshape(-1, *lines.shape[2:])
        flat = np.concatenate([np.real(both)[:, self.parts[0]], np.imag(both)[:, self.parts[1]]], axis=1)
        return self.whitening @ flat.T


@dataclass(frozen=True, eq=False)
class _Force:
    """Forces at one place at their best: real amplitudes (cosine parts, then sine parts), then exponents."""

    at: str
    directions: tuple[str, ...]
    values: np.ndarray
    covariance: np.ndarray
    misfit: float
    freedom: int


def empirical_forces(prepared: Prepared, posterior: Posterior) -> tuple[tuple[AddedForce, ...], tuple[str, ...]]:
    """Return the forces to add when the verdict is "unknown", and what is shown without one, in sentences.

    Nothing where the waveform shows a defect of the measuring chain that may be what is left over.
    """
    accounted = accounts_for_lines(prepared.waveform, prepared.measured.probes, mended=prepared.mended)
    if judged(posterior.probabilities)[0] != "unknown" or accounted:
        return (), ()
    problem = prepared.problem(prepared.fitted)
    unknown, compared, best = posterior.unknown, posterior.compared, posterior.named
    if best.candidates:
        # The effect beside it makes an order that needs no force any more.
        left = np.isin(np.arange(unknown.gains.size), list(best.unknown_beside))
        unknown = replace(unknown, gains=np.where(left, unknown.gains, 0.0))
        compared = replace(compared, residual=compared.residual - compared.whitened(best.response))
    return forces_of(unknown, compared, problem.baseline.machine, problem.predictor)


def forces_of(
    unknown: Unknown, compared: Comparison, machine: Machine, predictor: Predictor
) -> tuple[tuple[AddedForce, ...], tuple[str, ...]]:
    """Return the forces that describe the unexplained orders, and why an order has none.

    Parameters
    ----------
    unknown : Unknown
    compared : Comparison
        Without any effect, in the fitted conditions.
    machine : Machine
        Calibrated.
    predictor : Predictor
        For these conditions.
    """
    numbers = [int(i) for i in np.flatnonzero(unknown.gains > 0)]
    if not numbers:
        return (), ("No single order stands out of what is left over: no force is added.",)
    speeds = [one.speed_rpm for one in compared.lines.conditions]
    if not all(one.tied for one in compared.lines.conditions):
        return (), ("No force is added for what is left over: without one tacho pulse a turn its phase is unknown.",)
    if max(speeds) < (1 + SAME) * min(speeds):
        return (), (
            "No force is added for what is left over: it was fitted at one speed, which shows no law. Record at two or "
            "more speeds.",
        )
    found: list[AddedForce] = []
    broken, not_described = [], []
    kinds = compared.lines.kinds
    whole = [k for k in numbers if kinds[k].phase and _is_whole(compared.lines.orders[k])]
    moved, phases = force_transfer(machine, predictor) if whole else None, numbers_with_phase(predictor)
    names = line_names(compared.lines)
    for k in numbers:
        if moved is None or k not in whole:
            broken.append(names[k])
            continue
        at = phases.index(k)
        added = _of_order(_order(compared, k), moved[:, :, at, at], force_places(machine), compared)
        found += added
        not_described += [] if added else [names[k]]
    remarks = [
        f"{joined_words(lines)} {'is' if len(lines) == 1 else 'are'} left over and shown; {why}."
        for lines, why in (
            (broken, "a force is added for whole orders of the shaft only"),
            (not_described, "no force at one place that grows with a power of the speed describes this: none is added"),
        )
        if lines
    ]
    return tuple(found), tuple(remarks)


def as_effect(force: AddedForce) -> EmpiricalForce:
    """Return the force as an effect that simulates."""
    size, turned = force.amplitude.value, 0.5 * math.pi * (force.direction == "y")
    return EmpiricalForce(
        at=force.at,
        force_n=size if force.direction in ("x", "y") else 0.0,
        axial_n=size if force.direction == "axial" else 0.0,
        torque_n_m=size if force.direction == "torsion" else 0.0,
        direction_rad=turned,
        phase_rad=force.phase.value,
        order=force.order,
        speed_exponent=force.speed_exponent.value,
        reference_speed_rpm=force.reference_speed_rpm,
        load_exponent=force.load_exponent.value if force.load_exponent else 0.0,
        reference_load=force.reference_load or 1.0,
    )


def _is_whole(order: float) -> bool:
    return abs(order - round(order)) < 1e-9


def _order(compared: Comparison, number: int) -> _Order:
    lines = compared.lines
    here = np.zeros(lines.seen.shape, dtype=bool)
    here[:, :, number] = True
    rows = np.flatnonzero(np.concatenate([here[part] for part in lines.parts]))
    left = np.where(lines.seen, lines.amplitudes - compared.expected, 0.0)
    # How well the machine's transfer is known at each probe, as for every effect.
    unsure = PROBE_TOLERANCE * np.sqrt((np.abs(left) ** 2).mean(axis=0) / 2) * (np.arange(len(lines.orders)) == number)
    widened = compared.covariance + error_covariance(lines.conditions, unsure, lines.parts)
    whitening = np.linalg.inv(np.linalg.cholesky(widened[np.ix_(rows, rows)]))
    logs, bounds = [np.log([one.speed_rpm for one in lines.conditions])], [SPEED_POWERS]
    loads = np.array([one.load or 0.0 for one in lines.conditions])
    if loads.min() > 0 and loads.max() > (1 + SAME) * loads.min():
        logs, bounds = [*logs, np.log(loads)], [*bounds, LOAD_POWERS]
    return _Order(
        number,
        lines.parts[:, :, :, number],
        whitening,
        whitening @ (compared.factor @ compared.residual)[rows],
        np.stack(logs),
        tuple(bounds),
    )


def _references(order: _Order) -> np.ndarray:
    """Return round numbers in the middle of the fitted speeds (and loads)."""
    return np.array([float(f"{value:.3g}") for value in np.exp(order.logs.mean(axis=1))])


def _of_order(
    order: _Order, moved: np.ndarray, places: Sequence[tuple[str, str]], compared: Comparison
) -> list[AddedForce]:
    """Return the forces at the best place; none when they explain too little."""
    options = []
    for name in dict.fromkeys(place for place, _ in places):
        for ways in TOGETHER:
            columns = [places.index((name, way)) for way in ways if (name, way) in places]
            if len(columns) == len(ways):
                lines = np.moveaxis(moved[..., columns], -1, 1)
                options += [_best(order, lines, name, ways)] if np.abs(lines).max() > 0 else []
    if not options:
        return []
    # A machine whose transfer is not quite right leaves more than noise: no place is told from another by less.
    excess = max(1.0, min(one.misfit / one.freedom for one in options))
    ranked = sorted(options, key=lambda one: -round(_evidence(one, order, excess), 3))
    best, whole = ranked[0], float(order.wanted @ order.wanted)
    share = 1 - best.misfit / whole
    gain = _evidence(best, order, excess) + 0.5 * whole / excess - math.log(len(options))
    if share < LEAST_SHARE or gain < LEAST_GAIN:
        return []
    close = _evidence(best, order, excess) - math.log(TOLD_APART)
    others = [one.at for one in ranked[1:] if _evidence(one, order, excess) > close and one.at != best.at]
    return _added(best, order, compared, excess, tuple(dict.fromkeys(others)), share)


def _evidence(force: _Force, order: _Order, excess: float) -> float:
    return -0.5 * force.misfit / excess - 0.5 * force.values.size * math.log(order.wanted.size)


def _best(order: _Order, lines: np.ndarray, at: str, ways: tuple[str, ...]) -> _Force:
    """Return the forces in these directions that explain the order best: amplitudes in closed form at each law."""
    from scipy.optimize import minimize

    logs = order.logs - np.log(_references(order))[:, None]

    def at_law(powers: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        columns = order.columns(lines * np.exp(powers @ logs)[None, :, None])
        amplitudes = np.linalg.lstsq(columns, order.wanted, rcond=None)[0]
        left = order.wanted - columns @ amplitudes
        return float(left @ left), amplitudes, columns

    looks = itertools.product(*(np.linspace(*bound, LOOKS) for bound in order.bounds))
    first = min((np.array(powers) for powers in looks), key=lambda powers: at_law(powers)[0])
    scale = max(at_law(first)[0], 1e-300)
    found = minimize(lambda p: at_law(p)[0] / scale, first, bounds=order.bounds, method="L-BFGS-B", tol=1e-10)
    powers = found.x if found.fun < 1 else first
    misfit, amplitudes, columns = at_law(powers)
    grown = [order.columns(lines * (np.exp(powers @ logs) * log)[None, :, None]) @ amplitudes for log in logs]
    slopes = np.column_stack([columns, *grown])
    covariance = np.linalg.pinv(slopes.T @ slopes, hermitian=True)
    freedom = max(order.wanted.size - slopes.shape[1], 1)
    return _Force(at, ways, np.concatenate([amplitudes, powers]), covariance, misfit, freedom)


def _added(
    force: _Force, order: _Order, compared: Comparison, excess: float, others: tuple[str, ...], share: float
) -> list[AddedForce]:
    deviations = np.sqrt(np.maximum(np.diag(force.covariance), 0.0) * excess)
    count, references = len(force.directions), _references(order)
    powers = [
        Estimate(float(value), max(float(value - REACH * sd), low), min(float(value + REACH * sd), high), "")
        for value, sd, (low, high) in zip(force.values[2 * count :], deviations[2 * count :], order.bounds, strict=True)
    ]
    found = []
    for i, way in enumerate(force.directions):
        amplitude, phase = _polar(
            force.values[[i, count + i]], excess * force.covariance[np.ix_([i, count + i], [i, count + i])]
        )
        found.append(
            AddedForce(
                order=compared.lines.orders[order.number],
                at=force.at,
                direction=way,
                amplitude=Estimate(*amplitude, "N.m" if way == "torsion" else "N"),
                phase=Estimate(*phase, "rad"),
                speed_exponent=powers[0],
                load_exponent=powers[1] if len(powers) > 1 else None,
                reference_speed_rpm=float(references[0]),
                reference_load=float(references[1]) if len(powers) > 1 else None,
                or_at=others,
                share=share,
            )
        )
    limits = {one.name: one.bounds[1] for one in EmpiricalForce.parameters()}
    fits = all(
        one.amplitude.value <= limits["torque_n_m" if one.direction == "torsion" else "force_n"] for one in found
    )
    return found if fits else []


def _polar(parts: np.ndarray, covariance: np.ndarray) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return size and angle of a complex number with their 90 % intervals."""
    size, angle = float(np.hypot(*parts)), math.atan2(parts[1], parts[0])
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    reach, turn = (REACH * math.sqrt(max(float(way @ covariance @ way), 0.0)) for way in (along, across))
    free = turn >= size
    width = math.pi if free else math.asin(turn / size)
    return (size, max(size - reach, 0.0), size + reach), (angle, angle - width, angle + width)
