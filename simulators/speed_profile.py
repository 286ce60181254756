"""Shaft speed over time, with its phase integrated exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .errors import InvalidValueError


@dataclass(frozen=True)
class SpeedProfile:
    """Piecewise linear speed of the reference shaft; constant before the first and after the last knot.

    Parameters
    ----------
    times_s : tuple of float
        Knots, increasing.
    speeds_rad_s : tuple of float
        Speed at each knot.
    """

    times_s: tuple[float, ...]
    speeds_rad_s: tuple[float, ...]

    def __post_init__(self) -> None:
        times, speeds = np.asarray(self.times_s, float), np.asarray(self.speeds_rad_s, float)
        if times.ndim != 1 or times.size != speeds.size or times.size < 1:
            raise InvalidValueError(
                f"Speed profile with {times.size} times and {speeds.size} speeds; allowed: as many times as speeds, "
                "one or more. Give both lists with the same length."
            )
        if not (np.all(np.isfinite(times)) and np.all(np.isfinite(speeds)) and np.all(np.diff(times) > 0)):
            raise InvalidValueError(
                "Speed profile with times that do not increase or values that are not finite; "
                "allowed: finite numbers, increasing times."
            )
        object.__setattr__(self, "times_s", tuple(times.tolist()))
        object.__setattr__(self, "speeds_rad_s", tuple(speeds.tolist()))

    @property
    def is_steady(self) -> bool:
        """Whether the speed never changes."""
        return len(set(self.speeds_rad_s)) == 1

    @property
    def mean_speed_rad_s(self) -> float:
        """Mean of lowest and highest speed: where a linear model is best centred."""
        return (min(self.speeds_rad_s) + max(self.speeds_rad_s)) / 2

    def speed_rad_s(self, time_s: np.ndarray) -> np.ndarray:
        """Return the speed at each time, same shape."""
        return np.interp(time_s, self.times_s, self.speeds_rad_s)

    def acceleration_rad_s2(self, time_s: np.ndarray) -> np.ndarray:
        """Return the angular acceleration at each time; at a knot, the one after it."""
        times, speeds = np.asarray(self.times_s), np.asarray(self.speeds_rad_s)
        slopes = np.concatenate([[0.0], np.diff(speeds) / np.diff(times), [0.0]])
        return slopes[np.searchsorted(times, time_s, side="right")]

    def phase_rad(self, time_s: np.ndarray) -> np.ndarray:
        """Return the shaft angle at each time: the exact integral of the speed, 0 at the first knot."""
        time_s = np.asarray(time_s, float)
        times, speeds = np.asarray(self.times_s), np.asarray(self.speeds_rad_s)
        if self.is_steady:
            return speeds[0] * (time_s - times[0])
        at_knots = np.concatenate([[0.0], np.cumsum(np.diff(times) * (speeds[1:] + speeds[:-1]) / 2)])
        index = np.clip(np.searchsorted(times, time_s, side="right") - 1, 0, times.size - 1)
        since = time_s - times[index]
        acceleration = np.where(since >= 0, self.acceleration_rad_s2(times[index]), 0.0)
        return at_knots[index] + since * (speeds[index] + acceleration * since / 2)


def steady(*, speed_rpm: float) -> SpeedProfile:
    """Return a constant speed."""
    return SpeedProfile((0.0,), (_radians_per_second(speed_rpm),))


def ramp(*, start_rpm: float, stop_rpm: float, duration_s: float) -> SpeedProfile:
    """Return a run-up (or run-down) at constant acceleration, starting at time 0."""
    if not (math.isfinite(duration_s) and duration_s > 0):
        raise InvalidValueError(f"Ramp of {duration_s} s; allowed: more than 0. Give its duration.")
    return SpeedProfile((0.0, duration_s), (_radians_per_second(start_rpm), _radians_per_second(stop_rpm)))


def wander(*, speed_rpm: float, deviation: float, bandwidth_hz: float, duration_s: float, seed: int) -> SpeedProfile:
    """Return a speed that wanders randomly about its mean.

    Parameters
    ----------
    speed_rpm : float
        Mean.
    deviation : float
        Standard deviation of the speed over its mean (0.01 is one percent).
    bandwidth_hz : float
        The wander is low-pass noise up to this frequency.
    duration_s : float
    seed : int
    """
    if not (0 <= deviation < 0.3 and bandwidth_hz > 0 and duration_s > 0):
        raise InvalidValueError(
            f"Speed wander {deviation:g} with bandwidth {bandwidth_hz:g} Hz over {duration_s:g} s; allowed: 0 to 0.3, "
            "more than 0, more than 0."
        )
    count = max(3, math.ceil(duration_s * bandwidth_hz * 8) + 1)
    generator = np.random.default_rng(seed)
    spectrum = np.fft.rfft(generator.normal(size=count))
    frequencies = np.fft.rfftfreq(count, duration_s / (count - 1))
    spectrum[(frequencies > bandwidth_hz) & (np.arange(frequencies.size) > 1)] = 0.0
    spectrum[0] = 0.0
    noise = np.fft.irfft(spectrum, count)
    noise *= deviation / noise.std()
    times = np.linspace(0.0, duration_s, count)
    return SpeedProfile(tuple(times), tuple(_radians_per_second(speed_rpm) * (1 + noise)))


def modulated(profile: SpeedProfile, changes: Sequence[tuple[np.ndarray, np.ndarray]]) -> SpeedProfile:
    """Return the profile with its speed multiplied by 1 + each relative change.

    Parameters
    ----------
    profile : SpeedProfile
    changes : sequence of (times_s, change)
        Piecewise linear, both of shape (knots,). All knots are joined first, so that the order does not matter.
    """
    if not changes:
        return profile
    knots = np.unique(np.concatenate([profile.times_s, *(times for times, _ in changes)]))
    speeds = profile.speed_rad_s(knots)
    factors = sorted((1 + np.interp(knots, times, change) for times, change in changes), key=tuple)
    for factor in factors:
        speeds = speeds * factor
    return SpeedProfile(tuple(knots.tolist()), tuple(speeds.tolist()))


def as_profile(speed_rpm: float | SpeedProfile) -> SpeedProfile:
    """Return a profile: a number means constant speed in revolutions a minute."""
    return speed_rpm if isinstance(speed_rpm, SpeedProfile) else steady(speed_rpm=speed_rpm)


def _radians_per_second(speed_rpm: object) -> float:
    if isinstance(speed_rpm, bool) or not isinstance(speed_rpm, int | float | np.number) or not 0 < speed_rpm < 1e6:
        raise InvalidValueError(f"Speed {speed_rpm!r} rpm; allowed: more than 0, less than 1e6. Give the shaft speed.")
    return float(speed_rpm) * 2 * math.pi / 60
