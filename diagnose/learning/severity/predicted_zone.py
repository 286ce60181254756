"""The severity zone that the simulator predicts for an estimated severity, by the machine's own zone table.

The reference machine is given the estimated sizes. Their directions, and an unbalance of its own, are no severities:
they are those with which the machine's lines come closest to the record's. The level follows by harmonic balance, as in
a map of `rotorwise thresholds`. A pit in a bearing makes no shaft line: no zone follows from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ....datasets.recording import Channel
from ....datasets.simulated import nameplate_of
from ....datasets.units import parse_unit
from ....simulators.errors import InvalidValueError
from ...misalignment_levels import fitting, misalignment_levels
from ...result import Severity
from ...signal.integrate import DERIVATIVES
from ...zones.choose import automatic_table
from .feature_row import ShaftLines
from .unit_responses import (
    FARTHEST,
    ORDERS,
    SOURCES,
    SPEED_PRIOR,
    SPEED_STEP,
    UnitResponses,
    fit_sources,
    line_weights,
)

#: A level so close to a limit, relative, belongs to either zone.
CLOSE = 0.10
_ROUNDS = 20
#: Steps of the simulated speed that are tried around the one of the free fit.
_SHIFTS = range(-12, 13, 3)


@dataclass(frozen=True)
class PredictedZone:
    """Where the simulator puts an estimated severity.

    Attributes
    ----------
    zone, lowest, highest : str
        At the estimate and at the ends of its interval.
    level : float
        At the worst probe, SI.
    limits : tuple of float
        A/B, B/C, C/D in SI.
    table : str
        Name of the zone table.
    """

    zone: str
    lowest: str
    highest: str
    level: float
    limits: tuple[float, ...]
    table: str


def predicted_zone(
    responses: UnitResponses,
    lines: ShaftLines,
    sizes: Mapping[str, float],
    *,
    low: Mapping[str, float],
    high: Mapping[str, float],
) -> PredictedZone:
    """Return the zone that estimated sizes lead to.

    Parameters
    ----------
    responses : UnitResponses
    lines : ShaftLines
        Of the record, for speed and directions.
    sizes, low, high : mapping of str to float
        By source, in SI units: the estimate and the ends of its interval. Sources left out are fitted to the record.
    """
    vectors, speed_rpm = directed(responses, lines, sizes)
    free = {name: vector for name, vector in vectors.items() if name not in sizes}
    levels = []
    for ends in (sizes, low, high):
        turned = {name: ends[name] * np.exp(1j * np.angle(vectors[name])) for name in sizes}
        levels.append(_level(responses, lines.speed_rpm, speed_rpm, {**turned, **free}))
    (level, limits, table), *others = levels
    zones = sorted(_zone(one[0], limits) for one in (levels[0], *others))
    return PredictedZone(_zone(level, limits), zones[0], zones[-1], level, limits, table)


def _zone(level: float, limits: tuple[float, ...]) -> str:
    return "ABCD"[int(np.searchsorted(limits, level))]


def directed(
    responses: UnitResponses, lines: ShaftLines, sizes: Mapping[str, float]
) -> tuple[dict[str, complex], float]:
    """Return sources of given sizes with the directions that explain the lines best, the others free, and the speed.

    The speed is the one at which the simulated machine with these sizes responds most like this one.
    """
    start = fit_sources(responses, lines)
    wanted = lines.amplitudes * np.exp(1j * start.mark_rad * np.array(ORDERS)) * line_weights(lines)
    middle, true = responses.step(start.speed_rpm), responses.step(lines.speed_rpm)
    found = []
    for step in (middle + shift for shift in _SHIFTS if abs(middle + shift - true) <= round(FARTHEST / SPEED_STEP)):
        vectors, left = _settled(responses.at(step) * line_weights(lines), wanted, start.vectors, sizes)
        found.append((left + (SPEED_STEP * (step - true) / SPEED_PRIOR) ** 2, step, vectors))
    _, step, vectors = min(found, key=lambda one: one[0])
    return vectors, responses.speed_rpm(step)


def _settled(
    shapes: np.ndarray, wanted: np.ndarray, start: Mapping[str, complex], sizes: Mapping[str, float]
) -> tuple[dict[str, complex], float]:
    """Let each source in turn take the direction that suits what the others leave; return them and what is left."""
    vectors = {name: _sized(start[name], sizes.get(name)) for name in SOURCES}
    rows = shapes.reshape(len(SOURCES), 2, -1)
    inverses = [np.linalg.pinv(np.hstack([np.real(one), np.imag(one)]).T, rcond=1e-8) for one in rows]
    parts = {name: _lines(shape, vectors[name]) for name, shape in zip(SOURCES, shapes, strict=True)}
    for _ in range(_ROUNDS):
        for place, name in enumerate(SOURCES):
            rest = (wanted - sum(part for other, part in parts.items() if other != name)).ravel()
            found = inverses[place] @ np.hstack([np.real(rest), np.imag(rest)])
            vectors[name] = _sized(complex(*found), sizes.get(name))
            parts[name] = _lines(shapes[place], vectors[name])
    return vectors, float((np.abs(wanted - sum(parts.values())) ** 2).sum())


def _lines(shape: np.ndarray, vector: complex) -> np.ndarray:
    return shape[0] * vector.real + shape[1] * vector.imag


def _sized(vector: complex, size: float | None) -> complex:
    return vector if size is None else size * complex(np.exp(1j * np.angle(vector)))


def _level(
    responses: UnitResponses, true_rpm: float, simulated_rpm: float, vectors: Mapping[str, complex]
) -> tuple[float, tuple[float, ...], str]:
    machine = responses.machine_with(vectors)
    plate = nameplate_of(machine)
    linear = [probe for probe in machine.assembly(speed_rpm=true_rpm).probes if probe.name in responses.probes]
    unit = parse_unit(linear[0].unit)
    measured = unit.quantity if unit else ""
    chosen = automatic_table(Channel("probe", measured or None), plate)
    probes, rows = fitting(chosen.rows, linear, speed_rpm=true_rpm)
    levels = misalignment_levels(
        machine,
        speed_rpm=simulated_rpm,
        offsets_m=np.zeros(1),
        angles_rad=np.zeros(1),
        probes=probes,
        rows=rows,
        clearance_m=plate.magnetic_bearing_clearance_m,
    )
    # The lines are those at the simulated speed; what is integrated from them turns at the true one.
    power = DERIVATIVES.get(measured, 0) - DERIVATIVES[rows[0].quantity]
    level = float(levels.map.peaks.max()) * (simulated_rpm / true_rpm) ** power
    return level, levels.limits, f"{rows[0].standard}, {rows[0].table}"


def margin(shown: Severity) -> float:
    """Return how far a measured level is from the nearest limit, relative to that limit.

    Examples
    --------
    >>> round(margin(Severity("", "", "A", 1.26, "mm/s", "", (1.4, 2.8, 4.5), "", "", "H")), 3)
    0.1
    """
    if not shown.boundaries:
        raise InvalidValueError(f"Table {shown.table} has no limits. Name another table.")
    return min(abs(shown.value / limit - 1.0) for limit in shown.boundaries)


def disagreement(predicted: PredictedZone, shown: Severity) -> str:
    """Return a sentence where the record shows another zone than the estimated severities lead to; else empty."""
    if predicted.lowest <= shown.zone <= predicted.highest or margin(shown) < CLOSE:
        return ""
    if shown.zone > predicted.highest:
        return (
            f"The record shows zone {shown.zone}, the estimated severities explain {predicted.highest} at most: "
            "something else vibrates as well, or the machine differs from the simulated one."
        )
    return (
        f"The record shows zone {shown.zone}, the estimated severities would make {predicted.lowest} or worse: the "
        "machine differs from the simulated one, or the estimate is wrong."
    )
