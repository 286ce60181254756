"""Channels that sway more slowly than their records can tell: no line, no drift, and no effect that competes makes it.

A load that swings once in two seconds moves a rotor by half of its 1X in records of a second, and no line of the
spectrum says so. That it moves at all is what has changed.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from ...datasets.recording import Recording
from .line_sizes import FEWEST_PERIODS, line_power
from .words import joined_words

#: Share of a record's deviation that sways, at least, and growth over the largest of the healthy records: as of trends.
LEAST, GROWTH = 0.05, 4.0


@dataclass(frozen=True)
class Sway:
    """A channel, its largest share of a record's deviation, growth over the healthy ones, and below which frequency."""

    channel: str
    share: float
    growth: float
    below_hz: float


def slow_sways(
    recordings: Sequence[Recording], healthy: Sequence[Recording], names: Collection[str]
) -> tuple[Sway, ...]:
    """Return the named channels that sway in half of the recordings, and so much in no healthy one."""
    if not healthy:
        return ()
    now = [_shares(one, names) for one in recordings]
    before = [_shares(one, names) for one in healthy]
    below_hz = max(FEWEST_PERIODS * one.rate_hz / one.samples for one in recordings)
    found = []
    for name in names:
        usual = max(own.get(name, 0.0) for own in before)
        shares = [own.get(name, 0.0) for own in now]
        if 2 * sum(one > max(GROWTH * usual, LEAST) for one in shares) >= len(shares):
            found.append(Sway(name, max(shares), max(shares) / max(usual, 1e-300), below_hz))
    return tuple(found)


def sway_words(found: Sequence[Sway]) -> tuple[str, ...]:
    """Return a remark on channels that sway; nothing without any."""
    if not found:
        return ()
    most, verb = max(found, key=lambda one: one.share), "sways" if len(found) == 1 else "sway"
    return (
        f"{joined_words([one.channel for one in found])} {verb} more slowly than these records can tell (below "
        f"{most.below_hz:.2g} Hz), by up to {most.share:.0%} of the deviation, {most.growth:.0f} times as much as when "
        "healthy: a load or a supply that swings, a drift to and fro. Record ten times as long to see its frequency.",
    )


def _shares(recording: Recording, names: Collection[str]) -> dict[str, float]:
    """Return of each channel the deviation of what is too slow for a line, over the whole deviation."""
    rows = [i for i, one in enumerate(recording.channels) if one.name in names]
    signals = np.nan_to_num(recording.signals[rows])
    power = line_power(signals - signals.mean(axis=1, keepdims=True))
    slow = power[:, 1 : int(FEWEST_PERIODS) + 1].sum(axis=1) / np.maximum(power[:, 1:].sum(axis=1), 1e-300)
    return {recording.channels[i].name: float(np.sqrt(own)) for i, own in zip(rows, slow, strict=True)}
