"""The measuring range of each probe, of which hum is a share: nobody states it, so it is taken from the recordings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...datasets.recording import Recording
from .lines import OrderLines

#: A line at a fixed frequency counts where it is so many deviations large.
CLEAR = 3.0


def probe_ranges(recordings: Sequence[Recording], *lines: OrderLines) -> np.ndarray:
    """Return the range of each probe, shape (probes,): at least the largest distance from its mean in any recording.

    How much of the supply each cable picks up is unknown. Where the recordings show lines at fixed frequencies, ranges
    are in the proportion of these, so that one share of the range tells the hum of all probes.

    Parameters
    ----------
    recordings : sequence of Recording
    *lines : OrderLines
        Of these recordings.
    """
    largest = np.max([_largest(one, lines[0].probes) for one in recordings], axis=0)
    return in_proportion(largest, *lines)


def in_proportion(largest: np.ndarray, *lines: OrderLines) -> np.ndarray:
    """Return ranges (probes,) in the proportion of the probes' lines at fixed frequencies, none below ``largest``.

    A probe that shows no such line clearly gets what makes the least of it.
    """
    places = zip(lines[0].orders, lines[0].kinds, strict=True)
    fixed = [i for i, (order, kind) in enumerate(places) if not (kind.phase or kind.envelope or order)]
    if not fixed:
        return largest
    sizes = np.concatenate([np.abs(one.amplitudes[:, :, fixed]) for one in lines])
    deviations = np.concatenate([one.deviations[:, :, fixed] for one in lines])
    seen = np.where(np.isfinite(deviations), sizes, 0.0)
    clear = (seen > CLEAR * np.where(np.isfinite(deviations), deviations, 0.0)).any(axis=(0, 2)) & (largest > 0)
    strongest = seen.max(axis=(0, 2))
    if not clear.any():
        return largest
    found = strongest / (strongest[clear] / largest[clear]).min()
    return np.where(clear, found, np.minimum(found, largest))


def _largest(recording: Recording, probes: Sequence[str]) -> np.ndarray:
    names = [channel.name for channel in recording.channels]
    signals = recording.signals[[names.index(name) for name in probes]]
    return np.abs(signals - signals.mean(axis=1, keepdims=True)).max(axis=1)
