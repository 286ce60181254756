"""Records whose spectrum between the lines lies far above the healthy machine's: what moves there does not repeat.

A contact that bounces, a rotor that whips: the lines of such a record scatter by as much as they are, so that they say
nothing against any model. That they scatter is what has changed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...datasets.recording import Recording
from .line_sizes import line_power
from .words import joined_words

#: Orders between which the floor of the spectrum is its median: those of the lines that are compared.
FLOOR_ORDERS = 0.2, 6.5
#: So much louder than each of so many healthy records that are nearest in speed, within this factor, is no scatter of
#: noise from day to day.
LOUDER_DB, NEAREST, ALIKE = 20.0, 2, 1.5


@dataclass(frozen=True)
class Unsteady:
    """A speed, the channels that do not repeat there, and by how much the loudest lies above the healthy records."""

    speed_rpm: float
    channels: tuple[str, ...]
    louder_db: float


def unsteady(
    recordings: Sequence[Recording],
    speeds_rpm: Sequence[float],
    healthy: Sequence[Recording],
    healthy_rpm: Sequence[float],
    names: Sequence[str],
) -> tuple[Unsteady, ...]:
    """Return the records that do not repeat as the healthy machine does; none without healthy ones near in speed.

    ``names`` are those of the channels that are looked at.
    """
    before = [(speed, _floors(one, speed, names)) for one, speed in zip(healthy, healthy_rpm, strict=True)]
    found = []
    for one, speed in zip(recordings, speeds_rpm, strict=True):
        near = sorted((abs(math.log(own / speed)), number) for number, (own, _) in enumerate(before))
        floors = [before[number][1] for away, number in near[:NEAREST] if away < math.log(ALIKE)]
        now = _floors(one, speed, names)
        louder = {
            name: 10 * math.log10(own / most)
            for name, own in now.items()
            if own > 0 and (most := max((of.get(name, 0.0) for of in floors), default=0.0)) > 0
        }
        channels = tuple(name for name, by in louder.items() if by > LOUDER_DB)
        if channels:
            found.append(Unsteady(speed, channels, max(louder.values())))
    return tuple(found)


def channels_of(found: Sequence[Unsteady], flaws: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Return the channels that do not repeat, but those with a flaw of the recorder; one without channels is of all."""
    if not all(flaws.values()):
        return ()
    every = dict.fromkeys(name for one in found for name in one.channels)
    return tuple(name for name in every if not any(name in own for own in flaws.values()))


def unsteady_words(found: Sequence[Unsteady]) -> tuple[str, ...]:
    """Return a remark on records that do not repeat; nothing without any."""
    if not found:
        return ()
    speeds = joined_words([f"{one.speed_rpm:.0f}" for one in found])
    channels = joined_words(list(dict.fromkeys(name for one in found for name in one.channels)))
    most = max(one.louder_db for one in found)
    return (
        f"At {speeds} rpm the spectrum between the lines of {channels} lies up to {most:.0f} "
        "dB above the healthy records that are nearest in speed: the motion does not repeat there (a contact that "
        "bounces, a rotor that whips), or it is noise from elsewhere. The lines of such a record say little.",
    )


def _floors(recording: Recording, speed_rpm: float, names: Sequence[str]) -> dict[str, float]:
    """Return the power density between the lines of the named channels."""
    rows = [i for i, one in enumerate(recording.channels) if one.name in names]
    signals = np.nan_to_num(recording.signals[rows])
    power = line_power(signals - signals.mean(axis=1, keepdims=True))
    seconds = recording.samples / recording.rate_hz
    low, high = (round(order * speed_rpm / 60 * seconds) for order in FLOOR_ORDERS)
    low = min(low, power.shape[1] - 1)
    density = np.median(power[:, low : max(high, low + 1)], axis=1) * seconds
    return {recording.channels[i].name: float(own) for i, own in zip(rows, density, strict=True)}
