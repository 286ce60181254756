"""Records of struck races and balls, made without the simulators: impacts, each a ring of 2.8 kHz, in noise."""

import math
from dataclasses import replace

import numpy as np
from rotorwise.datasets.recording import Channel, OperatingCondition, Provenance, Recording

RATE_HZ, SECONDS = 10_000.0, 4.0
SPEEDS_RPM = (1260.0, 1840.0, 2500.0)
#: MaFaulDa's bearing: 8 balls, so that the races are passed nearly three and five times a turn.
BALLS, RATIO = 8, 0.7145 / 2.8519


def struck(speed_rpm: float, *, inner: bool, slip: float, seed: int) -> Recording:
    """Return impacts of a race in noise, each a ring of 2.8 kHz; the inner race turns in its load."""
    generator = np.random.default_rng(seed)
    turns = speed_rpm / 60 * np.arange(int(RATE_HZ * SECONDS)) / RATE_HZ
    cage = (1 - RATIO) / 2 * (1 - slip)
    order = BALLS * (1 - cage if inner else cage)
    instants = np.interp((np.arange(int(order * turns[-1])) + 0.3) / order, turns, np.arange(turns.size))
    size = 1.0 + (0.8 * np.cos(2 * math.pi * turns[instants.astype(int)]) if inner else 0.0)
    pulses = np.zeros(turns.size)
    np.add.at(pulses, instants.astype(int), size)
    time = np.arange(200) / RATE_HZ
    ring = np.exp(-600 * time) * np.sin(2 * math.pi * 2800 * time)
    signal = np.convolve(pulses, ring)[: turns.size] + 0.3 * generator.normal(size=turns.size)
    channel = Channel(name="housing_a_y", quantity="acceleration")
    return Recording(
        signals=signal[None],
        rate_hz=RATE_HZ,
        channels=(channel,),
        condition=OperatingCondition(speed_rpm=speed_rpm),
        provenance=Provenance(),
    )


def a_struck_ball(slip: float, *, by_the_cage: bool = False) -> Recording:
    """Return impacts of a ball twice a turn of it, let through where the cage has it in the load.

    ``by_the_cage``: one impact a turn of the cage, by the cage itself.
    """
    generator = np.random.default_rng(4)
    turns = 30.0 * np.arange(int(RATE_HZ * SECONDS)) / RATE_HZ
    cage = (1 - RATIO) / 2 * (1 - slip)
    twice = cage if by_the_cage else (1 - RATIO**2) / RATIO * (1 - slip)
    instants = np.interp(np.arange(int(twice * turns[-1])) / twice, turns, np.arange(turns.size)).astype(int)
    pulses = np.zeros(turns.size)
    loaded = 1.0 if by_the_cage else np.maximum(np.cos(2 * math.pi * cage * turns[instants]), 0.0) ** 1.5
    np.add.at(pulses, instants, loaded)
    time = np.arange(200) / RATE_HZ
    ring = np.exp(-600 * time) * np.sin(2 * math.pi * 2800 * time)
    signal = np.convolve(pulses, ring)[: turns.size] + 0.1 * generator.normal(size=turns.size)
    made = struck(1800.0, inner=False, slip=slip, seed=0)
    return replace(made, signals=signal[None])
