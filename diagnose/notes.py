"""What the user must know beside the findings: data quality, doubts about the speed, what nothing explains."""

from __future__ import annotations

import numpy as np

from .compare import comparable, floor_change_db, path_changed
from .faults.bearing import defect_odds, shaft_ratios
from .faults.gear import attributions
from .observe import Observation
from .result import Finding

#: What to say of a record in which no line can be named, by its state.
NO_ROTATION = {
    "at rest": "The machine is not turning: no line stands out of the sensor noise.",
    "varying speed": "The speed changes so much within the record that no line stands still. Record a tacho too, or "
    "take a steady stretch.",
    "no rotation seen": "No rotation is visible: the machine is not turning, or its lines drown in noise.",
    "no sensor": "No usable vibration channel.",
}
_SHORT_TURNS = 20
_RISE_DB = 6.0
_NOMINAL_ERROR = 0.02


def notes(now: Observation, baseline: Observation | None) -> tuple[str, ...]:
    """Return the warnings of one block, most important first."""
    found = [check.message for check in now.checks if check.severity > 0]
    if not now.turning:
        return (*found, NO_ROTATION[now.state] + _level(now))
    found += _speed_doubts(now)
    if baseline is not None:
        found += _baseline_doubts(now, baseline)
    return tuple(found)


def unexplained(now: Observation, baseline: Observation | None, findings: tuple[Finding, ...]) -> tuple[str, ...]:
    """Return what is clearly there and no fault of the catalogue accounts for."""
    if not now.turning:
        return ()
    found = [] if baseline is None else _unexplained_change(now, baseline, findings)
    if not now.recording.nameplate.bearings:
        found += _unknown_rhythm(now)
    return tuple(found)


def remarks(now: Observation) -> tuple[str, ...]:
    """Return what is worth knowing of one block beside findings and warnings."""
    return (*attributions(now), *(check.message for check in now.checks if check.severity == 0))


def _level(now: Observation) -> str:
    if not now.channel_count:
        return ""
    rms = np.sqrt((now.recording.signals**2).mean(axis=1))
    loudest = int(np.argmax(rms))
    channel = now.recording.channels[loudest]
    return f" Level: {rms[loudest]:.3g} {channel.unit or '(unit unknown)'} rms on {channel.name}."


def _speed_doubts(now: Observation) -> list[str]:
    speed = now.speed
    if speed is None:
        return ["No shaft speed found: lines cannot be named. Pass --speed."]
    found = []
    hint = now.recording.condition.speed_rpm
    if speed.method == "hint only":
        found.append(f"The vibration does not show the speed; the given {speed.speed_rpm:.0f} rpm is used unchecked.")
    elif speed.confidence < 0.8:
        found.append(
            f"Speed {speed.speed_rpm:.1f} rpm is uncertain (confidence {speed.confidence:.0%}). "
            "Pass --speed to be sure."
        )
    if hint and abs(speed.speed_rpm / hint - 1) > _NOMINAL_ERROR:
        found.append(
            f"Speed found {speed.speed_rpm:.1f} rpm, {speed.speed_rpm / hint - 1:+.1%} off the given {hint:.0f} rpm."
        )
    if speed.variation > 0.01:
        found.append(f"The speed varies by {speed.variation:.1%} within the record.")
    turns = now.recording.samples / now.recording.rate_hz * speed.speed_hz
    if turns < _SHORT_TURNS:
        found.append(f"Short record: {turns:.0f} turns. Lines closer than {2 / turns:.2f}X cannot be separated.")
    return found


def _baseline_doubts(now: Observation, baseline: Observation) -> list[str]:
    if not comparable(now, baseline):
        return [
            "The baseline has another speed (over 5 %), an unconfirmed one, or other channels: "
            "its lines are not compared."
        ]
    changed = path_changed(now, baseline)
    if not changed:
        return []
    return [
        f"The path from the machine to the sensor changed on {', '.join(changed)}: noise fell in one band and rose in "
        "another. Re-mounted sensor or re-assembled machine? Moderate changes of lines mean little then."
    ]


def _unexplained_change(now: Observation, baseline: Observation, findings: tuple[Finding, ...]) -> list[str]:
    """Say so when the noise rose broadly and no finding accounts for it."""
    if not comparable(now, baseline) or any(one.probability > 0.5 for one in findings):
        return []
    centres, change = floor_change_db(now, baseline)
    rises = np.median(change, axis=0)
    high = np.flatnonzero(rises > _RISE_DB)
    if not high.size:
        return []
    worst = int(high[np.argmax(rises[high])])
    return [
        f"The noise rose by {rises[worst]:.0f} dB round {centres[worst]:.0f} Hz (median of the channels) "
        "and no fault of the catalogue accounts for it."
    ]


def _unknown_rhythm(now: Observation) -> list[str]:
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
