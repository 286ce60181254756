"""Samples that a record has lost or cut off, put back from all its other turns.

Held and clipped samples change every line of a channel. Where most samples are left, the shaft's orders can be fitted
to those alone, by least squares with the lost ones left out, and say what the lost ones were. What else vibrates is
missing there, a share of it as small as the share lost.
"""

from __future__ import annotations

import math
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
#: What is cut off lies at the same angles in every turn, and orders that live there would be fitted to the noise beside
#: it: each is held back by this times its number to the fourth power, as lines fall off with their order.
RIDGE = 1e-5
#: Samples that are fitted at once: the angles of all their orders are held in memory.
PIECE = 1 << 18
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
    signals = recording.signals.copy()
    for row, one in zip(rows, lost, strict=True):
        pieces = np.array_split(np.arange(turns.size), math.ceil(turns.size / PIECE))
        fitted = np.concatenate([_of_orders(signals[row, part], one[part], turns[part]) for part in pieces])
        signals[row, one] = _beyond(signals[row], fitted)[one]
    return replace(recording, signals=signals)


def _of_orders(signal: np.ndarray, lost: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return what the shaft's orders, fitted to the samples that are not lost, make at all; shape (samples,)."""
    fast = (turns[-1] - turns[0]) / turns.size
    orders = ORDERS[ORDERS * fast < HIGHEST_SHARE]
    angles = 2 * np.pi * np.outer(turns, orders)
    columns = np.concatenate([np.ones((turns.size, 1)), np.cos(angles), np.sin(angles)], axis=1)
    kept, known = columns[~lost], signal[~lost]
    held_back = RIDGE * np.concatenate([[0.0], np.tile(np.maximum(orders, 1.0) ** 4, 2)])
    # Where a piece has lost everything nothing is known: 0.
    law = np.linalg.solve(kept.T @ kept + (known.size + 1) * np.diag(held_back + 1e-12), kept.T @ known)
    return columns @ law


def _beyond(signal: np.ndarray, fitted: np.ndarray) -> np.ndarray:
    """Return fitted samples; where the record is cut off, none that lie within what was recorded."""
    low, high = _ends(signal)
    fitted = np.where(signal >= high, np.maximum(fitted, signal), fitted)
    return np.where(signal <= low, np.minimum(fitted, signal), fitted)


def _ends(signal: np.ndarray) -> tuple[float, float]:
    """Return below and above what a sample lies at an end of the range."""
    low, high = float(np.nanmin(signal)), float(np.nanmax(signal))
    near = AT_THE_END * (high - low)
    return low + near, high - near


def lost_samples(signal: np.ndarray) -> np.ndarray:
    """Return which samples are missing, held at the last value, or cut off at an end of the range; shape (samples,).

    Examples
    --------
    >>> lost_samples(np.array([0.1, 0.7, 0.7, 0.7, 0.2, 1.0, 1.0, 0.0])).tolist()
    [False, False, True, True, False, True, True, False]
    """
    lost = ~np.isfinite(signal)
    if lost.all():
        return lost
    same = np.concatenate([[False], signal[1:] == signal[:-1]])
    low, high = _ends(signal)
    for outermost in (signal <= low, signal >= high):
        # One sample is the largest in every record.
        if np.count_nonzero(outermost & same):
            lost |= outermost
    return lost | same
