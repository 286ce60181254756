"""Severity: in which zone of which standard each channel stands, or why nothing can be said.

The tables are data files in ``zones``, each row with its source and confidence. Units are never guessed:
without one there is no zone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from ..datasets.recording import Channel, Recording
from ..simulators.errors import InvalidValueError
from .result import Severity
from .zones.choose import automatic_table, fits
from .zones.level import Machine, Refused, level, quantity_text, unit_text
from .zones.measure import is_constant
from .zones.table import ChosenTable, ZoneRow, available_tables, find_table

__all__ = ["assess", "available_tables", "baseline_limits", "zone_of"]

_JUDGED = ("acceleration", "velocity", "displacement")
_AT_RIGHT_ANGLES = {"x": "y", "y": "x", "horizontal": "vertical", "vertical": "horizontal"}
#: Words that name a part which turns: what is measured there is no vibration of a housing.
_TURNING = {"shaft", "rotor", "pinion", "wheel", "disc", "disk", "impeller", "spindle", "journal", "hub"}
#: The probe of a pair that is judged with the other one.
_SECOND = ("y", "vertical")


@dataclass(frozen=True)
class _Item:
    """One channel, or a pair of shaft probes, to judge by one table."""

    channels: tuple[int, ...]
    table: ChosenTable


def assess(
    recording: Recording,
    *,
    speed_rpm: float | None = None,
    baseline: Recording | None = None,
    table: str | None = None,
) -> tuple[tuple[Severity, ...], str]:
    """Return the severity of each channel, the worst first, and the reason when there is none.

    Housing channels are judged by rms in 10-1000 Hz (2-1000 Hz below 600 r/min), shaft probes by peak-to-peak
    displacement, probes of magnetic bearings by their largest distance from the clearance centre, offset
    included. Where a table gives velocity and displacement, the worse zone counts. A value on a boundary is
    in the better zone.

    Parameters
    ----------
    recording : Recording
        Of any length; read in blocks.
    speed_rpm : float or None
        Shaft speed; the nominal speed of the recording when not given.
    baseline : Recording or None
        The same machine in good order; its channels are matched by name and give alarm and trip.
    table : str or None
        One of ``available_tables()``, possibly shortened; the nameplate's table when not given, else chosen
        from power, shaft height and mounting. Channels that the table is not made for get the automatic one.

    Returns
    -------
    severity : tuple of Severity
    refusal : str
        Empty when there is at least one result; otherwise a sentence that says what to do.

    Raises
    ------
    InvalidValueError
        On an unknown table or a speed that is not allowed.
    """
    machine = _machine(recording, speed_rpm)
    name = table or recording.nameplate.severity_table
    plate = recording.nameplate
    named = find_table(name, mounting=plate.mounting, power_kw=plate.power_kw) if name else None
    reasons = [_unusable(recording.channels)]
    if named and not any(fits(row, channel) for row in named.rows for channel in recording.channels):
        if any(channel.quantity in _JUDGED for channel in recording.channels):
            reasons.append(_wrong_table(named))
        return (), _joined(reasons)
    results: list[Severity] = []
    for item in _items(recording, named):
        try:
            results.append(_judge(recording, item, machine, baseline))
        except Refused as refusal:
            reasons.append(str(refusal))
    if results:
        return tuple(sorted(results, key=_rank, reverse=True)), ""
    return (), _joined(reasons)


def _joined(reasons: list[str]) -> str:
    said = " ".join(dict.fromkeys(filter(None, reasons)))
    return said or "No vibration channel in this recording: no severity."


def zone_of(value: float, boundaries: Iterable[float]) -> str:
    """Return the zone of a value; on a boundary the lower, better zone.

    Examples
    --------
    >>> zone_of(2.8, (1.4, 2.8, 4.5)), zone_of(2.81, (1.4, 2.8, 4.5))
    ('B', 'C')
    """
    return "ABCD"[sum(value > boundary for boundary in boundaries)]


def baseline_limits(baseline: float, boundaries: tuple[float, ...]) -> tuple[float, float]:
    """Return ALARM = min(baseline + 0.25 BC, 1.25 BC) and TRIP = 1.25 CD, in the unit of the boundaries.

    Source: ISO 20816-3, operational limits (one good secondary source).

    Examples
    --------
    >>> baseline_limits(1.0, (1.4, 2.8, 4.5))
    (1.7, 5.625)
    """
    _, middle, upper = boundaries
    return min(baseline + 0.25 * middle, 1.25 * middle), 1.25 * upper


def _machine(recording: Recording, speed_rpm: float | None) -> Machine:
    if speed_rpm is not None and not (math.isfinite(speed_rpm) and speed_rpm >= 0):
        raise InvalidValueError(f"Speed {speed_rpm} r/min; allowed: a finite number >= 0, or leave it out.")
    nominal = recording.condition.speed_rpm
    # A speed of zero is how some files say that nobody filled it in.
    speed = speed_rpm or nominal or None
    return Machine(speed, not speed_rpm, recording.nameplate.magnetic_bearing_clearance_m)


def _unusable(channels: tuple[Channel, ...]) -> str:
    """Return the sentence for channels whose quantity no zone table judges; empty when there are none."""
    sentences = []
    unknown = [channel.name for channel in channels if channel.quantity is None]
    without = [channel.name for channel in channels if channel.quantity in _JUDGED and _without_a_zone(channel)]
    volts = [channel.name for channel in channels if channel.quantity == "voltage"]
    sound = [channel.name for channel in channels if channel.quantity == "sound_pressure"]
    if unknown:
        sentences.append(f"Unit of {_some(unknown)} unknown: no severity. Pass --unit or --sensitivity.")
    if without:
        sentences.append(
            f"{_some(without)}: of a turning part, or torsion, which no zone judges. Pass --severity-table if one does."
        )
    if volts:
        sentences.append(f"{_some(volts)} in volts: no severity. Pass --sensitivity, for example 100 mV/g.")
    if sound:
        sentences.append(f"{_some(sound)}: sound pressure, which no vibration zone judges. Use a vibration channel.")
    return " ".join(sentences)


def _some(names: list[str]) -> str:
    shown = ", ".join(names[:3])
    return shown if len(names) <= 3 else f"{shown} and {len(names) - 3} more"


def _wrong_table(named: ChosenTable) -> str:
    row = named.rows[0]
    needed = "a displacement probe at the shaft" if row.sensor == "shaft" else "acceleration or velocity of a housing"
    return f"Table {row.id} needs {needed}, which this recording lacks. Pass another --severity-table or leave it out."


def _items(recording: Recording, named: ChosenTable | None) -> Iterator[_Item]:
    """Yield what to judge; probes whose table asks for a radius come in pairs."""
    for index, channel in enumerate(recording.channels):
        if channel.quantity not in _JUDGED or (named is None and _without_a_zone(channel)):
            continue
        chosen = named or automatic_table(channel, recording.nameplate)
        rows = tuple(row for row in chosen.rows if fits(row, channel))
        if not rows:
            chosen = automatic_table(channel, recording.nameplate)
            rows = tuple(row for row in chosen.rows if fits(row, channel))
        chosen = replace(chosen, rows=rows)
        if rows[0].detector != "zero-to-max":
            yield _Item((index,), chosen)
        elif channel.direction not in _SECOND or _partner(recording, index) is None:
            partner = _partner(recording, index)
            yield _Item((index,) if partner is None else (index, partner), chosen)


def _without_a_zone(channel: Channel) -> bool:
    """Return whether no standard judges what a channel measures: torsion, or velocity of a part that turns.

    Zones of housings are for bearing housings, those of shafts for displacement.
    """
    turning = channel.quantity != "displacement" and bool(_TURNING & set((channel.location or "").lower().split()))
    return turning or channel.direction == "torsion"


def _partner(recording: Recording, index: int) -> int | None:
    """Return the probe at right angles to this one at the same place."""
    mine = recording.channels[index]
    wanted = _AT_RIGHT_ANGLES.get(mine.direction or "")
    found = [
        other
        for other, channel in enumerate(recording.channels)
        if channel.quantity == "displacement" and channel.direction == wanted and channel.location == mine.location
    ]
    return found[0] if wanted and len(found) == 1 else None


def _judge(recording: Recording, item: _Item, machine: Machine, baseline: Recording | None) -> Severity:
    for index in item.channels:
        if is_constant(recording.signals[index]):
            raise Refused(
                f"{recording.channels[index].name} never changes: no severity. Check the sensor and its cable."
            )
    rows = _rows_at_speed(item.table.rows, machine)
    judged = [_severity(recording, item, row, machine, baseline) for row in rows]
    worst = max(judged, key=lambda severity: severity.zone)
    others = [
        f"{other.quantity.split(',')[0]} {other.value:.3g} {other.unit}: zone {other.zone}"
        for other in judged
        if other is not worst
    ]
    return replace(worst, note="; ".join(filter(None, (item.table.assumption, worst.note, *others))))


def _rows_at_speed(rows: tuple[ZoneRow, ...], machine: Machine) -> tuple[ZoneRow, ...]:
    speed = machine.speed_rpm
    if speed is None and any(row.needs_speed for row in rows):
        raise Refused(f"Table {rows[0].id} needs the shaft speed: no severity. Pass --speed in r/min.")
    holding = tuple(row for row in rows if row.holds_at(speed))
    if not holding:
        ranges = ", ".join(f"{low:g}-{high:g}" for low, high in (row.speed_rpm or (0, 0) for row in rows))
        raise Refused(
            f"Table {rows[0].id} has no limits at {speed:g} r/min (it has {ranges} r/min): no severity. "
            "Pass another --severity-table."
        )
    return holding


def _severity(
    recording: Recording, item: _Item, row: ZoneRow, machine: Machine, baseline: Recording | None
) -> Severity:
    try:
        boundaries = row.limits(speed_rpm=machine.speed_rpm, clearance_m=machine.clearance_m)
    except InvalidValueError as error:
        raise Refused(str(error)) from error
    value, notes = level(recording, item.channels, row, machine)
    if not math.isfinite(value):
        names = ", ".join(recording.channels[index].name for index in item.channels)
        raise Refused(f"{names} has too many gaps: no severity. Record again or repair the file.")
    alarm, trip, change = _against_baseline(value, boundaries, recording, item, row, machine, baseline)
    if row.needs_speed and machine.speed_is_nominal:
        notes.append(f"nominal speed {machine.speed_rpm:g} r/min used")
    if not row.verified:
        notes.append("numbers of this table not verified")
    return Severity(
        standard=row.standard,
        table=row.table,
        zone=zone_of(value, boundaries),
        value=value,
        unit=unit_text(row),
        quantity=quantity_text(row, machine),
        boundaries=boundaries,
        channel=" + ".join(recording.channels[index].name for index in item.channels),
        source=row.source,
        confidence=row.confidence,
        verified=row.verified,
        alarm=alarm,
        trip=trip,
        note="; ".join(filter(None, (row.note, *notes, change))),
    )


def _against_baseline(
    value: float,
    boundaries: tuple[float, ...],
    recording: Recording,
    item: _Item,
    row: ZoneRow,
    machine: Machine,
    baseline: Recording | None,
) -> tuple[float | None, float | None, str]:
    """Return alarm, trip and a sentence about the change since the baseline."""
    if baseline is None or len(boundaries) != 3:
        return None, None, ""
    named = {channel.name: index for index, channel in enumerate(baseline.channels)}
    names = [recording.channels[index].name for index in item.channels]
    matched = tuple(named[name] for name in names if name in named)
    if len(matched) != len(names) or not all(fits(row, baseline.channels[index]) for index in matched):
        return None, None, "baseline has no such channel in a known unit: no alarm limits"
    try:
        before, _ = level(baseline, matched, row, machine)
    except Refused:
        before = math.nan
    if not math.isfinite(before):
        return None, None, "baseline too short or damaged: no alarm limits"
    alarm, trip = baseline_limits(before, boundaries)
    if abs(value - before) <= 0.25 * boundaries[1]:
        return alarm, trip, ""
    unit = unit_text(row)
    return (
        alarm,
        trip,
        f"significant change since the baseline: {before:.3g} to {value:.3g} {unit}, over 25 % of B/C",
    )


def _rank(severity: Severity) -> tuple[str, float]:
    return severity.zone, severity.value / severity.boundaries[-1]
