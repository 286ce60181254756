"""Time-domain simulation: machines in, anti-aliased probe signals out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..assembly import Probe
from ..effect import SpeedEffect
from ..errors import InvalidValueError, RotorwiseError
from ..law import InterfaceForce
from ..machine import Machine
from ..sensor_run import check_seed, demand, record_of, run_chain, sensor_effects
from ..speed_profile import SpeedProfile, as_profile, modulated
from ..system import System
from .blas import single_blas_thread
from .stepper import LaneGroup, run_group

#: More lanes than this side by side bring nothing: their states no longer fit the cache.
MOST_LANES = 64
#: A steady run whose last quarter is this many times stronger than its first is taken to diverge.
DRIFT = 30.0
#: A signal beyond this, in any unit, is a divergence; its square would no longer be a number.
LARGEST = 1e100
#: An rms below this, in m, m/s, m/s2 or rad, is rounding.
SILENT = 1e-13
#: A contact's own oscillation (its stiffness on the mass that it meets) gets at least this many steps a radian.
STEPS_OF_CONTACT = 2.0
#: A contact that would need steps shorter than this is refused.
SHORTEST_STEP_S = 1e-8

Case = tuple[Machine, float | SpeedProfile]


class SimulationError(RotorwiseError):
    """The simulation did not give a usable result: it grew without bound or became not a number."""


@dataclass(frozen=True)
class Simulation:
    """Probe signals of one run.

    Attributes
    ----------
    signals : ndarray (probes, samples)
    rate_hz : float
    probes : tuple of Probe
    phase_rad, speed_rad_s : ndarray (samples,)
        Of the reference shaft.
    step_s : float
        Integration step.
    errors : ndarray (probes,), optional
        Estimated relative rms error of each probe, from a second run with half the step; None when not asked for.
    notes : tuple of str
        What the user should know about this run.
    """

    signals: np.ndarray
    rate_hz: float
    probes: tuple[Probe, ...]
    phase_rad: np.ndarray
    speed_rad_s: np.ndarray
    step_s: float
    errors: np.ndarray | None = None
    notes: tuple[str, ...] = ()

    def probe(self, name: str) -> np.ndarray:
        """Return the signal of one probe, shape (samples,)."""
        names = [probe.name for probe in self.probes]
        if name not in names:
            raise InvalidValueError(f"No probe {name!r}; allowed: {', '.join(names)}. Correct the name.")
        return self.signals[names.index(name)]

    @property
    def time_s(self) -> np.ndarray:
        """Time of each sample, shape (samples,)."""
        return np.arange(self.signals.shape[1]) / self.rate_hz


def simulate(machine: Machine, *, speed_rpm: float | SpeedProfile, **options: object) -> Simulation:
    """Return the probe signals of one machine; options as in `simulate_batch`."""
    return simulate_batch([(machine, speed_rpm)], **options)[0]  # type: ignore[arg-type]


def simulate_batch(
    cases: Sequence[Case], *, duration_s: float, rate_hz: float, seed: int | None = None, **options: Any
) -> list[Simulation]:
    """Return the probe signals of several machines, side by side where they share their linear core.

    Effects of all stages act: on the speed before, on the recorded signals after the physics.

    Parameters
    ----------
    cases : sequence of (Machine, speed)
        Speed in revolutions a minute, or a `SpeedProfile`.
    duration_s, rate_hz : float
        Of the recorded signals; time 0 of a speed profile is their first sample.
    seed : int, optional
        Required when an effect on the recorded signals is random.
    **options
        As in `simulate_motion`.

    Raises
    ------
    InvalidValueError
        For a rate, duration, step or seed that is not allowed.
    SimulationError
        When the motion grows without bound.
    """
    for machine, _ in cases:
        check_seed(sensor_effects(machine), seed)
    raw = simulate_raw(cases, duration_s=duration_s, rate_hz=rate_hz, **options)
    samples = math.floor(duration_s * rate_hz + 1e-9)
    return [
        _recorded(simulation, machine, rate_hz, samples, seed, stream)
        for stream, (simulation, (machine, _)) in enumerate(zip(raw, cases, strict=True))
    ]


def _recorded(
    simulation: Simulation, machine: Machine, rate_hz: float, samples: int, seed: int | None, stream: int
) -> Simulation:
    effects = sensor_effects(machine)
    if not effects:
        return simulation
    record = record_of(simulation, machine, output_rate_hz=rate_hz)
    record = run_chain(record, effects, samples=samples, seed=seed, stream=stream)
    return replace(
        simulation,
        signals=record.signals,
        rate_hz=rate_hz,
        phase_rad=record.phase_rad,
        speed_rad_s=record.speed_rad_s,
    )


def simulate_raw(cases: Sequence[Case], *, duration_s: float, rate_hz: float, **options: Any) -> list[Simulation]:
    """Return the motion of several machines as their measuring chains need it; see `simulate_batch`.

    The speed carries its effects. Where an effect on the recorded signals asks for it, the rate is a multiple of
    ``rate_hz`` and the record longer.
    """
    _check(duration_s, rate_hz, options.get("threads", 1), len(cases))
    wanted = [demand(sensor_effects(machine), rate_hz=rate_hz, duration_s=duration_s) for machine, _ in cases]
    results: list[Simulation | None] = [None] * len(cases)
    for factor, extra in dict.fromkeys(wanted):
        members = [i for i, own in enumerate(wanted) if own == (factor, extra)]
        length = duration_s + extra
        some = [(cases[i][0], _wandering(*cases[i], length)) for i in members]
        for i, run in zip(
            members, simulate_motion(some, duration_s=length, rate_hz=rate_hz * factor, **options), strict=True
        ):
            results[i] = run
    return [result for result in results if result is not None]


def _wandering(machine: Machine, speed: float | SpeedProfile, duration_s: float) -> SpeedProfile:
    changes = [e.speed_change(duration_s=duration_s) for e in machine.effects if isinstance(e, SpeedEffect)]
    return modulated(as_profile(speed), [change for change in changes if change is not None])


@single_blas_thread
def simulate_motion(
    cases: Sequence[Case],
    *,
    duration_s: float,
    rate_hz: float,
    step_s: float | None = None,
    settle_s: float | None = None,
    estimate_error: bool = False,
    threads: int = 1,
    modal: bool = True,
    highest_hz: float | None = None,
    probes: Sequence[str] = (),
) -> list[Simulation]:
    """Return the motion at the probes of several machines, without effects on speed and recording.

    Parameters
    ----------
    cases : sequence of (Machine, speed)
        Speed in revolutions a minute, or a `SpeedProfile`.
    duration_s, rate_hz : float
        Of the recorded signals; time 0 of a speed profile is their first sample.
    step_s : float, optional
        Longest integration step; the machine's own by default. The step is 1 / rate_hz over a whole number of 2 or
        more, as the output is low-pass filtered (flat up to 0.4 rate_hz) and decimated.
    settle_s : float, optional
        Time simulated before the recording, at the profile's first speed, from the static equilibrium.
    estimate_error : bool
        Run again with half the step and report the relative rms difference of each probe.
    threads : int
        Groups of lanes run in so many threads.
    modal : bool
        Use modal coordinates where they are accurate.
    highest_hz : float, optional
        Leave out modes above this frequency. Nothing replaces what they carry statically: the 1X acceleration of a
        housing falls by 40 % with half of its modes left out. Raise it until the lines of interest stay.
    probes : sequence of str
        Names of the probes to record; all when empty. Those with a limit are recorded in any case.

    Raises
    ------
    InvalidValueError
        For a rate, duration, step or probe that is not allowed.
    SimulationError
        When the motion grows without bound.
    """
    _check(duration_s, rate_hz, threads, len(cases))
    prepared = [_prepare(machine, speed, probes) for machine, speed in cases]
    results: list[Simulation | None] = [None] * len(cases)
    contacts = [contact_step_s(system) for system, _ in prepared]
    wanted = [_step(machine, rate_hz, step_s) for machine, _ in cases]
    steps = [max(own, math.ceil(1 / (rate_hz * most))) for own, most in zip(wanted, contacts, strict=True)]
    groups = _groups(prepared, steps)
    if threads > 1:
        smallest = max(1, math.ceil(len(cases) / threads))
        groups = [group[i : i + smallest] for group in groups for i in range(0, len(group), smallest)]

    def work(members: list[int]) -> None:
        lanes = LaneGroup(
            machines=[cases[i][0] for i in members],
            profiles=[prepared[i][1] for i in members],
            systems=[prepared[i][0] for i in members],
        )
        step = steps[members[0]]
        remark = _refined(lanes.systems, step, rate_hz) if step > wanted[members[0]] else ""
        settle = cases[members[0]][0].definition.settle_s if settle_s is None else settle_s
        options = {"duration_s": duration_s, "rate_hz": rate_hz, "settle_s": settle}
        signals = run_group(lanes, factor=step, modal=modal, highest_hz=highest_hz, **options)
        errors = [None] * len(members)
        if estimate_error:
            finer = run_group(lanes, factor=2 * step, modal=modal, highest_hz=highest_hz, **options)
            errors = [relative_error(a, b) for a, b in zip(signals, finer, strict=True)]
        for i, own, error in zip(members, signals, errors, strict=True):
            results[i] = _result(cases[i][0], *prepared[i], own, rate_hz, 1 / (rate_hz * step), error, remark)

    if threads > 1 and len(groups) > 1:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(work, groups))
    else:
        for group in groups:
            work(group)
    return [result for result in results if result is not None]


def contact_step_s(system: System) -> float:
    """Return the longest step that the stiffest contact of a system allows, infinite without contact.

    A contact of stiffness k between parts of mobility c = C L B (the displacement's acceleration under a unit force)
    oscillates at sqrt(k c). The linear core knows nothing of it, so that an explicit stage must resolve it.
    """
    longest = math.inf
    for k, force in enumerate(system.forces):
        if force.law.stiffest is None:
            continue
        reads = system.motion_rows[system.inputs[k][: len(force.displacements)]]
        mobility = np.abs(reads @ system.core @ system.force_columns[:, system.outputs[k]])
        stiffness = force.law.stiffest(np.array(force.parameters))
        frequency = math.sqrt(stiffness * float(mobility.max())) if mobility.size else 0.0
        if frequency > 0:
            longest = min(longest, 1 / (STEPS_OF_CONTACT * frequency))
    if longest < SHORTEST_STEP_S:
        raise InvalidValueError(
            f"A contact of this machine needs steps of {longest:.2g} s; allowed: {SHORTEST_STEP_S:g} s or more. "
            "Give it a lower contact stiffness."
        )
    return longest


def _refined(systems: list[System], factor: int, rate_hz: float) -> str:
    stiff = sorted({force.name for system in systems for force in system.forces if force.law.stiffest is not None})
    return (
        f"The step was shortened to {1 / (rate_hz * factor):.3g} s, as the contact stiffness of {', '.join(stiff)} "
        "asks for."
    )


def relative_error(coarse: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """Return the rms difference of each probe over the rms of its alternating part, shape (probes,).

    0 for a probe that stands still: rounding over rounding says nothing.
    """
    difference = np.sqrt(np.mean((coarse - fine) ** 2, axis=1))
    scale = np.sqrt(np.mean((fine - fine.mean(axis=1, keepdims=True)) ** 2, axis=1))
    return np.where(scale > SILENT, difference / np.maximum(scale, SILENT), 0.0)


def _check(duration_s: float, rate_hz: float, threads: int, cases: int) -> None:
    for name, value in (("duration_s", duration_s), ("rate_hz", rate_hz), ("threads", threads)):
        if not (math.isfinite(value) and value > 0):
            raise InvalidValueError(f"{name} = {value!r}; allowed: finite and more than 0. Correct it.")
    if duration_s * rate_hz < 1:
        raise InvalidValueError(
            f"{duration_s:g} s at {rate_hz:g} Hz has no sample; allowed: {1 / rate_hz:g} s or more. "
            "Give a longer duration."
        )
    if cases == 0:
        raise InvalidValueError("No case to simulate; allowed: one or more pairs of machine and speed. Give one.")


def _prepare(machine: Machine, speed: float | SpeedProfile, probes: Sequence[str]) -> tuple[System, SpeedProfile]:
    profile = as_profile(speed)
    system = machine.system(speed_rpm=profile)
    return system.with_probes(probes) if probes else system, profile


def _groups(prepared: list[tuple[System, SpeedProfile]], steps: list[int]) -> list[list[int]]:
    """Return the cases that may run side by side: same matrices, same laws in the same order, each its own step.

    A stiffer contact beside it must not shorten the step of a run: what a run gives does not depend on the others.
    """
    groups: dict[tuple[object, ...], list[int]] = {}
    for i, (system, _) in enumerate(prepared):
        key = (
            system.core.tobytes(),
            system.force_columns.tobytes(),
            system.motion_rows.tobytes(),
            system.probe_rows.tobytes(),
            tuple((id(force.law), len(force.parameters), _counts(force)) for force in system.forces),
            tuple(row.tobytes() for row in (*system.inputs, *system.outputs)),
            steps[i],
        )
        groups.setdefault(key, []).append(i)
    return [
        members[start : start + MOST_LANES]
        for members in groups.values()
        for start in range(0, len(members), MOST_LANES)
    ]


def _counts(force: InterfaceForce) -> tuple[float, ...]:
    return tuple(force.parameters[row] for row in force.law.counts)


def _step(machine: Machine, rate_hz: float, step_s: float | None) -> int:
    """Return how many steps make one output sample."""
    longest = machine.definition.step_s if step_s is None else step_s
    if not (math.isfinite(longest) and longest > 0):
        raise InvalidValueError(f"step_s = {longest!r}; allowed: finite and more than 0. Correct it.")
    return max(2, math.ceil(1 / (rate_hz * longest) - 1e-9))


def _result(
    machine: Machine,
    system: System,
    profile: SpeedProfile,
    signals: np.ndarray,
    rate_hz: float,
    step_s: float,
    error: np.ndarray | None,
    remark: str,
) -> Simulation:
    who = machine.in_short
    if not np.all(np.abs(signals) < LARGEST):
        raise SimulationError(
            f"The simulation of {who} grew beyond all bounds or became not a number. Allowed: a motion that stays "
            f"bounded. Make effects weaker or change the speed; in Python, step_s below {step_s:.3g} tells whether the "
            "step or the machine is unstable."
        )
    quarter = signals.shape[1] // 4
    if profile.is_steady and quarter > 8:
        first, last = signals[:, :quarter].std(axis=1), signals[:, -quarter:].std(axis=1)
        grown = (last > DRIFT * first) & (last > 1e-12)
        if grown.any():
            name = system.probes[int(np.argmax(grown))].name
            raise SimulationError(
                f"The simulation of {who} drifts: {name} is {last[grown][0] / max(first[grown][0], 1e-300):.3g} times "
                "stronger at the end than at the start. The machine is unstable with these parameters, or it "
                "needs a longer settle_s."
            )
    notes = [*system.notes, *([remark] if remark else [])]
    for probe, signal in zip(system.probes, signals, strict=True):
        peak = float(np.abs(signal).max())
        if probe.limit is not None and peak > probe.limit:
            notes.append(
                f"{probe.name} reaches {peak:.3g} {probe.unit}, limit {probe.limit:.3g}: {probe.limit_message}"
            )
    time = np.arange(signals.shape[1]) / rate_hz
    result = Simulation(
        signals=signals,
        rate_hz=rate_hz,
        probes=system.probes,
        phase_rad=profile.phase_rad(time),
        speed_rad_s=profile.speed_rad_s(time),
        step_s=step_s,
        notes=tuple(notes),
    )
    return result if error is None else replace(result, errors=error)
