"""Three numbers of the simulated rig, calibrated on 1X of the Analog Devices bench at 1200 and 2400 rpm.

Fitted are the residual unbalance and, of the box that stands for the plate's inertia, its width and its centre. Above
its mounts' modes the machine is held by its own inertia, which therefore decides radial 1X: 10 % of the stiffness of
mounts, housings, bearings or coupling change it by less than 0.1 dB, and what does not show cannot be calibrated.
(Length and mass of the box and the height of the shaft act like its width; freed as well, they stay where they were.)
The seeded imbalance records share the healthy assembly and show how the bench answers to unbalance. Their grams are not
documented: each class has one free factor, the same at all speeds. 1800 rpm is held out.

Z is not fitted. In the seeded records it grows between 1800 and 2400 rpm with the fifth to seventh power of speed; no
rigid plate on soft mounts can do that, and the model leaves the axial force of the coupling out.

Least squares of differences in dB over 3 dB, with the parameters' priors (normal in the logarithm for a log-normal one,
of the same mean and variance for a uniform one, and within its ends). Intervals: twice the standard deviation from the
slopes, without the prior's ends.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
from rotorwise.datasets import read
from rotorwise.diagnose.signal.order_tracking import constant_speed_phase, order_amplitudes
from rotorwise.diagnose.signal.spectrum import averaged_power_density
from rotorwise.diagnose.signal.speed import speed_from_vibration
from rotorwise.simulators.machine import Machine, find_machine
from rotorwise.simulators.parameter import LogNormal, Uniform
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import DATA, HERE, IMBALANCE, adi

#: Assumed: the sensor's range is not documented. 80 mV/g would make every measured number a quarter (-12 dB).
VOLTS_PER_G = 0.020
STANDARD_GRAVITY = 9.80665
ORDERS = (1, 2, 3, 4, 5, 6)
EDGES_HZ = (10.0, 45.0, 200.0, 1000.0, 2000.0, 4000.0, 8000.0)
AXES = ("X", "Y", "Z")
#: Places in AXES of what is fitted.
RADIAL = (0, 1)
HEALTHY = "BaLo"
FITTED_SPEEDS = ("1200", "2400")
HELD_OUT_SPEED = "1800"
PLATE = ("base_width_m", "base_centre_m")
UNBALANCE = "residual_unbalance_kg_m"
#: A difference that counts as right, and the standard deviation in the fit.
RIGHT_DB = 3.0


@dataclass(frozen=True)
class Measured:
    """A record: lines as peak amplitudes (axes, orders), bands as rms (axes, bands), m/s2, and their spread in dB."""

    shaft_hz: float
    lines: np.ndarray
    lines_spread_db: np.ndarray
    bands: np.ndarray
    bands_spread_db: np.ndarray


@dataclass(frozen=True)
class Arrangement:
    """Which housing carries the sensor and which of its directions each of the sensor's axes is."""

    housing: str = "b"
    directions: tuple[str, ...] = ("x", "y", "axial")

    @property
    def probes(self) -> tuple[str, ...]:
        """Names of the probes, in the order of the axes."""
        return tuple(f"housing_{self.housing}_{direction}" for direction in self.directions)


@dataclass(frozen=True)
class Calibration:
    """Calibrated values with half intervals (in the logarithm where the prior is log-normal), and how well they fit."""

    values: dict[str, float]
    half_intervals: dict[str, float]
    seeded_kg_m: dict[str, float]
    cost: float
    arrangement: Arrangement = field(default_factory=Arrangement)

    def interval(self, name: str) -> tuple[float, float]:
        """Return the ends of the interval of about 95 %."""
        value, half = self.values[name], self.half_intervals[name]
        if isinstance(_prior(name), LogNormal):
            return value * math.exp(-half), value * math.exp(half)
        return value - half, value + half


def band_levels(signals: np.ndarray, rate_hz: float) -> np.ndarray:
    """Return the rms in each band, shape (channels, bands), from Welch segments of at most 0.5 s."""
    frequency, density = averaged_power_density(signals, rate_hz=rate_hz, segment_samples=round(rate_hz / 2))
    parts = [density[:, (frequency >= low) & (frequency < high)].sum(axis=1) for low, high in pairwise(EDGES_HZ)]
    return np.sqrt(np.stack(parts, axis=1) * frequency[1])


@cache
def recorded(speed: str, load: str = HEALTHY) -> tuple[np.ndarray, float]:
    """Return a record's three channels in volts without their mean, and its sampling rate in Hz."""
    recording = read(DATA / adi(speed, load=load), sidecar=HERE / "adi_limerick.toml")
    return recording.signals - recording.signals.mean(axis=1, keepdims=True), recording.rate_hz


@cache
def measured(speed: str, load: str = HEALTHY) -> Measured:
    """Return speed, lines and bands of a record; spreads come from eight (lines) and four (bands) parts of it."""
    volts, rate_hz = recorded(speed, load)
    signals = volts / VOLTS_PER_G * STANDARD_GRAVITY
    defects = find_bearing("ER-12K").defect_orders()
    estimate = speed_from_vibration(
        signals,
        rate_hz=rate_hz,
        hint_hz=float(speed) / 60,
        bearing_orders=(defects.outer_race, defects.inner_race),
    )
    assert estimate is not None
    turns = constant_speed_phase(samples=signals.shape[1], rate_hz=rate_hz, speed_hz=estimate.speed_hz)
    lines, deviation = order_amplitudes(signals, phase_turns=turns, orders=list(ORDERS))
    quarters = np.array([band_levels(part, rate_hz) for part in np.array_split(signals, 4, axis=1)])
    return Measured(
        estimate.speed_hz,
        np.abs(lines),
        20 * np.log10(1 + deviation / np.abs(lines)),
        band_levels(signals, rate_hz),
        (20 * np.log10(quarters)).std(axis=0, ddof=1),
    )


def bench() -> Machine:
    """Return the bench before calibration: preset "adi" with the calibrated parameters at their defaults."""
    machine = find_machine("test_rig").preset("adi")
    defaults = {one.name: one.default for one in machine.definition.parameters}
    return machine.with_parameters(**{name: defaults[name] for name in (*PLATE, UNBALANCE)})


def unbalance_response(machine: Machine, shaft_hz: Sequence[float], arrangement: Arrangement) -> np.ndarray:
    """Return |1X| in m/s2 for 1 kg.m on the disc, shape (speeds, axes); the matrices are those of the first speed.

    The same as harmonic balance of order 1 with the residual unbalance alone, without its static part.
    """
    system = machine.system(speed_rpm=60 * shaft_hz[0])
    number = next(n for n, force in enumerate(system.forces) if force.name == "residual unbalance")
    names = [probe.name for probe in system.probes]
    rows = [names.index(probe) for probe in arrangement.probes]
    result = []
    for one in shaft_hz:
        omega = 2 * math.pi * one
        force = np.zeros(system.force_columns.shape[1], dtype=complex)
        force[system.outputs[number]] = omega**2 * np.array([1.0, -1j])
        state = np.linalg.solve(1j * omega * np.eye(system.states) - system.core, system.force_columns @ force)
        result.append(np.abs(system.probe_rows[rows] @ state + system.probe_columns[rows] @ force))
    return np.array(result)


def differences_db(
    machine: Machine, speeds: Sequence[str], arrangement: Arrangement, loads: Sequence[str] = (HEALTHY, *IMBALANCE)
) -> np.ndarray:
    """Return 1X of 1 kg.m over measured 1X in dB, shape (loads, speeds, axes)."""
    result = np.empty((len(loads), len(speeds), len(AXES)))
    for number, speed in enumerate(speeds):
        records = [measured(speed, load) for load in loads]
        model = unbalance_response(machine, [one.shaft_hz for one in records], arrangement)
        result[:, number] = 20 * np.log10(model / np.array([one.lines[:, 0] for one in records]))
    return result


def _prior(name: str) -> LogNormal | Uniform:
    prior = next(one.prior for one in bench().definition.parameters if one.name == name)
    assert isinstance(prior, LogNormal | Uniform)
    return prior


def _scale(name: str) -> tuple[float, float]:
    """Return mean and standard deviation of the prior, of the logarithm for a log-normal one."""
    prior = _prior(name)
    if isinstance(prior, LogNormal):
        return math.log(prior.median), math.log(prior.factor)
    return (prior.low + prior.high) / 2, (prior.high - prior.low) / math.sqrt(12)


def _values(names: Sequence[str], normal: np.ndarray) -> dict[str, float]:
    """Return parameter values of deviations from the priors' means in standard deviations."""
    values = {}
    for name, one in zip(names, normal, strict=True):
        mean, deviation = _scale(name)
        number = mean + deviation * float(one)
        values[name] = math.exp(number) if isinstance(_prior(name), LogNormal) else number
    return values


def seeded_unbalance_kg_m(machine: Machine, arrangement: Arrangement) -> dict[str, float]:
    """Return the unbalance of each class that explains its radial 1X at the fitted speeds best."""
    offsets = differences_db(machine, FITTED_SPEEDS, arrangement, IMBALANCE)[..., RADIAL].mean(axis=(1, 2))
    return dict(zip(IMBALANCE, (10 ** (-offsets / 20)).tolist(), strict=True))


def calibrate(arrangement: Arrangement | None = None) -> Calibration:
    """Return the values that explain radial 1X at the fitted speeds best."""
    where, names = arrangement or Arrangement(), (*PLATE, UNBALANCE)

    def residuals(normal: np.ndarray) -> np.ndarray:
        values = _values(names, normal)
        unbalance = values.pop(UNBALANCE)
        difference = differences_db(bench().with_parameters(**values), FITTED_SPEEDS, where)[..., RADIAL]
        difference[0] += 20 * math.log10(unbalance)
        # The free factor of a seeded class is its mean difference: no search needed.
        difference[1:] -= difference[1:].mean(axis=(1, 2), keepdims=True)
        return np.concatenate([difference.ravel() / RIGHT_DB, normal])

    # A uniform prior ends sqrt(3) standard deviations from its mean.
    ends = np.array([3.0 if isinstance(_prior(name), LogNormal) else math.sqrt(3) for name in names])
    # Steps of the usual size are lost in rounding, and the search then ends where the number of threads lets it.
    found = least_squares(residuals, np.zeros(len(names)), jac="3-point", diff_step=1e-3, bounds=(-ends, ends))
    covariance = np.linalg.inv(found.jac.T @ found.jac)
    values = _values(names, found.x)
    halves = {name: 2 * _scale(name)[1] * math.sqrt(covariance[i, i]) for i, name in enumerate(names)}
    seeded = seeded_unbalance_kg_m(bench().with_parameters(**values), where)
    return Calibration(values, halves, seeded, float(found.cost), where)


def errors_db(
    machine: Machine, speed: str, arrangement: Arrangement, seeded_kg_m: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return simulated over measured 1X in dB: of the healthy record (axes), of the seeded ones (classes, axes)."""
    unit = differences_db(machine, (speed,), arrangement)[:, 0]
    amounts = np.array([machine.values[UNBALANCE], *(seeded_kg_m[load] for load in IMBALANCE)])
    difference = unit + 20 * np.log10(amounts)[:, None]
    return difference[0], difference[1:]


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
