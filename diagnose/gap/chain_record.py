"""What a measuring chain leaves of a motion, sampled no faster than what it adds asks for.

A chain that only mixes channels and adds lines of low frequency (hum) does so at any sampling rate. A motion that
repeats with the shaft is known at any instant, so that a record at 25.6 kHz need not be made to see a line at 50 Hz.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...simulators.assembly import Probe
from ...simulators.machine import Machine
from ...simulators.sensor_record import SensorRecord
from ...simulators.sensor_run import record_of_signals, run_chain, sensor_effects
from .line_sizes import FLOOR_WIDTHS, HIGHEST_SHARE, LEAST_BINS, WANDER, envelope_band


def chained(
    machine: Machine,
    channels: tuple[Probe, ...],
    signals: np.ndarray,
    phase_rad: np.ndarray,
    *,
    speed_rad_s: float,
    rate_hz: float,
    full_scale: np.ndarray | None,
) -> SensorRecord:
    """Return the record that the machine's chain makes of signals (channels, samples) at a steady speed.

    ``full_scale`` (channels,) is the measuring range; that of each motion when not given.
    """
    how = {"phase_rad": phase_rad, "speed_rad_s": np.full(phase_rad.size, speed_rad_s)}
    record = record_of_signals(signals, machine, channels, rate_hz=rate_hz, output_rate_hz=rate_hz, **how)
    if full_scale is not None:
        record = replace(record, full_scale=full_scale)
    return run_chain(record, sensor_effects(machine), samples=phase_rad.size, seed=0)


def rate_enough(
    machine: Machine,
    channels: Sequence[Probe],
    *,
    speed_rad_s: float,
    highest_order: float,
    least_s: float,
    rate_hz: float,
) -> float:
    """Return the rate (Hz) at which a record of a repeating motion shows the same lines as at ``rate_hz``.

    Parameters
    ----------
    machine : Machine
        Whose chain it passes.
    channels : sequence of Probe
    speed_rad_s, highest_order : float
        Of the motion.
    least_s : float
        Length of the record.
    rate_hz : float
        Of the recording.
    """
    added = [0.0 if one.mixing(channels) is not None else one.adds_up_to_hz for one in sensor_effects(machine)]
    tops = [top for top in added if top is not None]
    speed_hz = speed_rad_s / (2 * math.pi)
    content = max([*tops, highest_order * speed_hz])
    # What reaches the envelope's band depends on where that lies, and it follows the rate.
    if len(tops) < len(added) or content >= envelope_band(rate_hz, speed_hz)[0]:
        return rate_hz
    # Of lines above there is nothing, and at a rate that is too low for them none is seen.
    return min(rate_hz, (content + FLOOR_WIDTHS * max(WANDER * content, LEAST_BINS / least_s)) / HIGHEST_SHARE)
