"""How much noise the recordings hold in the band whose envelope is looked at: a simulation has none of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...datasets.recording import Recording
from .line_sizes import envelope_noise
from .lines import OrderLines


def noise_of_records(lines: OrderLines, recordings: Sequence[Recording]) -> np.ndarray:
    """Return the noise in the band of the envelope in SI units, shape (conditions, probes).

    Parameters
    ----------
    lines : OrderLines
        Of the recordings.
    recordings : sequence of Recording
    """
    found = []
    for one, condition in zip(recordings, lines.conditions, strict=True):
        names = [channel.name for channel in one.channels]
        signals = one.signals[[names.index(probe) for probe in lines.probes]]
        found.append(envelope_noise(signals, rate_hz=one.rate_hz, speed_hz=condition.speed_rpm / 60))
    return np.stack(found)


def not_of_the_fault(noise: np.ndarray, lines: OrderLines, usual: np.ndarray, healthy: OrderLines) -> np.ndarray:
    """Return the noise, or that of the healthy record at the nearest speed where it is less, (conditions, probes).

    What a bearing's defect rings at random is no noise.
    """
    speeds = np.array([condition.speed_rpm for condition in healthy.conditions])
    nearest = [int(np.argmin(np.abs(speeds - condition.speed_rpm))) for condition in lines.conditions]
    return np.minimum(noise, usual[nearest])
