"""Simulated motion and measured records of trial machines, in the time domain.

Every channel of a campaign has a gain of its own that is off by 1 % (standard deviation), the same in all its records.
White noise of the stated signal-to-noise ratio is added to every record: its rms over the band from 0 to half the
sampling rate is the record's own vibration over 10^(dB/20). The sensor's own noise is added to it, so that a channel
that stands still is not without noise: 1 nm, 0.1 um/s, 1e-4 m/s2 or 1e-4 rad/s. Then come the converter, of 16 bits
over the record's own range, and a tacho of one pulse a turn whose edges are averaged over a sample, as by an
anti-alias filter, so that they can be interpolated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....datasets.recording import Channel, OperatingCondition, Recording
from ....datasets.units import parse_unit
from ....simulators.machine import Machine
from ....simulators.sensor_chain import SensorChain
from ....simulators.sensor_record import SensorRecord
from ....simulators.sensor_run import demand, record_of, run_chain, sensor_effects
from ....simulators.solvers.simulate import Simulation, simulate_raw
from .ranges import TrialRange

GAIN_DEVIATION, BITS = 0.01, 16
SENSOR_NOISE = {"m": 1e-9, "m/s": 1e-7, "m/s2": 1e-4, "rad/s": 1e-4, "rad": 1e-9}
_TACHO_PARTS = 16
_DIRECTIONS = {"x": "horizontal", "y": "vertical", "axial": "axial"}


@dataclass(frozen=True)
class Setting:
    """A condition of a campaign: true speed and load, and where in the first turn the record begins."""

    speed_rpm: float
    load: float | None
    start_turn: float


@dataclass(frozen=True, kw_only=True)
class TrialChain(SensorChain):
    """A measuring chain with a gain and a noise of its own for every channel.

    Parameters
    ----------
    gains : tuple of float
    noise_rms : tuple of float
        In each channel's unit, from 0 to half the output rate.
    """

    gains: tuple[float, ...]
    noise_rms: tuple[float, ...]

    def healthy(self, link: str, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Return the record behind one link; gain and noise belong to the transducer."""
        if link != "transducer":
            return super().healthy(link, record, generator)
        wider = math.sqrt(record.rate_hz / record.output_rate_hz)
        noise = generator.normal(size=record.signals.shape) * np.array(self.noise_rms)[:, None] * wider
        return record.with_signals(record.signals * np.array(self.gains)[:, None] + noise)


def motions(machines: Sequence[Machine], settings: Sequence[Setting], how: TrialRange) -> list[list[Simulation]]:
    """Return the motion of every machine in every setting, all side by side."""
    cases = [(loaded(machine, one.load), one.speed_rpm) for machine in machines for one in settings]
    slowest = min(one.speed_rpm for one in settings)
    duration = (how.duration_s or how.turns[1] * 60 / slowest) + 60 / slowest
    runs = simulate_raw(cases, duration_s=duration, rate_hz=how.rate_hz, step_s=how.step_s)
    count = len(settings)
    return [runs[i * count : (i + 1) * count] for i in range(len(machines))]


def moves_as(machine: Machine, how: TrialRange) -> str:
    """Return what is the same for machines whose simulated motion is the same.

    That is all but effects on the measuring chain, which may ask for another rate or length.
    """
    sensors = sensor_effects(machine)
    asked = demand(sensors, rate_hz=how.rate_hz, duration_s=how.duration_s or how.turns[1])
    return repr((machine.changed, [effect for effect in machine.effects if effect not in sensors], asked))


def loaded(machine: Machine, load: float | None) -> Machine:
    """Return the machine under a load; None leaves it as it is."""
    return machine if load is None else machine.with_parameters(**{machine.definition.load_parameter: load})


def clean_record(
    run: Simulation, machine: Machine, setting: Setting, how: TrialRange, *, turns: float, seed: int, stream: int
) -> SensorRecord:
    """Return what an ideal chain with the machine's sensor effects records."""
    return _cut(_measured(run, machine, how, None, seed, stream), setting, how, turns)


def noise_of(run: Simulation, snr_db: float) -> np.ndarray:
    """Return each channel's noise, rms in its unit, shape (channels,); see the module's docstring."""
    sensor = np.array([SENSOR_NOISE[probe.unit] for probe in run.probes])
    return np.hypot(run.signals.std(axis=1) * 10 ** (-snr_db / 20), sensor)


def recording(
    run: Simulation,
    machine: Machine,
    setting: Setting,
    how: TrialRange,
    *,
    gains: np.ndarray,
    snr_db: float,
    turns: float,
    seed: int,
    stream: int,
    pulse_rad: float = 0.0,
) -> Recording:
    """Return the measured record of a run as a recording of the probes that a campaign has, and the tacho.

    The tacho's pulse comes when the machine has turned by ``pulse_rad``.
    """
    noise = tuple(noise_of(run, snr_db).tolist())
    chain = TrialChain(bits=BITS, pulses_per_revolution=1, gains=tuple(gains.tolist()), noise_rms=noise)
    record = _cut(_measured(run, machine, how, chain, seed, stream), setting, how, turns)
    rows = kept(record, how)
    signals = np.vstack([record.signals[rows], _tacho(chain, record, pulse_rad)])
    channels = [_channel(record, row) for row in rows]
    declared = {p.name: p.unit for p in machine.definition.parameters}
    unit = declared.get(machine.definition.load_parameter) if setting.load is not None else None
    return Recording(
        signals,
        how.rate_hz,
        (*channels, Channel("tacho", "tacho", stored_unit="V")),
        # Nobody reads a speed to better than a revolution.
        condition=OperatingCondition(speed_rpm=round(setting.speed_rpm), load=setting.load, load_unit=unit),
    )


def kept(record: SensorRecord | Simulation, how: TrialRange) -> list[int]:
    """Return the numbers of the channels that a campaign records."""
    probes = record.channels if isinstance(record, SensorRecord) else record.probes
    names = [probe.name for probe in probes if parse_unit(probe.unit) is not None]
    return [i for i, probe in enumerate(probes) if probe.name in names and probe.name in (how.probes or names)]


def _measured(
    run: Simulation, machine: Machine, how: TrialRange, chain: TrialChain | None, seed: int, stream: int
) -> SensorRecord:
    record = record_of(run, machine, output_rate_hz=how.rate_hz)
    samples = math.floor(run.signals.shape[1] / run.rate_hz * how.rate_hz + 1e-9)
    return run_chain(record, sensor_effects(machine), samples=samples, seed=seed, stream=stream, chain=chain)


def _cut(record: SensorRecord, setting: Setting, how: TrialRange, turns: float) -> SensorRecord:
    per_turn = 60 / setting.speed_rpm * how.rate_hz
    first = round(setting.start_turn * per_turn)
    last = first + round(how.duration_s * how.rate_hz if how.duration_s else turns * per_turn)
    part = slice(first, last)
    return replace(
        record,
        signals=record.signals[:, part],
        phase_rad=record.phase_rad[part],
        speed_rad_s=record.speed_rad_s[part],
    )


def _tacho(chain: SensorChain, record: SensorRecord, pulse_rad: float) -> np.ndarray:
    """Return the tacho's level averaged over each sample, shape (samples,)."""
    within = (np.arange(_TACHO_PARTS) + 0.5) / _TACHO_PARTS - 0.5
    phase = record.phase_rad[:, None] + record.speed_rad_s[:, None] / record.output_rate_hz * within
    fine = replace(record, phase_rad=phase.ravel() - pulse_rad, speed_rad_s=np.repeat(record.speed_rad_s, _TACHO_PARTS))
    return chain.tacho(fine, np.random.default_rng(0)).reshape(phase.shape).mean(axis=1)


def _channel(record: SensorRecord, row: int) -> Channel:
    probe = record.channels[row]
    unit = parse_unit(probe.unit)
    assert unit is not None
    return Channel(probe.name, unit.quantity, probe.location, _DIRECTIONS.get(probe.direction), probe.unit)
