"""Simulated records of one machine in the recipe's states, as a table of features: the same draws for every machine."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from extension_machines import PROBES
from rotorwise.datasets.recording import OperatingCondition, Recording
from rotorwise.datasets.simulated import measured, nameplate_of, recordable
from rotorwise.diagnose.learning.feature_table import FeatureTable
from rotorwise.diagnose.learning.machine_noise import MachineNoise, with_machine_noise
from rotorwise.diagnose.learning.relative_features import levels, relative_features
from rotorwise.diagnose.learning.sources import HINT_ERROR
from rotorwise.diagnose.observe import observe
from rotorwise.simulators import effects
from rotorwise.simulators.effect import Effect
from rotorwise.simulators.machine import Machine
from rotorwise.simulators.sensor_chain import SensorChain
from rotorwise.simulators.solvers.simulate import Simulation, simulate_raw

RATE_HZ, DURATION_S = 20000.0, 2.0
#: Speeds of every draw, one in each range: the range of the recordings.
SPEEDS_RPM = ((1100.0, 1800.0), (1800.0, 2600.0))
#: State and how often it is drawn at each speed; three sound records, so that each has twins.
STATES = (
    ("healthy", 3),
    ("unbalance", 2),
    ("misalignment", 1),
    ("bent_shaft", 1),
    ("bearing_outer_race", 2),
    ("bearing_inner_race", 2),
    ("bearing_ball", 1),
)
#: Deviation of the machine's own parameters between draws, in the logarithm.
SPREAD = 0.1
#: Size of the extended machine's forces against those of the campaign: smaller and a little larger.
SIZE = (0.1, 1.5)
NOISE_SEED = 1


@dataclass(frozen=True)
class _State:
    draw: int
    fault: str
    speed_rpm: float
    seed: int


def table_of_machine(machine: Machine, *, draws: int, seed: int) -> FeatureTable:
    """Return relative features and levels of a machine in all states.

    Parameters
    ----------
    machine : Machine
    draws : int
        How often its parameters are drawn.
    seed : int
        The same seed draws the same relative changes, speeds, faults, chains and noise for every machine.
    """
    return _table(machine, _states(draws, seed), seed, ())


def with_forces(
    table: FeatureTable, machine: Machine, forces: Sequence[Effect], *, draws: int, seed: int
) -> FeatureTable:
    """Return the table with what the engine added in place of the catalogue's unbalance, all else as it was.

    All additions of a record are larger or smaller by one drawn factor.
    """
    chosen = table.labels == "unbalance"
    made = _table(machine, [one for one in _states(draws, seed) if one.fault == "unbalance"], seed, forces)
    values = table.values.copy()
    values[chosen] = made.only(table.names).values
    return replace(table, values=values)


def _table(machine: Machine, states: Sequence[_State], seed: int, forces: Sequence[Effect]) -> FeatureTable:
    rows = []
    for _, own in groupby(states, key=lambda state: (state.draw, state.speed_rpm)):
        rows += _together(machine, list(own), seed, forces)
    count = len(states)
    return FeatureTable(
        np.array([list(row.values()) for row in rows]),
        tuple(rows[0]),
        np.array([state.fault for state in states]),
        {
            "machine": np.repeat("rig", count),
            "group": np.array([f"draw-{state.draw}" for state in states]),
            "case": np.array([state.fault for state in states]),
            "speed_rpm": np.array([state.speed_rpm for state in states]),
            "load": np.zeros(count),
            "split": np.repeat("train", count),
        },
    )


def _states(draws: int, seed: int) -> list[_State]:
    found = []
    names = [fault for fault, count in STATES for _ in range(count)]
    for draw in range(draws):
        stream = np.random.default_rng([seed, 1, draw])
        for place, ends in enumerate(SPEEDS_RPM):
            speed = float(stream.uniform(*ends))
            found += [_State(draw, name, speed, 1000 * draw + 100 * place + i) for i, name in enumerate(names)]
    return found


def _together(
    machine: Machine, states: Sequence[_State], seed: int, forces: Sequence[Effect]
) -> Iterator[dict[str, float]]:
    """Yield the features of one draw's states at one speed, simulated side by side."""
    own = _changed(machine, states[0].draw, seed)
    streams = [np.random.default_rng([seed, 3, state.seed]) for state in states]
    faulty = [own.with_effects(*_faults(one.fault, s, forces)) for one, s in zip(states, streams, strict=True)]
    cases = [(one, state.speed_rpm) for one, state in zip(faulty, states, strict=True)]
    motions = simulate_raw(cases, duration_s=DURATION_S, rate_hz=RATE_HZ, probes=PROBES)
    for state, stream, one, motion in zip(states, streams, faulty, motions, strict=True):
        yield _features(motion, one, state, stream)


def _changed(machine: Machine, draw: int, seed: int) -> Machine:
    """Return the machine with what is uncertain of it changed by factors that depend on the draw only."""
    stream, load = np.random.default_rng([seed, 2, draw]), machine.definition.load_parameter
    values = {}
    for one in machine.definition.parameters:
        factor = math.exp(SPREAD * stream.normal())
        if one.prior is not None and one.name != load:
            low, high = one.bounds
            values[one.name] = min(max(machine.values[one.name] * factor, low), high)
    return machine.with_parameters(**values)


def _features(motion: Simulation, machine: Machine, state: _State, stream: np.random.Generator) -> dict[str, float]:
    chain = SensorChain(
        mounting_hz=_log_uniform(stream, 8e3, 4e4),
        high_pass_hz=_log_uniform(stream, 0.3, 3.0),
        noise={"m/s2": _log_uniform(stream, 1e-4, 0.1)},
        full_scale={"m/s2": 490.0},
        bits=16,
        pulses_per_revolution=0,
    )
    kept, _ = recordable(machine.assembly(speed_rpm=state.speed_rpm).probes, PROBES)
    samples = round(DURATION_S * RATE_HZ)
    signals, channels = measured(motion, machine, kept, rate_hz=RATE_HZ, samples=samples, chain=chain, seed=state.seed)
    hint = 1.0 + HINT_ERROR * stream.uniform(-1.0, 1.0)
    condition = OperatingCondition(speed_rpm=state.speed_rpm * hint)
    recording = Recording(signals, RATE_HZ, channels, condition=condition, nameplate=nameplate_of(machine))
    about = {"machine": "rig", "group": f"draw-{state.draw}", "seed": state.seed, "speed_rpm": state.speed_rpm}
    now = observe(with_machine_noise(recording, about, MachineNoise(NOISE_SEED)))
    return relative_features(now) | levels(now)


def _faults(fault: str, stream: np.random.Generator, forces: Sequence[Effect]) -> list[Effect]:
    angle = float(stream.uniform(-math.pi, math.pi))
    size_m, moment = _log_uniform(stream, 3e-4, 3e-3), _log_uniform(stream, 1e-4, 3e-3)
    factor, seed = _log_uniform(stream, *SIZE), int(stream.integers(1_000_000))
    pit = {"at": "bearing_b", "size_m": size_m, "seed": seed}
    if fault == "unbalance" and forces:
        return [_scaled(one, factor) for one in forces]
    made: dict[str, list[Effect]] = {
        "healthy": [],
        "unbalance": [effects.Unbalance(at="disc", moment_kg_m=moment, angle_rad=angle)],
        "misalignment": [
            effects.CouplingMisalignment(
                offset_m=0.5 * size_m, angle_rad=10 * size_m, offset_phase_rad=angle, angle_phase_rad=angle
            )
        ],
        "bent_shaft": [effects.ShaftBow(bow_m=0.2 * size_m, angle_rad=angle)],
        "bearing_outer_race": [effects.OuterRaceDefect(**pit)],
        "bearing_inner_race": [effects.InnerRaceDefect(**pit)],
        "bearing_ball": [effects.BallDefect(**pit)],
    }
    return made[fault]


def _scaled(effect: Effect, factor: float) -> Effect:
    """Return an effect with its strengths, the parameters at whose zero it is absent, larger by a factor."""
    sizes = {}
    for one in effect.parameters():
        if one.zero == 0.0:
            low, high = one.bounds
            sizes[one.name] = min(max(factor * getattr(effect, one.name), low), high)
    return replace(effect, **sizes)


def _log_uniform(stream: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(stream.uniform(math.log(low), math.log(high))))
