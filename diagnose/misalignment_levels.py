"""How severe misalignment makes the vibration of a linear machine, by the measure that a zone table asks for.

The steady motion is affine in offset and angle (see `rotorwise.simulators.threshold_map`), so that the complex
amplitudes of three solutions give every other. Levels: the largest distance from the centre in a turn, sqrt(x^2 + y^2)
of the two probes at one place; peak to peak in a turn; or the rms of the orders inside a band, sqrt(sum |A_n|^2 / 2),
with acceleration divided by n w for a velocity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..datasets.recording import Channel
from ..datasets.units import parse_unit
from ..simulators.assembly import Probe
from ..simulators.effects.coupling_misalignment import CouplingMisalignment
from ..simulators.errors import InvalidValueError
from ..simulators.machine import Machine
from ..simulators.threshold_map import ThresholdMap
from .zones.choose import fits
from .zones.table import TABLE_UNIT_TO_SI, ZoneRow

#: Highest order in the levels: misalignment of couplings is gone long before.
HARMONICS = 16
_INSTANTS = 256
_SLOW_RPM = 600.0
#: Two solutions of one linear system agree to rounding; this is far above that and far below any effect.
_SUPERPOSITION = 1e-6
_DERIVATIVES = {"displacement": 0, "velocity": 1, "acceleration": 2}
_UNITS = {"offset_m": 1e-3, "angle_rad": 1e-2}


@dataclass(frozen=True)
class Levels:
    """Levels of some probes over offset and angle by the first of the rows, and its limits.

    A further row's level is put on the first one's scale with its zone limits on the first one's, and the worse counts.

    Attributes
    ----------
    map : ThresholdMap
        ``peaks`` holds levels in SI.
    limits : tuple of float
        A/B, B/C, C/D in SI.
    rows : tuple of ZoneRow
        The first gives the scale.
    """

    map: ThresholdMap
    limits: tuple[float, ...]
    rows: tuple[ZoneRow, ...]


def fitting(rows: Sequence[ZoneRow], probes: Sequence[Probe], *, speed_rpm: float) -> tuple[list[Probe], list[ZoneRow]]:
    """Return the probes that rows can judge, and those rows.

    Raises
    ------
    InvalidValueError
        When no row fits a probe; the message says what the machine's probes measure and the table wants.
    """
    here = [row for row in rows if row.holds_at(speed_rpm)]
    judged = [probe for probe in probes if any(fits(row, _channel(probe)) for row in here)]
    kept = [row for row in here if judged and fits(row, _channel(judged[0]))]
    if not kept:
        measured = ", ".join(sorted({f"{probe.quantity} in {probe.unit}" for probe in probes}))
        wanted = ", ".join(sorted({f"{row.sensor} {row.quantity}" for row in rows}))
        raise InvalidValueError(
            f"Zone table {rows[0].id} judges {wanted}{'' if here else ' at other speeds'}; the probes measure "
            f"{measured}. Name a table that fits (--zones)."
        )
    return judged, kept


def _channel(probe: Probe) -> Channel:
    unit = parse_unit(probe.unit)
    return Channel(probe.name, unit.quantity if unit else None)


def misalignment_levels(
    machine: Machine,
    *,
    speed_rpm: float,
    offsets_m: np.ndarray,
    angles_rad: np.ndarray,
    probes: Sequence[Probe],
    rows: Sequence[ZoneRow],
    clearance_m: float | None,
) -> Levels:
    """Return the levels of probes over parallel and angular misalignment, both of the same phase.

    Parameters
    ----------
    machine : Machine
        Linear, with a coupling.
    speed_rpm : float
    offsets_m, angles_rad : ndarray (offsets,), (angles,)
    probes, rows
        As `fitting` gives them.
    clearance_m : float or None
        Smallest radial clearance, for tables that ask for it.

    Raises
    ------
    InvalidValueError
        For a machine that is not linear, or a missing clearance.
    """
    limits = [_limits(row, speed_rpm, clearance_m) for row in rows]
    names = tuple(probe.name for probe in probes)
    parts = _amplitudes(machine, speed_rpm, names)
    made = [_map(speed_rpm, offsets_m, angles_rad, probes, row, parts) for row in rows]
    levels = made[0].peaks
    for other, own in zip(made[1:], limits[1:], strict=True):
        levels = np.maximum(levels, _on_scale(other.peaks, own, limits[0]))
    return Levels(replace(made[0], peaks=levels), limits[0], tuple(rows))


def _limits(row: ZoneRow, speed_rpm: float, clearance_m: float | None) -> tuple[float, ...]:
    if row.law == "fraction_of_clearance" and clearance_m is None:
        raise InvalidValueError(f"Table {row.id} needs the smallest radial clearance. Give --clearance in metres.")
    scale = TABLE_UNIT_TO_SI["um" if row.unit == "C_min" else row.unit]
    return tuple(scale * limit for limit in row.limits(speed_rpm=speed_rpm, clearance_m=clearance_m))


def _on_scale(levels: np.ndarray, own: Sequence[float], scale: Sequence[float]) -> np.ndarray:
    inside = np.interp(levels, [0.0, *own], [0.0, *scale])
    return np.where(levels > own[-1], levels * scale[-1] / own[-1], inside)


def _map(
    speed_rpm: float,
    offsets: np.ndarray,
    angles: np.ndarray,
    probes: Sequence[Probe],
    row: ZoneRow,
    parts: np.ndarray,
) -> ThresholdMap:
    names = tuple(probe.name for probe in probes)
    if row.detector == "rms":
        weights = np.array([_band_weights(probe, row, speed_rpm) for probe in probes])
        return ThresholdMap(names, offsets, angles, _rms(parts * weights, offsets, angles))
    phase = np.exp(2j * np.pi * np.outer(np.arange(HARMONICS + 1), np.arange(_INSTANTS) / _INSTANTS))
    waves = np.real(parts @ phase)
    if row.detector == "zero-to-max":
        pairs = _pairs(probes)
        return ThresholdMap(tuple(pairs), offsets, angles, _radius(waves, list(pairs.values()), offsets, angles))
    return ThresholdMap(names, offsets, angles, _peak_to_peak(waves, offsets, angles))


def _pairs(probes: Sequence[Probe]) -> dict[str, tuple[int, int]]:
    """Return the numbers of the x and the y probe at each place that has both."""
    there = {(probe.location, probe.direction): number for number, probe in enumerate(probes)}
    places = dict.fromkeys(probe.location for probe in probes)
    pairs = {
        place: (there[place, "x"], there[place, "y"]) for place in places if {(place, "x"), (place, "y")} <= set(there)
    }
    if not pairs:
        raise InvalidValueError(
            f"Probes {', '.join(probe.name for probe in probes)}; allowed for this table: an x and a y probe at one "
            "place, whose distance from the centre it judges. Name another table (--zones)."
        )
    return pairs


def _band_weights(probe: Probe, row: ZoneRow, speed_rpm: float) -> np.ndarray:
    """Return the factor from a probe's peak amplitude at each order to the rms that the row asks for."""
    assert row.band_hz is not None
    low = row.slow_low_hz if speed_rpm < _SLOW_RPM and row.slow_low_hz else row.band_hz[0]
    frequency = np.arange(HARMONICS + 1) * speed_rpm / 60
    power = _DERIVATIVES[row.quantity] - _DERIVATIVES[probe.quantity]
    inside = (frequency >= low) & (frequency <= row.band_hz[1])
    return np.where(inside, (2 * np.pi * np.where(inside, frequency, 1.0)) ** power, 0.0) / math.sqrt(2)


def _amplitudes(machine: Machine, speed_rpm: float, names: Sequence[str]) -> np.ndarray:
    """Return complex amplitudes (3, probes, orders): without misalignment, per metre of offset, per radian of angle."""
    from ..simulators.solvers.harmonic_balance import harmonic_balance

    system = machine.system(speed_rpm=speed_rpm)
    curved = [force.name for force in system.forces if not force.law.is_linear]
    if curved:
        raise InvalidValueError(
            f"The force {curved[0]!r} of machine {machine.name} is not linear in the motion; allowed: linear machines. "
            "Choose another preset, or simulate each case (rotorwise simulate)."
        )
    rows = [[probe.name for probe in system.probes].index(name) for name in names]

    unshifted = CouplingMisalignment(offset_m=0.0, angle_rad=0.0, offset_phase_rad=0.0, angle_phase_rad=0.0)

    def solved(**changes: float) -> np.ndarray:
        shifted = machine.with_effects(unshifted.with_values(**changes))
        return harmonic_balance(shifted, speed_rpm=speed_rpm, harmonics=HARMONICS).amplitudes[rows]

    base, offset, angle, both = solved(), *(solved(**{key: value}) for key, value in _UNITS.items()), solved(**_UNITS)
    if np.abs(offset + angle - base - both).max() > _SUPERPOSITION * np.abs(both).max():
        raise InvalidValueError(
            f"A misalignment of machine {machine.name} changes its stiffness, so that responses do not add up; "
            "allowed: couplings where it only adds a force. Simulate each case (rotorwise simulate)."
        )
    return np.array([base, (offset - base) / _UNITS["offset_m"], (angle - base) / _UNITS["angle_rad"]])


def _rms(parts: np.ndarray, offsets: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return sqrt(sum over orders |a_0 + offset a_1 + angle a_2|^2), shape (probes, offsets, angles)."""
    gram = np.einsum("ipn,jpn->pij", parts, parts.conj()).real
    shape = (offsets.size, angles.size)
    point = np.stack(np.broadcast_arrays(1.0, offsets[:, None] * np.ones(shape), angles * np.ones(shape)))
    return np.sqrt(np.maximum(np.einsum("pij,iab,jab->pab", gram, point, point), 0.0))


def _peak_to_peak(waves: np.ndarray, offsets: np.ndarray, angles: np.ndarray) -> np.ndarray:
    found = np.empty((waves.shape[1], offsets.size, angles.size))
    for probe, (base, offset, angle) in enumerate(waves.transpose(1, 0, 2)):
        for i, value in enumerate(offsets):
            found[probe, i] = np.ptp(base + value * offset + np.multiply.outer(angles, angle), axis=1)
    return found


def _radius(waves: np.ndarray, pairs: Sequence[tuple[int, int]], offsets: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return the largest sqrt(x^2 + y^2) in a turn, shape (pairs, offsets, angles)."""
    found = np.empty((len(pairs), offsets.size, angles.size))
    for number, pair in enumerate(pairs):
        base, offset, angle = waves[:, list(pair)]
        for i, value in enumerate(offsets):
            along, across = np.moveaxis(base + value * offset + np.multiply.outer(angles, angle), 1, 0)
            found[number, i] = np.hypot(along, across).max(axis=1)
    return found
