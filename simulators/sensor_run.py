"""Sensor effects on the way from simulated motion to a record: their order, their needs, their random numbers."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .effect import SensorEffect
from .errors import InvalidValueError
from .sensor_record import LINKS, SensorRecord, sampled

if TYPE_CHECKING:
    from .assembly import Probe
    from .machine import Machine
    from .sensor_chain import SensorChain
    from .solvers.simulate import Simulation


def sensor_effects(machine: Machine) -> list[SensorEffect]:
    """Return the machine's effects on the measuring chain, in the order of the chain's links."""
    found = [effect for effect in machine.effects if isinstance(effect, SensorEffect)]
    return sorted(found, key=lambda e: (LINKS.index(e.LINK), e.NAME, e.at, tuple(e.values().values())))


def demand(effects: Sequence[SensorEffect], *, rate_hz: float, duration_s: float) -> tuple[int, float]:
    """Return the multiple of the output rate and the extra seconds that the effects together need."""
    wanted = [effect.demand(rate_hz=rate_hz, duration_s=duration_s) for effect in effects]
    return max((factor for factor, _ in wanted), default=1), max((extra for _, extra in wanted), default=0.0)


def check_seed(effects: Sequence[SensorEffect], seed: int | None) -> None:
    """Raise InvalidValueError when an effect draws random numbers and there is no seed."""
    names = [effect.NAME for effect in effects if effect.is_random]
    if names and seed is None:
        raise InvalidValueError(
            f"seed = None, but {', '.join(names)} is random; allowed: a whole number of at least 0. Give seed=1, or "
            "another one for another draw."
        )
    if seed is not None and (isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0):
        raise InvalidValueError(f"seed = {seed!r}; allowed: a whole number of at least 0. Correct it.")


def record_of(simulation: Simulation, machine: Machine, *, output_rate_hz: float) -> SensorRecord:
    """Return what a chain without any limits would record of a simulation."""
    return record_of_signals(
        simulation.signals,
        machine,
        simulation.probes,
        phase_rad=simulation.phase_rad,
        speed_rad_s=simulation.speed_rad_s,
        rate_hz=simulation.rate_hz,
        output_rate_hz=output_rate_hz,
    )


def record_of_signals(
    signals: np.ndarray,
    machine: Machine,
    channels: tuple[Probe, ...],
    *,
    phase_rad: np.ndarray,
    speed_rad_s: np.ndarray,
    rate_hz: float,
    output_rate_hz: float,
) -> SensorRecord:
    """Return what a chain without any limits would record of signals (channels, samples) of a machine."""
    middle = signals.mean(axis=1)
    return SensorRecord(
        signals=signals,
        rate_hz=rate_hz,
        output_rate_hz=output_rate_hz,
        phase_rad=phase_rad,
        speed_rad_s=speed_rad_s,
        channels=channels,
        shaft_ratios=probe_ratios(machine, channels),
        full_scale=np.abs(signals - middle[:, None]).max(axis=1),
        middle=middle,
        leak=np.zeros(len(channels)),
    )


def probe_ratios(machine: Machine, probes: Sequence[Probe]) -> tuple[float, ...]:
    """Return the speed of the shaft that each probe looks at over the reference shaft's."""
    ratios = machine.shaft_ratios
    return tuple(ratios.get(probe.location, 1.0) for probe in probes)


def lines_of_chain(
    machine: Machine, channels: Sequence[Probe], amplitudes: np.ndarray, orders: Sequence[int]
) -> np.ndarray | None:
    """Return motions' lines as the machine's chain shows them; None where it does more than mix and add such lines.

    Parameters
    ----------
    machine : Machine
    channels : sequence of Probe
    amplitudes : ndarray (..., channels, orders), complex
    orders : sequence of int
        Of the reference shaft.
    """
    for effect in sensor_effects(machine):
        matrix = effect.mixing(channels)
        if matrix is None:
            return None
        added, amplitudes = effect.added(channels), matrix @ amplitudes
        if added and any(ratio != 1 for ratio in probe_ratios(machine, [channels[i] for i in effect.chosen(channels)])):
            return None
        for column, order in enumerate(orders):
            amplitudes[..., column] += added.get(order, 0.0)
    return amplitudes


def run_chain(
    record: SensorRecord,
    effects: Sequence[SensorEffect],
    *,
    samples: int,
    seed: int | None,
    stream: int = 0,
    chain: SensorChain | None = None,
) -> SensorRecord:
    """Return the finished record of ``samples`` samples at the output rate.

    Parameters
    ----------
    record : SensorRecord
    effects : sequence of SensorEffect
        In the order of the links, as `sensor_effects` gives them.
    samples : int
    seed : int or None
    stream : int
        Number of the run among several with the same seed.
    chain : SensorChain, optional
    """
    check_seed(effects, seed)
    if chain is not None:
        record = chain.ranged(record)
    generators = _generators(effects, seed or 0, stream)
    for link in LINKS:
        if chain is not None:
            record = chain.healthy(link, record, random_stream(seed or 0, stream, link, 0))
        for effect, generator in zip(effects, generators, strict=True):
            if link == effect.LINK:
                record = effect.apply(record, generator)
        if link == "filter":
            record = sampled(record)
    return replace(
        record,
        signals=np.ascontiguousarray(record.signals[:, :samples]),
        phase_rad=record.phase_rad[:samples],
        speed_rad_s=record.speed_rad_s[:samples],
    )


def _generators(effects: Sequence[SensorEffect], seed: int, stream: int) -> list[np.random.Generator]:
    """Return a stream of random numbers for each effect that does not change when other effects come or go."""
    seen: dict[str, int] = {}
    made = []
    for effect in effects:
        name = f"{effect.NAME} at {effect.at}"
        made.append(random_stream(seed, stream, name, seen.get(name, 0)))
        seen[name] = seen.get(name, 0) + 1
    return made


def random_stream(seed: int, stream: int, name: str, number: int) -> np.random.Generator:
    """Return the random numbers of one part of one run: nothing else changes them."""
    return np.random.default_rng([seed, stream, zlib.crc32(name.encode()), number])
