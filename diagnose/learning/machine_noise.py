"""What the simulated benches lack and sound machines have: coloured, faintly modulated noise and lines of their own.

A classifier that never saw a sound machine rattle takes every rattle for a fault. Each machine draw therefore gets

- broad-band noise that rings a few resonances, other ones on each channel (transfer path and colour);
- its modulation by the shaft, the cage and the passing balls, as in a sound loaded bearing (variable compliance; R. B.
  Randall and J. Antoni, Mech. Syst. Signal Process. 25 (2011) 485-520), by one rhythm of something else, and slowly;
- lines at whole orders of the shaft (coupling, motor, fan), and one of the electric supply.

Faulty and sound records of a machine have the same, apart from small changes from record to record, so that none of it
says anything of the fault. All sizes are estimates for machines of this size, drawn widely; nothing is fitted to a
measured machine.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...datasets.recording import Recording

#: rms of the broad-band noise in m/s2, from a quiet bench to a rough pump.
NOISE_RMS_M_S2 = (0.01, 5.0)
#: Depth with which each rhythm modulates the noise: a normal number of this standard deviation without its sign. Twice
#: that is the depth at which the rules give even odds for a defect (`faults/bearing.py`); "other" is any order.
DEPTH = {"1X": 0.2, "2X": 0.2, "cage": 0.2, "outer": 0.2, "inner": 0.2, "ball": 0.2, "other": 0.2}
OTHER_ORDERS = (0.3, 12.0)
#: Amplitude of the largest line over the noise's rms, and the highest order that has one.
LINE_OVER_NOISE = (0.01, 1.0)
HIGHEST_ORDER = 12
#: From record to record of one machine: standard deviation of levels in the logarithm (about 1.5 dB).
CHANGE = 0.17
#: Standard deviation of slow changes of the noise's level within a record, in the logarithm.
SLOW_SPREAD = (0.0, 0.3)


@dataclass(frozen=True)
class MachineNoise:
    """What is added to simulated records.

    Parameters
    ----------
    seed : int
    broadband, modulated, lines : bool
        Parts that can be left out, to see what each is worth.
    """

    seed: int
    broadband: bool = True
    modulated: bool = True
    lines: bool = True


def with_machine_noise(recording: Recording, row: Mapping[str, Any], noise: MachineNoise) -> Recording:
    """Return a simulated recording with the noise of its machine.

    Parameters
    ----------
    recording : Recording
        Channels in m/s2; others stay as they are.
    row : mapping
        The dataset's row: machine, group, seed and true speed.
    noise : MachineNoise
    """
    own = zlib.crc32(f"{row['machine']} {row['group']}".encode())
    machine = np.random.default_rng([noise.seed, own])
    record = np.random.default_rng([noise.seed, own, int(row["seed"])])
    turns = np.arange(recording.samples) * (row["speed_rpm"] / 60 / recording.rate_hz) + record.uniform()
    rms = math.exp(machine.uniform(*np.log(NOISE_RMS_M_S2)) + record.normal(0.0, CHANGE))
    modulation = _modulation(recording, turns, machine, record)
    signals = recording.signals.copy()
    for index, channel in enumerate(recording.channels):
        # Every channel draws the same count of numbers, whichever parts are wanted.
        share = math.exp(machine.normal(0.0, 0.5))
        colour = _coloured(recording.samples, recording.rate_hz, machine, record)
        comb = _lines(turns, recording, machine, record)
        if channel.quantity != "acceleration":
            continue
        if noise.broadband:
            signals[index] += rms * share * colour * (modulation if noise.modulated else 1.0)
        if noise.lines:
            signals[index] += rms * share * comb
    return replace(recording, signals=signals)


def _coloured(samples: int, rate_hz: float, machine: np.random.Generator, record: np.random.Generator) -> np.ndarray:
    """Return noise of rms 1 with a slope and a few resonances, shape (samples,)."""
    frequency = np.fft.rfftfreq(samples, 1 / rate_hz)
    height = np.maximum(frequency, 10.0) ** machine.uniform(-0.5, 0.5)
    # Resonances lie where they lie, whatever the sampling rate.
    for _ in range(4):
        place, damping = math.exp(machine.uniform(*np.log((200.0, 15000.0)))), machine.uniform(0.02, 0.15)
        gain = math.exp(machine.normal(0.0, 1.0))
        ratio = frequency / place
        height = height * (1 + gain / np.sqrt((1 - ratio**2) ** 2 + (2 * damping * ratio) ** 2) / 10)
    spectrum = np.fft.rfft(record.normal(size=samples)) * height
    spectrum[0] = 0.0
    noise = np.fft.irfft(spectrum, samples)
    return noise / max(float(noise.std()), 1e-300)


def _modulation(
    recording: Recording, turns: np.ndarray, machine: np.random.Generator, record: np.random.Generator
) -> np.ndarray:
    """Return the factor of the noise over time, mean about 1, shape (samples,)."""
    orders = {"1X": 1.0, "2X": 2.0, "other": machine.uniform(*OTHER_ORDERS)}
    for bearing in recording.nameplate.bearings[:1]:
        one, slip = bearing.geometry.defect_orders(), 1.0 - machine.uniform(0.0, 0.02)
        orders |= {"cage": one.cage * slip, "outer": one.outer_race * slip}
        orders |= {"inner": one.inner_race * (2 - slip), "ball": 2 * one.ball_spin * slip}
    factor = np.ones(turns.size)
    for name, deviation in DEPTH.items():
        depth = abs(machine.normal(0.0, deviation)) * math.exp(record.normal(0.0, CHANGE))
        phase = record.uniform(0.0, 2 * math.pi)
        if name in orders:
            factor += min(depth, 0.5) * np.cos(2 * np.pi * orders[name] * turns + phase)
    spread = machine.uniform(*SLOW_SPREAD)
    knots = record.normal(0.0, 1.0, 4 + round(recording.duration_s * 8))
    slow = np.interp(np.linspace(0, knots.size - 1, turns.size), np.arange(knots.size), knots)
    return np.maximum(factor, 0.0) * np.exp(spread * slow)


def _lines(
    turns: np.ndarray, recording: Recording, machine: np.random.Generator, record: np.random.Generator
) -> np.ndarray:
    """Return a comb of whole orders that falls off as it may, and a line of the supply, over an rms of 1."""
    largest = math.exp(machine.uniform(*np.log(LINE_OVER_NOISE)))
    fall = machine.uniform(0.0, 0.4)
    sizes = largest * np.exp(machine.normal(0.0, 1.0, HIGHEST_ORDER) - fall * np.arange(HIGHEST_ORDER))
    phases = machine.uniform(0.0, 2 * math.pi, HIGHEST_ORDER)
    sizes = sizes * np.exp(record.normal(0.0, CHANGE, HIGHEST_ORDER))
    comb = np.zeros(turns.size)
    highest = 0.45 / (turns[1] - turns[0])
    for number, (size, phase) in enumerate(zip(sizes, phases, strict=True), start=1):
        if number < highest:
            comb += size * np.cos(2 * np.pi * number * turns + phase)
    supply = machine.choice([50.0, 60.0]) * machine.integers(1, 3)
    size = math.exp(machine.uniform(*np.log((1e-3, 0.3))))
    time = np.arange(turns.size) / recording.rate_hz
    return comb + size * np.cos(2 * np.pi * supply * time + record.uniform(0.0, 2 * math.pi))
