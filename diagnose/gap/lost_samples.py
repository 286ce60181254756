"""Samples that a record has lost or cut off, put back from all its other turns.

Held and clipped samples change every line of a channel. Where most samples are left, the shaft's orders can be fitted
to those alone, by least squares with the lost ones left out, and say what the lost ones were. What else vibrates is
missing there, a share of it as small as the share lost.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from ...datasets.recording import Recording
from .observe import HIGHEST_SHARE, turns_of

#: Orders that are fitted, as far as the sampling rate lets them be seen.
ORDERS = np.arange(0.5, 12.5, 0.5)
#: Where more than this share is lost, the rest does not say what it was.
MOST_LOST = 0.3
#: Samples so near an end of the range, as a share of it, are cut off.
AT_THE_END = 1e-3
#: Power of the noise over that of the lines, about: what is cut off lies at the same angles in every turn, and orders
#: that live there would be fitted to the noise beside it.
RIDGE = 1e-3
#: Share of what the mending changed a line by that may still be wrong with it.
LEFT = 0.3


def mended(recordings: Sequence[Recording], channels: Collection[str]) -> tuple[Recording, ...] | None:
    """Return the recordings with the lost samples of some channels put back; None where too many are lost.

    Parameters
    ----------
    recordings : sequence of Recording
        At steady speed, each with its shaft's angle from the tacho, or found from its lines.
    channels : collection of str
    """
    found = [_mended(one, channels) for one in recordings]
    kept = [one for one in found if one is not None]
    return tuple(kept) if len(kept) == len(found) else None


def _mended(recording: Recording, channels: Collection[str]) -> Recording | None:
    rows = [row for row, channel in enumerate(recording.channels) if channel.name in channels]
    lost = [lost_samples(recording.signals[row]) for row in rows]
    if any(one.mean() > MOST_LOST for one in lost):
        return None
    measured = [row for row, channel in enumerate(recording.channels) if channel.quantity != "tacho"]
    turns = turns_of(recording, np.nan_to_num(recording.signals[measured]))
    fast = (turns[-1] - turns[0]) / turns.size
    orders = ORDERS[ORDERS * fast < HIGHEST_SHARE]
    angles = 2 * np.pi * np.outer(turns, orders)
    columns = np.concatenate([np.ones((turns.size, 1)), np.cos(angles), np.sin(angles)], axis=1)
    signals = recording.signals.copy()
    for row, one in zip(rows, lost, strict=True):
        kept = columns[~one]
        held_back = RIDGE * kept.shape[0] * np.eye(kept.shape[1])
        law = np.linalg.solve(kept.T @ kept + held_back, kept.T @ recording.signals[row][~one])
        signals[row, one] = columns[one] @ law
    return replace(recording, signals=signals)


def lost_samples(signal: np.ndarray) -> np.ndarray:
    """Return which samples are missing, held at the last value, or cut off at an end of the range; shape (samples,).

    Examples
    --------
    >>> lost_samples(np.array([0.1, 0.7, 0.7, 0.7, 0.2, 1.0, 1.0, 0.0])).tolist()
    [False, False, True, True, False, True, True, False]
    """
    lost = ~np.isfinite(signal)
    same = np.concatenate([[False], signal[1:] == signal[:-1]])
    ends = np.nanmin(signal), np.nanmax(signal)
    near = AT_THE_END * (ends[1] - ends[0])
    for end in ends:
        outermost = np.abs(signal - end) <= near
        # One sample is the largest in every record.
        if np.count_nonzero(outermost & same):
            lost |= outermost
    return lost | same
