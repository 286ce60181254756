"""What is clearly there and no finding accounts for: risen lines and noise, and impacts of an unknown rhythm."""

from __future__ import annotations

import numpy as np

from .compare import comparable, floor_change_db, order_change_db
from .faults.bearing import defect_odds, shaft_ratios
from .observe import Observation
from .order_lines import bearing_resolved, near_a_bearing
from .result import Finding, Severity
from .risen_lines import RisenLine, risen_lines
from .signal.envelope import EnvelopeSpectrum

_RISE_DB = 6.0
_DEEPER = 2.0  # impacts count against a baseline when they modulate at least twice as deep
_SLIP = 0.02
_MOST_LINES = 3
#: Faults that lift whole orders of the shaft, and faults that make one line, which they name.
_OF_ORDERS = {"unbalance", "misalignment", "bent_shaft", "looseness", "rub", "resonance"}
_OF_ONE_LINE = {"oil_whirl", "electrical"}
_SHOWN = {"m": (1e6, "um"), "m/s": (1e3, "mm/s")}


def unexplained(
    now: Observation,
    baseline: Observation | None,
    findings: tuple[Finding, ...],
    severity: tuple[Severity, ...] = (),
) -> tuple[str, ...]:
    """Return what is clearly there and no finding accounts for, one sentence each.

    Parameters
    ----------
    now : Observation
    baseline : Observation or None
        Used where it is comparable.
    findings : tuple of Finding
    severity : tuple of Severity
        With alarm limits from the baseline where known: on a channel above its limit a doubled line is told.
    """
    if not now.turning:
        return ()
    found: list[str] = []
    reference = baseline if comparable(now, baseline) else None
    if reference is not None:
        lines = _risen_lines(now, reference, findings, severity)
        found = [*_shaft_or_bearing(now, reference), *(_told(one) for one in lines[:_MOST_LINES])]
        found += _risen_noise(now, reference, findings, lines)
    if not now.recording.nameplate.bearings:
        found += _unknown_rhythm(now, reference)
    return tuple(found)


def _shaft_or_bearing(now: Observation, baseline: Observation) -> list[str]:
    """Say so when 2X or 3X rose and the record cannot tell whether it is the shaft's line or a bearing's beside it."""
    found = []
    for order in (2.0, 3.0):
        rise = float(order_change_db(now, baseline, order).max())
        if rise < _RISE_DB or not near_a_bearing(now, order) or bearing_resolved(now, order):
            continue
        found.append(
            f"{order:g}X rose by {rise:.0f} dB, but a rhythm of a bearing lies within 2.5 % of it and "
            f"{now.turns:.0f} turns cannot tell the two apart: it counts for neither. Record longer, with a tacho."
        )
    return found


def _risen_lines(
    now: Observation, baseline: Observation, findings: tuple[Finding, ...], severity: tuple[Severity, ...]
) -> list[RisenLine]:
    """Return the new and risen lines that no likely finding, nor several together, carry."""
    likely = {one.fault for one in findings if one.probability > 0.5}
    if likely - _OF_ORDERS - _OF_ONE_LINE:
        return []  # impacts, teeth and sensors put lines in many places
    louder = {
        name for one in severity if one.alarm is not None and one.value > one.alarm for name in one.channel.split(" + ")
    }
    tolerance = 2 * now.spectrum.resolution_hz
    return [
        one
        for one in risen_lines(now, baseline, louder=louder)
        if not (one.at_an_order and likely & _OF_ORDERS) and _carried(one, findings, tolerance) < 0.5
    ]


def _carried(one: RisenLine, findings: tuple[Finding, ...], tolerance_hz: float) -> float:
    """Return the probability of the findings that name this line as evidence; they share it, so that it adds up."""
    return sum(
        finding.probability
        for finding in findings
        if any(
            line.spectrum == "spectrum" and abs(line.frequency_hz - one.line.frequency_hz) <= tolerance_hz
            for line in finding.lines
        )
    )


def _told(one: RisenLine) -> str:
    line = one.line
    factor, unit = _SHOWN.get(line.unit or "", (1.0, line.unit or "(unit unknown)"))
    before = factor * (line.baseline_amplitude or 0.0)
    name = f"{line.name}, {line.frequency_hz:.4g} Hz," if one.at_an_order else f"A line at {line.frequency_hz:.4g} Hz"
    place = "" if one.at_an_order else f" ({line.order:.3f}X, no order of the shaft)"
    return (
        f"{name}{place} rose by {one.rise_db:.0f} dB on {line.channel}, from {before:.3g} at most to "
        f"{factor * line.amplitude:.3g} {unit}, and no likely finding accounts for it."
    )


def _risen_noise(
    now: Observation, baseline: Observation, findings: tuple[Finding, ...], lines: list[RisenLine]
) -> list[str]:
    """Say so when the noise rose broadly and no finding accounts for it; a strong new line lifts what is beside it."""
    if any(one.probability > 0.5 for one in findings):
        return []
    centres, change = floor_change_db(now, baseline)
    rises = np.median(change, axis=0)
    for one in lines:
        rises = np.where(np.abs(np.log2(centres / one.line.frequency_hz)) < 1.0, 0.0, rises)
    high = np.flatnonzero(rises > _RISE_DB)
    if not high.size:
        return []
    worst = int(high[np.argmax(rises[high])])
    return [
        f"The noise rose by {rises[worst]:.0f} dB round {centres[worst]:.0f} Hz (median of the channels) "
        "and no fault of the catalogue accounts for it."
    ]


def _unknown_rhythm(now: Observation, baseline: Observation | None) -> list[str]:
    """Say so when strong impacts repeat at an order that is no multiple of the shaft and no bearing is known."""
    best = None
    for envelope in now.envelopes:
        spectrum = envelope.spectrum
        order = spectrum.frequency_hz / now.speed_hz
        inside = order > 1.3
        for ratio in shaft_ratios(now):
            distance = np.abs(order - ratio * np.rint(order / ratio))
            inside &= distance > 0.04 * ratio + 1.5 * spectrum.resolution_hz / now.speed_hz
        depth = np.where(inside & (spectrum.power_ratio[0] > now.significant_ratio), spectrum.amplitude[0], 0.0)
        if baseline is not None:
            depth = np.where(depth >= _DEEPER * _depth_before(baseline, envelope, order, depth > 0), depth, 0.0)
        index = int(np.argmax(depth))
        if depth[index] > 0 and (best is None or depth[index] > best[0]):
            best = (float(depth[index]), float(order[index]), envelope)
    if best is None or defect_odds(best[0]) < 1.0:
        return []
    depth, order, envelope = best
    return [
        f"Impacts repeat at {order:.3f}X ({depth:.0%} modulation, {envelope.low_hz:.0f}-{envelope.high_hz:.0f} Hz), no "
        "multiple of the shaft speed: a rolling bearing? Pass --bearing to name it."
    ]


def _depth_before(
    baseline: Observation, envelope: EnvelopeSpectrum, orders: np.ndarray, wanted: np.ndarray
) -> np.ndarray:
    """Return how deep the baseline's envelope is modulated near each wanted order in about the same band, else 0."""
    before = np.zeros(orders.size)
    same = [one for one in baseline.envelopes if one.channel == envelope.channel]
    if not same:
        return before
    band = min(same, key=lambda one: abs(one.low_hz - envelope.low_hz) + abs(one.high_hz - envelope.high_hz))
    there = band.spectrum.frequency_hz / baseline.speed_hz
    for index in np.flatnonzero(wanted):
        margin = max(2 * float(there[1]), _SLIP * float(orders[index]))
        near = band.spectrum.amplitude[0, np.abs(there - orders[index]) <= margin]
        before[index] = float(near.max(initial=0.0))
    return before
