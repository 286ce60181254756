"""Effects that the waveform itself shows, whatever the machine does: clipping, gaps, drift, coarse steps, folded lines.

These are found by the data checks before any line is compared. A channel that shows one counts for less afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...datasets.recording import Recording
from ..signal.checks import check_channel
from ..signal.speed import speed_from_tacho
from .lines import OrderLines

#: The effect of the catalogue that each data check shows.
SHOWN_BY = {
    "clipping": "clipping",
    "dropouts": "dropped_samples",
    "missing samples": "dropped_samples",
    "mostly missing": "dropped_samples",
    "drift": "dc_drift",
    "offset": "dc_drift",
    "coarse": "quantisation",
    "aliasing": "aliasing",
}
#: Only the waveform shows these; order lines do not, or only so little that other effects explain it as well.
ONLY_IN_WAVEFORM = frozenset((*SHOWN_BY.values(), "clock_error", "speed_wander"))
#: Relative error of the lines of a channel that shows a defect.
DOUBT = 0.2
#: Change of speed within a record, by its tacho, that counts as wander, and growth over the healthy records.
WANDER, WANDER_GROWTH = 0.002, 3.0


def seen_in_waveform(
    recordings: Sequence[Recording], healthy: Sequence[Recording], channels: Sequence[str]
) -> dict[str, tuple[str, ...]]:
    """Return the channels that show each effect in at least half of the recordings, and in no healthy one."""
    found: dict[str, list[str]] = {}
    for name in channels:
        before = set().union(*(_codes(one, name) for one in healthy)) if healthy else set()
        counts: dict[str, int] = {}
        for one in recordings:
            for code in {SHOWN_BY[code] for code in _codes(one, name) if code in SHOWN_BY and code not in before}:
                counts[code] = counts.get(code, 0) + 1
        for effect, count in counts.items():
            if 2 * count >= len(recordings):
                found.setdefault(effect, []).append(name)
    usual = max((_variation(one) for one in healthy), default=0.0)
    wandering = [_variation(one) for one in recordings]
    if np.median(wandering) > max(WANDER, WANDER_GROWTH * usual):
        found["speed_wander"] = []
    return {effect: tuple(names) for effect, names in found.items()}


def with_doubt(lines: OrderLines, seen: dict[str, tuple[str, ...]]) -> OrderLines:
    """Return the lines, less certain at the probes whose waveform shows a defect."""
    doubtful = [probe in {name for names in seen.values() for name in names} for probe in lines.probes]
    share = np.where(doubtful, DOUBT, 0.0)[None, :, None]
    return replace(lines, deviations=np.hypot(lines.deviations, share * np.abs(lines.amplitudes)))


def _codes(recording: Recording, name: str) -> set[str]:
    row = [channel.name for channel in recording.channels].index(name)
    return {check.code for check in check_channel(recording.signals[row], rate_hz=recording.rate_hz, name=name)}


def _variation(recording: Recording) -> float:
    """Return the relative variation of the speed within a record, 0 without a tacho."""
    for index, channel in enumerate(recording.channels):
        if channel.quantity == "tacho":
            found = speed_from_tacho(
                recording.signals[index],
                rate_hz=recording.rate_hz,
                pulses_per_revolution=recording.pulses_per_revolution,
            )
            if found is not None:
                return found[0].variation
    return 0.0
