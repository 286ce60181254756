"""Whether a recording can be compared at all: its speed is known, its channels are alive, its samples are there."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ...datasets.recording import Recording
from ...simulators.errors import RotorwiseError
from ..observe import observe
from ..result import SpeedEstimate
from ..signal.checks import UNUSABLE, check_channel, check_tacho, repair
from ..signal.speed import NEAR_HINT, speed_from_tacho
from .channels import Matched

#: Below this confidence a speed that the vibration shows may as well be another line.
TRUSTED_SPEED = 0.8
#: The same near a speed that somebody states: few other lines lie there. And within a share of it that only one of
#: twenty chance lines near it would meet.
TRUSTED_NEAR_HINT, TRUSTED_AT_HINT, AT_HINT = 0.7, 0.5, 0.004
#: Change of speed within a record beyond which its lines are averages over different motions.
STEADY = 0.05
#: Defects of the data that are told one by one, and files that are named with one.
MOST_DOUBTS, MOST_FILES = 12, 3
#: Defects below this severity are no news; what lies at the end of the band does not touch the orders compared.
_WORTH_TELLING = 0.35


class UnfitRecordingError(RotorwiseError):
    """A recording that cannot be compared with a simulation."""


def fit(recording: Recording, matched: Matched) -> tuple[Recording, Matched, list[str]]:
    """Return the recording with missing samples filled in, its usable channels, and what is doubtful about it.

    Parameters
    ----------
    recording : Recording
    matched : Matched

    Raises
    ------
    UnfitRecordingError
        When no channel is usable, or the shaft's speed is not known: a wrong speed makes every line a wrong one.
    """
    name = Path(recording.provenance.path or "recording").name
    kept, left, doubts = dict(matched.probes), dict(matched.left), []
    signals = recording.signals.copy()
    for i in matched.probes:
        own = recording.channels[i].name
        found = check_channel(recording.signals[i], rate_hz=recording.rate_hz, name=own)
        spoiled = next((one for one in found if one.code in UNUSABLE), None)
        if spoiled is not None:
            left[own] = spoiled.message.removeprefix(f"{own}: ").rstrip(".")
            doubts.append(f"{name}: {spoiled.message}")
            del kept[i]
            continue
        signals[i] = repair(signals[i])
        doubts += [f"{name}: {one.message}" for one in found if one.severity >= _WORTH_TELLING]
        doubts += [f"{name}: {one.message} They are filled in." for one in found if one.code == "missing samples"]
    if not kept:
        raise UnfitRecordingError(f"{name}: no usable channel. {' '.join(one.split(': ', 1)[1] for one in doubts)}")
    ready = replace(recording, signals=signals)
    speed = _speed(ready, kept, name)
    doubts += _of_tacho(ready, name)
    if speed.variation > STEADY:
        doubts.append(f"{name}: the speed changes by {speed.variation:.0%}; its lines are averages. Record steadily.")
    return ready, Matched(kept, left), doubts


def _speed(recording: Recording, kept: dict[int, str], name: str) -> SpeedEstimate:
    for i, one in enumerate(recording.channels):
        pulses = recording.pulses_per_revolution
        found = one.quantity == "tacho" and speed_from_tacho(
            recording.signals[i], rate_hz=recording.rate_hz, pulses_per_revolution=pulses
        )
        if found:
            return found[0]
    try:
        speed = observe(recording.select(list(kept))).speed
    except RotorwiseError as problem:
        raise UnfitRecordingError(f"{name}: {problem}") from None
    stated, lacking = recording.condition.speed_rpm, _no_pulses(recording)
    if speed is None or speed.confidence < _needed(speed, stated):
        is_seen = speed is not None and speed.method != "hint only"
        guess = f" ({speed.speed_rpm:.1f} rpm with {speed.confidence:.0%} confidence)" if speed and is_seen else ""
        if stated:
            raise UnfitRecordingError(
                f"{name}: {lacking}, and the vibration does not surely show the shaft's speed near the "
                f"{stated:.0f} rpm that are stated{guess}; allowed: a line there with a confidence of "
                f"{TRUSTED_NEAR_HINT:.0%}, of {TRUSTED_AT_HINT:.0%} within {AT_HINT:.1%}. Name the tacho channel "
                "with --tacho, correct the speed, or leave the recording out."
            )
        raise UnfitRecordingError(
            f"{name}: {lacking}, and the vibration does not show the shaft's speed{guess}; allowed: a shaft that "
            "turns at a known speed. Name the tacho channel with --tacho, give the speed with --speed or in "
            "recording.toml, or leave the recording out."
        )
    return speed


def _of_tacho(recording: Recording, name: str) -> list[str]:
    """Return what was put right in the pulses, of one a turn, where that is worth telling."""
    if recording.pulses_per_revolution != 1:
        return []
    found = [
        one
        for channel, signal in zip(recording.channels, recording.signals, strict=True)
        if channel.quantity == "tacho"
        for one in check_tacho(repair(signal), rate_hz=recording.rate_hz, name=channel.name)
    ]
    return [f"{name}: {one.message}" for one in found if one.severity >= _WORTH_TELLING]


def _no_pulses(recording: Recording) -> str:
    """Return why no tacho tells the speed."""
    silent = [one.name for one in recording.channels if one.quantity == "tacho"]
    if not silent:
        return "no tacho"
    return f"tacho {', '.join(silent)} shows no pulses (the shaft stands still, or the pick-up is dead)"


def _needed(speed: SpeedEstimate, stated_rpm: float | None) -> float:
    """Return the confidence from which a speed that the vibration shows is taken."""
    if speed.method != NEAR_HINT:
        return TRUSTED_SPEED
    is_there = stated_rpm is not None and abs(speed.speed_rpm / stated_rpm - 1) < AT_HINT
    return TRUSTED_AT_HINT if is_there else TRUSTED_NEAR_HINT


def in_few_words(doubts: Sequence[str]) -> list[str]:
    """Return what is doubtful, texts "FILE: what"; what differs by file and numbers only is told of the first file."""
    alike: dict[str, list[str]] = {}
    for text in doubts:
        alike.setdefault(re.sub(r"\d[\d.]*", "", text.partition(": ")[2]), []).append(text)
    said = []
    for first, *more in alike.values():
        others = [text.partition(": ")[0] for text in more]
        named = ", ".join(others) if len(others) <= MOST_FILES else f"{len(others)} more recordings"
        said.append(f"{first} Alike in {named}." if others else first)
    rest = len(said) - MOST_DOUBTS
    return [*said[:MOST_DOUBTS], f"{rest} more defects of the data; analyse tells them."] if rest > 0 else said
