"""Samples that a record has lost or cut off, put back from all its other turns.

Held and clipped samples change every line of a channel. Where most samples are left, the shaft's orders can be fitted
to those alone, by least squares with the lost ones left out, and say what the lost ones were. What else vibrates is
missing there, a share of it as small as the share lost.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

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
#: it: an order is expected to be no larger than the signal's deviation over its number to this power.
FALL_OFF = 2.0
#: Steps of Newton's method at most, and the change, in deviations of the noise, after which no further one is made.
MOST_STEPS, SMALL = 20, 0.02
#: The noise is taken to be at least this share of the signal's deviation.
LEAST_NOISE = 1e-6
#: What says so little counts as this much of a sample, so that no step divides by nothing.
LEAST_WEIGHT = 1e-6
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
        known = _Known(_ends(signals[row]), float(signals[row, ~one].mean()), float(signals[row, ~one].std()))
        signals[row] = np.concatenate([_filled(signals[row, part], one[part], turns[part], known) for part in pieces])
    return replace(recording, signals=signals)


@dataclass(frozen=True)
class _Known:
    """What is known of a signal: where it is cut off, and of its samples within that, the mean and the deviation."""

    ends: tuple[float, float]
    mean: float
    deviation: float


def _filled(signal: np.ndarray, lost: np.ndarray, turns: np.ndarray, known: _Known) -> np.ndarray:
    """Return a signal with its lost samples replaced by what the shaft's orders, fitted to the others, let expect.

    Of a sample that is cut off it is known that it lay beyond the end of the range. Without that the orders would be
    too small: beside what is cut off, noise decides what is left. So they are found by the censored regression of
    J. Tobin (Econometrica 26 (1958) 24), by Newton's method.
    """
    if lost.all():
        return np.full(signal.size, known.mean)
    columns, smallness = _columns(turns, known.deviation)
    side = (lost & (signal >= known.ends[1])).astype(float) - (lost & (signal <= known.ends[0]))
    cut, limit = side != 0, np.where(side > 0, *known.ends[::-1]) - known.mean
    left, wanted = columns[~lost], signal[~lost] - known.mean
    gram, moment = left.T @ left, left.T @ wanted
    outside, side, limit = columns[cut], side[cut], limit[cut]
    law, noise = np.zeros(columns.shape[1]), 0.0
    weight, target = np.zeros(side.size), np.zeros(side.size)
    beyond = np.zeros(side.size)
    for _ in range(MOST_STEPS):
        precision = gram + (outside.T * weight) @ outside + np.diag((noise * smallness) ** 2 + 1e-12 * signal.size)
        before, law = law, np.linalg.solve(precision, moment + outside.T @ (weight * target))
        noise = float(np.std(wanted - left @ law)) + LEAST_NOISE * known.deviation
        there = outside @ law
        depth = side * (there - limit) / noise
        mean = _mean_beyond(depth)
        weight = np.clip(mean * (depth + mean), LEAST_WEIGHT, 1.0)
        beyond = side * noise * mean
        target = there + beyond / weight
        if np.abs(columns @ (law - before)).max() < SMALL * noise:
            break
    filled = signal.copy()
    filled[lost] = columns[lost] @ law + known.mean
    filled[cut] += beyond
    return filled


def _mean_beyond(depth: np.ndarray) -> np.ndarray:
    """Return by how many deviations the mean of a normal value that is known to be positive lies above its own.

    ``depth`` is its own mean in deviations.
    """
    from scipy.special import erfcx

    return math.sqrt(2 / math.pi) / erfcx(-depth / math.sqrt(2))


def _columns(turns: np.ndarray, deviation: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean and the waves of the orders (samples, columns), and how small each is expected to be (columns,).

    Smallness is one over the expected deviation of a column's amplitude.
    """
    fast = (turns[-1] - turns[0]) / turns.size
    orders = ORDERS[ORDERS * fast < HIGHEST_SHARE]
    angles = 2 * np.pi * np.outer(turns, orders)
    columns = np.concatenate([np.ones((turns.size, 1)), np.cos(angles), np.sin(angles)], axis=1)
    return columns, np.concatenate([[0.0], np.tile(np.maximum(orders, 1.0) ** FALL_OFF, 2)]) / max(deviation, 1e-300)


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
