"""Labelled cases: a machine, a record of it in some state, and a healthy record of the same machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import impact_sources as knock
import numpy as np
import shaft_sources as shaft
from machine import Machine, draw_machine
from nonlinear import journal, loose_support
from rotorwise.datasets.recording import OperatingCondition, Recording
from scipy import fft
from sensors import DEFECTS, housing_channels, probe_channels, remount_curve_db
from structure import (
    LEAD_SECONDS,
    Clock,
    Floats,
    acceleration_spectrum,
    band_rms,
    housing_velocity,
    to_time,
    true_velocity,
)

FAULTS = (
    "unbalance", "misalignment", "bent_shaft", "looseness", "rub", "oil_whirl", "bearing_outer_race",
    "bearing_inner_race", "bearing_ball", "bearing_cage", "gear_wear", "gear_tooth_fault", "gear_eccentricity",
    "electrical", "resonance", "sensor_fault",
)  # fmt: skip
OUTSIDE = ("cavitation", "belt_defect", "blade_pass", "plate_rattle")
BENIGN = ("healthy", "at_rest")


@dataclass(frozen=True, eq=False)
class Case:
    """A labelled record with its baseline; ``velocity`` is each channel's true rms, 10-1000 Hz, in m/s."""

    label: str
    variant: str
    recording: Recording
    baseline: Recording
    remounted: bool
    size: float
    velocity: Floats


@dataclass(frozen=True, eq=False)
class Run:
    """One record's motion before the sensors: acceleration spectra [6, bin], or probe signals."""

    spectra: np.ndarray
    velocity: Floats
    clock: Clock
    probes: Floats | None = None
    angle: Floats | None = None
    variant: str = ""
    size: float = 0.0


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_clock(rng: np.random.Generator, machine: Machine, rate_hz: float | None) -> Clock:
    if rate_hz is None:
        low = machine.kind in ("gearbox",)
        choices = [12800, 20000, 25600, 48000, 50000] if low else [5000, 5120, 10000, 12800, 20000, 25600, 48000, 50000]
        rate_hz = float(rng.choice(choices[:4] if machine.kind == "turbine" else choices))
    seconds = min(log_uniform(rng, 1.0, 20.0), 150e3 / rate_hz)
    lead = round(LEAD_SECONDS * rate_hz)
    samples = int(fft.next_fast_len(round(seconds * rate_hz) + lead) or 0) - lead
    return Clock(rate_hz, max(2, int(np.ceil(40000 / rate_hz))), samples)


def build_case(seed: int, index: int, label: str) -> Case:
    """Build case ``index`` of a set; the same arguments give the same case."""
    rng = np.random.default_rng([seed, index])
    machine = draw_machine(rng, label)
    calm = machine.structure
    speed = machine.speed_hz
    clock = draw_clock(rng, machine, None)
    before = simulate(
        machine, draw_clock(rng, machine, clock.rate_hz), "healthy", speed * rng.uniform(0.98, 1.02), rng, label
    )
    if label == "resonance":
        mode = int(rng.integers(4))
        machine.structure = calm.with_resonance(mode, speed * rng.uniform(0.95, 1.05), rng.uniform(0.01, 0.04))
    after = simulate(machine, clock, label, speed, rng, label)
    remounted = bool(rng.random() < 1 / 3)
    count = len(machine.coordinates)
    change = np.repeat(rng.uniform(-1, 1, (count, 1)), 5, axis=1)
    if remounted:
        change = np.array([remount_curve_db(rng) for _ in range(count)])
    hint = None if rng.random() < 0.08 else speed * 60 * (1 + rng.uniform(-0.05, 0.05))
    defect = str(rng.choice(DEFECTS)) if label == "sensor_fault" else None
    unit_known = bool(rng.random() > 0.04)
    recording = record(machine, after, rng, hint, None, defect, unit_known)
    baseline = record(machine, before, rng, hint, change, None, unit_known)
    velocity = after.velocity[list(machine.coordinates)] if after.probes is None else np.zeros(count)
    return Case(label, defect or after.variant, recording, baseline, remounted, after.size, velocity)


def record(
    machine: Machine,
    run: Run,
    rng: np.random.Generator,
    hint_rpm: float | None,
    change_db: np.ndarray | None,
    defect: str | None,
    unit_known: bool,
) -> Recording:
    if run.probes is not None and run.angle is not None:
        signals, channels = probe_channels(run.probes, run.angle, run.clock, machine, rng, change_db)
    else:
        signals, channels = housing_channels(
            run.spectra, run.clock, machine, rng, change_db=change_db, defect=defect, unit_known=unit_known
        )
    condition = OperatingCondition(speed_rpm=hint_rpm)
    return Recording(signals, run.clock.rate_hz, channels, condition, machine.nameplate)


def simulate(machine: Machine, clock: Clock, state: str, speed_hz: float, rng: np.random.Generator, label: str) -> Run:
    """Motion of the machine in a state; the first call, healthy, fixes the size of each source."""
    if state == "at_rest":
        return _standing(machine, clock, rng)
    angle = shaft.shaft_angle(rng, clock, speed_hz, rng.uniform(0, 0.005))
    if machine.kind == "turbine":
        return _turbine(machine, clock, angle, state, speed_hz, rng, label)
    rest, drive = _sound(machine, clock, angle, speed_hz, rng)
    level = float(np.max(housing_velocity(rest, clock)[list(machine.coordinates)]))
    fault, size, variant = _fault(machine, clock, angle, state, rng, rest, drive, level)
    total = rest + fault
    return Run(total, true_velocity(total, clock), clock, variant=variant, size=size)


def _scaled(machine: Machine, clock: Clock, name: str, force: Floats, target: float, measure: str) -> np.ndarray:
    spectrum = acceleration_spectrum(machine.structure, force, clock)
    if name not in machine.gains:
        machine.gains[name] = target / _size(machine, clock, spectrum, measure)
    return machine.gains[name] * spectrum


def _size(machine: Machine, clock: Clock, spectrum: np.ndarray, measure: str) -> float:
    seen = spectrum[list(machine.coordinates)]
    if measure == "velocity":
        return float(np.max(housing_velocity(seen, clock)))
    return float(np.max(band_rms(seen, clock, 5.0, clock.rate_hz)))


def _sound(
    machine: Machine, clock: Clock, angle: Floats, speed_hz: float, rng: np.random.Generator
) -> tuple[np.ndarray, Floats]:
    """Sound machine: acceleration spectra, and the unbalance force that drives a loose support."""
    own = machine.details("levels")
    load, faster = rng.uniform(0.8, 1.2), (speed_hz / machine.speed_hz) ** 2
    first = log_uniform(own, 0.2e-3, 2.0e-3)
    turning = shaft.unbalance(machine, angle) * faster
    kind = str(own.choice(["parallel", "angular", "combined"]))
    coupling = shaft.misalignment(machine, angle, machine.details("coupling"), kind)
    parts: list[tuple[str, Floats, float, str]] = [
        ("unbalance", turning, first, "velocity"),
        ("coupling", coupling, first * own.uniform(0.05, 0.3), "velocity"),
        ("ball pass", knock.ball_pass(machine, angle) * load, log_uniform(own, 0.01e-3, 0.2e-3), "velocity"),
        ("broadband", shaft.broadband(rng, clock) * load, log_uniform(own, 0.05, 1.5), "acceleration"),
    ]
    if machine.kind == "motor":
        parts.append(("air gap", shaft.air_gap(machine, clock, rng), log_uniform(own, 0.03e-3, 0.4e-3), "velocity"))
    if own.random() < 0.4:
        parts.append(("neighbour", shaft.neighbour(machine, clock, rng), log_uniform(own, 0.05e-3, 0.5e-3), "velocity"))
    if machine.kind == "gearbox":
        teeth = knock.mesh(machine, angle, "sound", 0.0, rng) * load
        parts.append(("mesh", teeth, log_uniform(own, 0.5, 8.0), "acceleration"))
    total = sum(_scaled(machine, clock, *part) for part in parts)
    return np.asarray(total), turning * machine.gains["unbalance"]


def _fault(
    machine: Machine,
    clock: Clock,
    angle: Floats,
    state: str,
    rng: np.random.Generator,
    rest: np.ndarray,
    drive: Floats,
    level: float,
) -> tuple[np.ndarray, float, str]:
    """Added motion, its size and the variant. Sizes: velocity over the rest, or impact peak over the rest's rms."""
    if state in BENIGN or state in ("resonance", "sensor_fault"):
        return np.zeros_like(rest), 0.0, ""
    if state.startswith("gear"):
        return _gear_fault(machine, clock, angle, state, rng, rest)
    if state.startswith("bearing") or state == "plate_rattle":
        if state == "plate_rattle":
            force = knock.rattle(angle, clock, rng)
        else:
            bearing = machine.bearings[int(rng.random() < 0.3)]
            force = knock.defect(machine, bearing, state.removeprefix("bearing_"), angle, clock, rng)
        size = log_uniform(rng, 1.2, 12.0)
        return _impulsive(machine, clock, force, rest, size), size, ""
    force, variant = _line_force(machine, clock, angle, state, rng, drive)
    size = _line_size(state, level, rng)
    spectrum = acceleration_spectrum(machine.structure, force, clock)
    return spectrum * (size * level / _size(machine, clock, spectrum, "velocity")), size, variant


def _line_size(state: str, level: float, rng: np.random.Generator) -> float:
    if state == "unbalance":
        return max(3.0, log_uniform(rng, 2.8e-3, 14e-3) / level)
    if state == "bent_shaft":
        return max(2.5, log_uniform(rng, 2e-3, 10e-3) / level)
    if state == "electrical":
        return log_uniform(rng, 0.6, 5.0)
    if state == "looseness":
        return log_uniform(rng, 1.0, 6.0)
    return log_uniform(rng, 0.5, 6.0)


def _line_force(
    machine: Machine, clock: Clock, angle: Floats, state: str, rng: np.random.Generator, drive: Floats
) -> tuple[Floats, str]:
    if state == "misalignment":
        kind = str(rng.choice(["parallel", "angular", "combined"]))
        return shaft.misalignment(machine, angle, rng, kind), kind
    if state == "electrical":
        kind = str(rng.choice(["air gap", "air gap with pole pass", "rotor bars"]))
        if kind == "rotor bars":
            return shaft.rotor_bars(machine, clock, angle, rng), kind
        return shaft.air_gap(machine, clock, rng, rng.uniform(0.2, 0.8) if "with" in kind else 0.0), kind
    if state == "looseness":
        mode = 2
        mass, own = machine.structure.mass_kg[mode], float(machine.structure.frequency_hz[mode])
        extra = loose_support(drive[1] / mass, clock.fine_rate_hz, own, rng) * mass
        force = np.zeros_like(drive)
        force[1] = drive[1] + extra
        return force, ""
    if state == "rub":
        own = machine.details("journal")
        moved = journal(angle, clock.fine_rate_hz, machine.speed_hz, "rub", 1.0, rng, own)
        force = np.zeros((6, angle.size))
        force[0], force[1] = -moved[2], -moved[3]
        force[3], force[4] = 0.4 * force[0], 0.4 * force[1]
        return force, "housing"
    simple: dict[str, Callable[[], Floats]] = {
        "unbalance": lambda: shaft.unbalance(machine, angle),
        "bent_shaft": lambda: shaft.bent_shaft(angle, rng),
        "cavitation": lambda: shaft.cavitation(clock, rng),
        "belt_defect": lambda: shaft.belt(machine, clock, angle, rng),
        "blade_pass": lambda: shaft.blades(clock, angle, rng),
    }
    return simple[state](), ""


def _impulsive(machine: Machine, clock: Clock, force: Floats, rest: np.ndarray, size: float) -> np.ndarray:
    """Scale impacts so that, on the best channel above 800 Hz, their peaks are ``size`` times the rest's rms."""
    spectrum = acceleration_spectrum(machine.structure, force, clock)
    places = list(machine.coordinates)
    high = clock.frequencies_hz() > min(800.0, 0.15 * clock.rate_hz)
    peaks = np.percentile(np.abs(to_time(spectrum[places] * high, clock)), 99.8, axis=1)
    return spectrum * (size / float(np.max(peaks / band_rms(rest[places] * high, clock, 0.0, 1e9))))


def _gear_fault(
    machine: Machine, clock: Clock, angle: Floats, state: str, rng: np.random.Generator, rest: np.ndarray
) -> tuple[np.ndarray, float, str]:
    size, seed = log_uniform(rng, 0.4, 3.0), int(rng.integers(2**31))
    bad = knock.mesh(machine, angle, state, size, np.random.default_rng(seed))
    sound = knock.mesh(machine, angle, "sound", 0.0, np.random.default_rng(seed))
    added = machine.gains["mesh"] * acceleration_spectrum(machine.structure, bad - sound, clock)
    if state == "gear_tooth_fault":
        strikes = knock.tooth_strikes(machine, angle, clock, np.random.default_rng(seed))
        added = added + _impulsive(machine, clock, strikes, rest, 2.0 * size)
    return added, size, ""


def _standing(machine: Machine, clock: Clock, rng: np.random.Generator) -> Run:
    """A machine at rest: floor noise, sometimes a neighbour that runs."""
    spectra = acceleration_spectrum(machine.structure, shaft.broadband(rng, clock), clock)
    spectra *= log_uniform(rng, 1e-4, 3e-3) / _size(machine, clock, spectra, "acceleration")
    variant = ""
    if rng.random() < 0.4:
        other = acceleration_spectrum(machine.structure, shaft.neighbour(machine, clock, rng), clock)
        spectra += other * (log_uniform(rng, 0.01e-3, 0.2e-3) / _size(machine, clock, other, "velocity"))
        variant = "neighbour runs"
    return Run(spectra, true_velocity(spectra, clock), clock, variant=variant)


def _turbine(
    machine: Machine, clock: Clock, angle: Floats, state: str, speed_hz: float, rng: np.random.Generator, label: str
) -> Run:
    """Shaft motion at one or two oil-film bearings, in metres."""
    own = machine.details("levels")
    target = log_uniform(own, 4e-6, 30e-6)
    size = 0.0
    film = "rub without contact" if label == "rub" else "sound"
    if state in ("oil_whirl", "rub"):
        film, size = state, log_uniform(rng, 4.0, 20.0) if state == "oil_whirl" else 0.0
    shapes, probes = (1.0, own.uniform(0.4, 0.9)), []
    for end in range(len(machine.coordinates) // 2):
        details = machine.details(f"journal {end if state != 'rub' and label != 'rub' else 0}")
        moved = journal(angle, clock.fine_rate_hz, machine.speed_hz, film, size, rng, details)[:2]
        key = f"journal {end}"
        if key not in machine.gains:
            machine.gains[key] = shapes[end] * target / (np.sqrt(2) * float(np.std(moved[0, moved.shape[1] // 4 :])))
        probes.append(machine.gains[key] * moved)
    shaft_motion = np.vstack(probes)
    if state == "unbalance":
        size = max(3.0, log_uniform(rng, 30e-6, 100e-6) / target)
        shaft_motion = shaft_motion * size
    spectra = np.zeros((6, 1), dtype=complex)
    coarse = _thin(shaft_motion, clock)
    return Run(spectra, np.zeros(6), clock, coarse, angle[clock.lead * clock.factor :: clock.factor], "probes", size)


def _thin(signal: Floats, clock: Clock) -> Floats:
    spectrum = np.fft.rfft(signal, axis=-1)[..., : (clock.samples + clock.lead) // 2 + 1] / clock.factor
    spectrum = spectrum / (1 + (clock.frequencies_hz() / (0.43 * clock.rate_hz)) ** 40)
    return to_time(spectrum, clock)
