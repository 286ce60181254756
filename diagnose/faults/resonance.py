"""Suspicion of resonance: the strongest shaft line sits on a hump of the noise floor.

A lightly damped structure rings to the noise as well as to the shaft: its resonance is a hump in the floor, wider than
any line. A line on that hump is amplified by the structure. Only a run at another speed or a bump test can prove it.
Reference: D. J. Ewins, Modal Testing, 2nd ed. (2000), chapter 1.
"""

from __future__ import annotations

import numpy as np

from ..compare import comparable
from ..observe import Observation
from ..result import Finding

_ABNORMAL = {"A": 0.03, "B": 0.08, "C": 0.45, "D": 0.60, None: 0.20}
_LEAST_PROMINENCE_DB = 8.0
_HALF_WIDTH = 0.10
_LEAST_SHARE = 0.4
_HIGHEST_ORDER = 10


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return a suspicion when a dominant order line lies on a hump of the floor."""
    if now.speed is None or not now.turning:
        return []
    best: Finding | None = None
    for channel in range(now.channel_count):
        for hump_hz, prominence_db in humps(now, channel):
            order = round(hump_hz / now.speed_hz)
            if not 1 <= order <= _HIGHEST_ORDER or abs(order * now.speed_hz / hump_hz - 1) > _HALF_WIDTH:
                continue
            line = now.line(float(order), channel=channel)
            share = now.velocity_share(float(order), channel=channel)
            if share < _LEAST_SHARE or not now.is_significant(line):
                continue
            if baseline is not None and comparable(now, baseline) and not _is_new(now, baseline, channel, float(order)):
                continue
            probability = _ABNORMAL[now.zone] * share * min(1.0, prominence_db / 15)
            if best is None or probability > best.probability:
                best = Finding(
                    "resonance",
                    probability,
                    f"{order}X carries {share:.0%} of the velocity on {line.channel} and lies on a hump of the noise "
                    f"at {hump_hz:.0f} Hz, {prominence_db:.0f} dB above its surroundings.",
                    (line,),
                    "Change the speed by 10 % or do a bump test at rest: a resonance stays where it is.",
                    ("unbalance",),
                )
    return [] if best is None else [best]


def _is_new(now: Observation, baseline: Observation, channel: int, order: float) -> bool:
    """Return whether the line at least doubled: what the healthy machine lives with is no finding."""
    return now.line(order, channel=channel).amplitude > 2 * baseline.line(order, channel=channel).amplitude


def humps(now: Observation, channel: int) -> list[tuple[float, float]]:
    """Return frequency and prominence in dB of the humps of the floor between 0.5X and 12X."""
    frequency = now.spectrum.frequency_hz
    inside = (frequency > 0.5 * now.speed_hz) & (frequency < 12 * now.speed_hz)
    if inside.sum() < 16:
        return []
    level = 20 * np.log10(np.maximum(now.spectrum.floor[channel, inside], 1e-300))
    return [
        (float(frequency[inside][index]), high) for index, high in prominent_peaks(level, least=_LEAST_PROMINENCE_DB)
    ]


def prominent_peaks(level: np.ndarray, *, least: float) -> list[tuple[int, float]]:
    """Return index and prominence of the local maxima that stand out of their surroundings by at least ``least``.

    The prominence is the height over the higher of the two valleys that part a peak from higher ground. scipy.signal
    has the same; importing it costs more than the rest of an analysis.

    Examples
    --------
    >>> prominent_peaks(np.array([0.0, 3.0, 1.0, 5.0, 0.0]), least=1.0)
    [(1, 2.0), (3, 5.0)]
    """
    found = []
    for index in np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1:
        height = level[index]
        higher_left = np.flatnonzero(level[:index] > height)
        higher_right = np.flatnonzero(level[index + 1 :] > height)
        start = int(higher_left[-1]) if higher_left.size else 0
        stop = index + 1 + int(higher_right[0]) if higher_right.size else level.size
        prominence = float(height - max(level[start:index].min(), level[index + 1 : stop].min()))
        if prominence >= least:
            found.append((int(index), prominence))
    return found
