"""Which envelopes of an observation may speak of impacts on a bearing: quantity, level, other directions."""

from __future__ import annotations

import numpy as np

from ..datasets.recording import Channel
from .observe import Observation
from .signal.envelope import EnvelopeSpectrum

_WEAK = 0.1  # of the strongest direction at the same place, in the same band


def speaking(now: Observation) -> list[EnvelopeSpectrum]:
    """Return the envelopes in which impacts on a race would show.

    Displacement falls with the square of frequency, velocity with frequency: where a resonance rings they hold next to
    nothing, and what modulates that little is the changing stiffness of sound bearings. They count only where nothing
    that shows more of it was measured.
    So it is with a direction that moves by a small part of another one at the same place: balls that pass under a
    load throw a little of it sideways, which is modulated wholly, while impacts shake every direction.
    """
    channels = now.recording.channels
    best = min((_rank(channels[one.channel]) for one in now.envelopes), default=0)
    heard = [one for one in now.envelopes if _rank(channels[one.channel]) == best]
    loudest: dict[tuple[object, ...], float] = {}
    for one in heard:
        loudest[_band(now, one)] = max(loudest.get(_band(now, one), 0.0), one.mean)
    return [one for one in heard if one.mean >= _WEAK * loudest[_band(now, one)]]


def _rank(channel: Channel) -> int:
    """Return 0 for acceleration and what may be, 1 for velocity, 2 for displacement."""
    return {"velocity": 1, "displacement": 2}.get(channel.quantity or "", 0)


def _band(now: Observation, one: EnvelopeSpectrum) -> tuple[object, ...]:
    """Return what envelopes that can be compared have in common; a channel without a place stands alone."""
    about = now.recording.channels[one.channel]
    return about.location or one.channel, about.quantity, one.low_hz, one.high_hz


def other_directions(now: Observation, one: EnvelopeSpectrum) -> list[EnvelopeSpectrum]:
    """Return the envelopes of the same quantity at the same place in other directions; none without a place."""
    channels = now.recording.channels
    own = channels[one.channel]
    if own.location is None:
        return []
    beside = [
        index
        for index, channel in enumerate(channels)
        if index != one.channel and (channel.location, channel.quantity) == (own.location, own.quantity)
    ]
    return [other for other in now.envelopes if other.channel in beside]


def mesh_lines(now: Observation, envelope: EnvelopeSpectrum) -> np.ndarray:
    """Return the frequencies of the tooth-mesh harmonics in a band or one mesh order outside it."""
    found: list[float] = []
    for gear in now.recording.nameplate.gears:
        mesh = gear.mesh_order * now.speed_hz
        first, last = max(int(envelope.low_hz / mesh), 1), int(envelope.high_hz / mesh) + 1
        found += [harmonic * mesh for harmonic in range(first, last + 1)]
    return np.array(found)
