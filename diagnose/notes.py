"""What the user must know beside the findings: data quality, doubts about the speed and the baseline."""

from __future__ import annotations

import numpy as np

from .compare import comparable, path_changed
from .faults.gear import attributions
from .observe import Observation

#: What to say of a record in which no line can be named, by its state.
NO_ROTATION = {
    "at rest": "The machine is not turning: no line stands out of the sensor noise.",
    "varying speed": "The speed changes so much within the record that no line stands still. Record a tacho too, or "
    "take a steady stretch.",
    "no rotation seen": "No rotation is visible: the machine is not turning, or its lines drown in noise.",
    "no sensor": "No usable vibration channel.",
}
_SHORT_TURNS = 20
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
