"""From a simulated machine to a recording that could be a measured one: channels, tacho, nameplate, label, origin."""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from ..simulators.assembly import Probe
from ..simulators.effect import Effect
from ..simulators.errors import InvalidValueError
from ..simulators.machine import Machine
from ..simulators.rotor_dynamics.gear_mesh_stiffness import SpurPair
from ..simulators.rotor_dynamics.rolling_bearing import BearingGeometry
from ..simulators.sensor_chain import SensorChain, check_seed, record_of, run_chain, sensor_effects
from ..simulators.speed_profile import SpeedProfile, as_profile
from .recording import Channel, GearPair, MountedBearing, Nameplate, OperatingCondition, Recording
from .units import parse_unit

if TYPE_CHECKING:
    from ..simulators.solvers.simulate import Simulation

#: Packages that decide about the numbers.
_PACKAGES = ("rotorwise", "numpy", "scipy", "numba")
#: x is horizontal, y vertical in every machine here.
_DIRECTIONS = {"x": "horizontal", "y": "vertical", "axial": "axial"}
TACHO = "tacho"
#: More samples than this in all channels would not fit the memory of a usual computer on the way.
MOST_SAMPLES = 300_000_000
#: No machine moves so far or so fast, in SI units.
_BEYOND_SENSE = 1e9


@dataclass(frozen=True, eq=False)
class SimulatedRecord:
    """A recording of a simulated machine and what there is to say of how it came about.

    Attributes
    ----------
    recording : Recording
    notes : tuple of str
        Limits passed, step shortened, channels left out.
    step_s : float
        Integration step.
    errors : mapping of str to float
        Estimated relative rms error by probe; empty when not asked for.
    provenance : mapping of str to str
        Machine as text, versions, seed, step, speed.
    """

    recording: Recording
    notes: tuple[str, ...]
    step_s: float
    errors: Mapping[str, float] = field(default_factory=dict)
    provenance: Mapping[str, str] = field(default_factory=dict)


def record_machine(
    machine: Machine,
    *,
    speed_rpm: float | SpeedProfile,
    duration_s: float,
    rate_hz: float,
    chain: SensorChain | None = None,
    seed: int | None = None,
    probes: Sequence[str] = (),
    **options: Any,
) -> SimulatedRecord:
    """Simulate a machine and return it as a recording.

    Parameters
    ----------
    machine : Machine
        With its effects.
    speed_rpm, duration_s, rate_hz
        As in `simulate_batch` of the simulators, as are further ``options``.
    chain : SensorChain, optional
        Healthy measuring chain; an ideal one with a tacho of one pulse a revolution when left out.
    seed : int, optional
        Required when the chain or an effect is random.
    probes : sequence of str
        Names of the probes to record; all when empty.

    Raises
    ------
    InvalidValueError
        For a value that is not allowed, an unknown probe, a missing seed, or a record too long for the memory.
    SimulationError
        When the motion grows without bound.
    """
    from ..simulators.solvers.simulate import simulate_raw

    chain = SensorChain(pulses_per_revolution=1) if chain is None else chain
    profile, effects = as_profile(speed_rpm), sensor_effects(machine)
    check_seed(effects, seed)
    if chain.is_random and seed is None:
        raise InvalidValueError("seed = None, but the chain has noise or jitter; allowed: 0 or more. Give a seed.")
    kept, notes = recordable(machine.assembly(speed_rpm=profile).probes, probes)
    _check_length(duration_s, rate_hz, len(machine.bare_assembly().probes))
    # An unstable machine leaves the number range on the way; `measured` looks at what it leaves.
    with np.errstate(over="ignore", invalid="ignore"):
        raw = simulate_raw([(machine, profile)], duration_s=duration_s, rate_hz=rate_hz, probes=probes, **options)[0]
    samples = math.floor(duration_s * rate_hz + 1e-9)
    signals, channels = measured(raw, machine, kept, rate_hz=rate_hz, samples=samples, chain=chain, seed=seed)
    errors = {} if raw.errors is None else dict(zip((p.name for p in raw.probes), raw.errors.tolist(), strict=True))
    recording = Recording(
        signals,
        rate_hz,
        channels,
        condition=_condition(machine, profile),
        nameplate=nameplate_of(machine),
        label=label_of(machine.effects),
        pulses_per_revolution=chain.pulses_per_revolution * chain.tacho_ratio if chain.pulses_per_revolution else 1.0,
    )
    origin = _provenance(machine, profile, chain, seed, raw.step_s)
    return SimulatedRecord(recording, (*raw.notes, *notes), raw.step_s, errors, origin)


def measured(
    raw: Simulation,
    machine: Machine,
    kept: Sequence[Probe],
    *,
    rate_hz: float,
    samples: int,
    chain: SensorChain,
    seed: int | None,
) -> tuple[np.ndarray, tuple[Channel, ...]]:
    """Return what the measuring chain makes of a motion at some probes, and of the shaft's angle as a tacho.

    Parameters
    ----------
    raw : Simulation
        As `simulate_raw` of the simulators gives it.
    machine : Machine
    kept : sequence of Probe
    rate_hz : float
    samples : int
    chain : SensorChain
    seed : int or None
        Required when the chain or an effect is random.

    Returns
    -------
    signals : ndarray (channels, samples)
        SI units; the tacho, if the chain has one, is the last.
    channels : tuple of Channel

    Raises
    ------
    SimulationError
        When the motion has grown without bound, or the chain does not give numbers.
    """
    from ..simulators.solvers.simulate import SimulationError

    largest = float(np.abs(raw.signals).max())
    if not largest < _BEYOND_SENSE:
        raise SimulationError(
            f"The motion of {machine.name} grew to {largest:.3g}: the machine is unstable with these parameters. "
            "Change them, or the speed."
        )
    # The chain's filters cost as much as the simulation: only for what is recorded.
    rows = [raw.probes.index(probe) for probe in kept]
    some = replace(raw, signals=raw.signals[rows], probes=tuple(kept))
    record = record_of(some, machine, output_rate_hz=rate_hz)
    # Settings without sense may leave the number range; what comes out is looked at.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        record = run_chain(record, sensor_effects(machine), samples=samples, seed=seed, chain=chain)
    signals, channels = record.signals, [channel_of(probe) for probe in kept]
    if not np.isfinite(signals).all():
        raise SimulationError(f"The measuring chain makes no finite signal of {machine.name}: {chain}. Change it.")
    if chain.pulses_per_revolution:
        generator = np.random.default_rng([seed or 0, len(rows)])
        signals = np.vstack([signals, chain.tacho(record, generator)])
        channels.append(Channel(TACHO, "tacho", stored_unit="V"))
    return signals, tuple(channels)


def label_of(effects: Sequence[Effect]) -> str:
    """Return what is wrong with a machine: its effects with place and values, or "healthy".

    Examples
    --------
    >>> label_of([])
    'healthy'
    """
    return "; ".join(_effect_text(effect) for effect in effects) or "healthy"


def _effect_text(effect: Effect) -> str:
    units = {declared.name: declared.unit for declared in effect.parameters()}
    values = ", ".join(f"{name} {value:.6g} {units[name]}".rstrip() for name, value in effect.values().items())
    return f"{effect.NAME}{f' at {effect.at}' if effect.at else ''} ({values})"


def nameplate_of(machine: Machine) -> Nameplate:
    """Return what a machine's owner would know: bearings, gear teeth, magnetic-bearing clearance, supply."""
    assembly = machine.assembly(speed_rpm=1000.0)
    bearings, gears = [], []
    for part in assembly.components.values():
        geometry, pair = getattr(part, "geometry", None), getattr(part, "pair", None)
        if isinstance(geometry, BearingGeometry):
            bearings.append(MountedBearing(geometry, part.name, getattr(part, "shaft_ratio", 1.0)))
        if isinstance(pair, SpurPair):
            driver, driven = pair.pinion.teeth, pair.wheel.teeth
            gears.append(GearPair(driver, driven, part.mesh_order / driver))
    held = any(place.name.startswith("retainer") for place in assembly.places.values())
    line = [effect.values()["supply_hz"] for effect in machine.effects if "supply_hz" in effect.values()]
    return Nameplate(
        name=machine.name,
        bearings=tuple(bearings),
        gears=tuple(gears),
        line_frequency_hz=line[0] if line else None,
        magnetic_bearing_clearance_m=machine.values.get("clearance_m") if held else None,
    )


def recordable(there: Sequence[Probe], wanted: Sequence[str]) -> tuple[list[Probe], list[str]]:
    """Return the probes that a recording can hold, and a remark on those that it cannot."""
    names = [probe.name for probe in there]
    for name in wanted:
        if name not in names:
            raise InvalidValueError(f"No probe {name!r}; allowed: {', '.join(names)}. Correct the name.")
    chosen = [probe for probe in there if not wanted or probe.name in wanted]
    kept = [probe for probe in chosen if parse_unit(probe.unit) is not None]
    if not kept:
        raise InvalidValueError(
            f"None of the probes {', '.join(probe.name for probe in chosen)} has a unit that a recording holds; "
            "allowed: linear motion, angle or rotational speed. Choose other probes."
        )
    lost = [f"{probe.name} ({probe.unit})" for probe in chosen if probe not in kept]
    return kept, [f"Left out, as recordings hold no such unit: {', '.join(lost)}."] if lost else []


def channel_of(probe: Probe) -> Channel:
    """Return the channel that records a probe."""
    unit = parse_unit(probe.unit)
    assert unit is not None
    if unit.to_si != 1.0:
        raise InvalidValueError(f"Probe {probe.name} is in {probe.unit}; allowed: SI units. Correct the machine.")
    return Channel(probe.name, unit.quantity, probe.location, _DIRECTIONS.get(probe.direction), probe.unit)


def _condition(machine: Machine, profile: SpeedProfile) -> OperatingCondition:
    parameter = next((p for p in machine.definition.parameters if p.name == machine.definition.load_parameter), None)
    return OperatingCondition(
        # A nominal speed is a hint; a run-up has none.
        speed_rpm=profile.speeds_rad_s[0] * 30 / math.pi if profile.is_steady else None,
        load=machine.values[parameter.name] if parameter else None,
        load_unit=parameter.unit if parameter else None,
    )


def _check_length(duration_s: float, rate_hz: float, channels: int) -> None:
    for name, value in (("duration_s", duration_s), ("rate_hz", rate_hz)):
        if not (math.isfinite(value) and value > 0):
            raise InvalidValueError(f"{name} = {value!r}; allowed: finite and more than 0.")
    if duration_s * rate_hz * channels > MOST_SAMPLES:
        longest = MOST_SAMPLES / (rate_hz * channels)
        raise InvalidValueError(
            f"{duration_s:g} s of {channels} probes at {rate_hz:g} Hz do not fit the memory; allowed: up to "
            f"{longest:.3g} s. Simulate pieces, or at a lower rate."
        )


def _provenance(
    machine: Machine, profile: SpeedProfile, chain: SensorChain, seed: int | None, step_s: float
) -> dict[str, str]:
    knots = [f"{t:g} s: {w * 30 / math.pi:.9g} rpm" for t, w in zip(profile.times_s, profile.speeds_rad_s, strict=True)]
    return {
        "machine": machine.to_toml(),
        "speed": ", ".join(knots[:4]),
        "chain": repr(chain),
        "seed": str(seed),
        "step_s": repr(step_s),
        "versions": ", ".join(
            [*(f"{name} {version(name)}" for name in _PACKAGES), f"Python {platform.python_version()}"]
        ),
    }
