"""Critical speeds from the 1X vibration of a run-up or a coast-down.

A mode that an unbalance drives moves by A w^2 / (wn^2 - w^2 + 2 i z wn w) (Genta, "Dynamics of Rotating Systems", 2005,
section 2.4); what does not turn with the speed, a run-out or a bow, adds a constant, and modes far above add something
that grows as w^2. Frequencies and damping are those of the machine, the same for all channels, and fitted by least
squares; the complex amplitudes, of each channel its own, are linear at each of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...simulators.errors import InvalidValueError

#: Points of a record that tell anything, and highest over lowest speed.
LEAST_POINTS, LEAST_RANGE = 12, 1.15
#: Modes looked for, those outside the range of speeds included.
MOST = 4
#: Another mode must leave less than this share of what those before it leave. A run through a resonance makes it ring,
#: which beats with 1X beyond it: modes follow each beat a little.
LEAST_FALL = 0.5
#: All modes together must take away so much of what constant and w^2 leave, and one of them must make so much of a
#: channel's largest value.
LEAST_SHARE, LEAST_PART = 0.75, 0.2
#: Bounds of the damping ratio: sharper peaks lie between two points, broader ones are none.
SHARPEST, BROADEST = 1e-3, 0.3
#: Fastest run, in squares of the decay rate a second.
FASTEST = 0.5
#: Places at which a fit begins, and the damping ratio there.
LOOKS, FIRST_RATIO = 32, 0.03
#: Half width of a 90 % interval in standard deviations.
REACH = 1.645


@dataclass(frozen=True)
class CriticalSpeed:
    """A speed at which the shaft turns with one of its natural frequencies.

    Attributes
    ----------
    speed_rpm, low_rpm, high_rpm : float
        Undamped natural frequency, and its 90 % interval.
    damping_ratio, low_ratio, high_ratio : float
    """

    speed_rpm: float
    low_rpm: float
    high_rpm: float
    damping_ratio: float
    low_ratio: float
    high_ratio: float

    @property
    def amplification(self) -> float:
        """The factor Q = 1 / (2 z) by which the resonance amplifies."""
        return 0.5 / self.damping_ratio


def critical_speeds(
    speed_rpm: np.ndarray, displacement: np.ndarray, *, rate_rpm_s: np.ndarray | float = 0.0
) -> tuple[CriticalSpeed, ...]:
    """Return the critical speeds that a run passes, in the order of speed.

    How many modes there are is judged by the Bayesian information criterion. Two close ones are those of a shaft whose
    supports differ in x and y. Not stated is one whose half-power width reaches beyond the range of speeds, or that was
    passed so fast that it had no time to build up.

    Parameters
    ----------
    speed_rpm : ndarray (points,)
    displacement : ndarray (channels, points), complex
        1X with its phase against the tacho, leading or lagging. Divide velocities by i w, accelerations by -w^2.
    rate_rpm_s : ndarray (points,) or float
        By how much the speed rises in a second; a mode shows late by its time constant 1 / (z wn).

    Raises
    ------
    InvalidValueError
        For speeds that are not positive, values that are not finite, or other than one value for each speed.
    """
    speed, values = np.asarray(speed_rpm, dtype=float), np.atleast_2d(np.asarray(displacement, dtype=complex))
    if speed.ndim != 1 or values.shape[1:] != speed.shape or not (speed > 0).all() or not np.isfinite(values).all():
        raise InvalidValueError(
            f"{speed.shape} speeds from {speed.min(initial=math.inf):g} rpm and {values.shape} values; allowed: one "
            "finite value of each channel for each speed above 0. Leave the others out."
        )
    size = np.sqrt((np.abs(values) ** 2).mean(axis=1))
    if speed.size < LEAST_POINTS or speed.max() < LEAST_RANGE * speed.min() or not (size > 0).any():
        return ()
    values = values[size > 0] / size[size > 0, None]
    # A phase that leads and one that lags are each other's conjugate; which one it is, only the fit tells.
    found = [_best(speed / speed.mean(), one) for one in (values, values.conj())]
    modes = min(found, key=lambda one: one.criterion)
    stated = _stated(modes, speed, np.broadcast_to(rate_rpm_s, speed.shape))
    return tuple(sorted(stated, key=lambda one: one.speed_rpm))


@dataclass(frozen=True, eq=False)
class _Modes:
    """A fit: speeds and logarithms of damping ratios (2 modes,), their covariance, and each mode's part (modes,).

    The part is the largest value that a mode alone reaches in a channel, over that channel's largest.
    """

    position: np.ndarray
    covariance: np.ndarray
    parts: np.ndarray
    criterion: float


def _best(speed: np.ndarray, values: np.ndarray) -> _Modes:
    """Return the fit with the best number of modes, each found beside those before it."""
    left, _ = _left(np.zeros(0), speed, values)
    power = without = float(left @ left)
    best = _Modes(np.zeros(0), np.zeros((0, 0)), np.zeros(0), _criterion(left, 0, len(values)))
    position = np.zeros(0)
    for count in range(1, MOST + 1):
        if power <= 1e-20 * values.size:
            break
        left, position, covariance = _fitted(speed, values, position)
        before, power = power, float(left @ left)
        criterion = _criterion(left, count, len(values))
        if power > LEAST_FALL * before or _overlap(position):
            break
        if criterion < best.criterion and power < (1 - LEAST_SHARE) * without:
            best = _Modes(position, covariance, _parts(position, speed, values), criterion)
    return best


def _overlap(position: np.ndarray) -> bool:
    """Return whether two modes are closer than their half-power widths: one mode, passed too fast, looks like two."""
    natural, ratio = position[: position.size // 2], np.exp(position[position.size // 2 :])
    order = np.argsort(natural)
    return bool((np.diff(natural[order]) < (natural * ratio)[order][1:] + (natural * ratio)[order][:-1]).any())


def _columns(position: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Return each mode's motion for a unit amplitude, then constant and square, shape (points, modes + 2)."""
    natural, ratio = position[: position.size // 2], np.exp(position[position.size // 2 :])
    modes = [speed**2 / (own**2 - speed**2 + 2j * z * own * speed) for own, z in zip(natural, ratio, strict=True)]
    return np.stack([*modes, np.ones(speed.size), speed**2], axis=1)


def _left(position: np.ndarray, speed: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what a fit leaves, real then imaginary parts, and the amplitudes (modes + 2, channels)."""
    columns = _columns(position, speed)
    amplitudes = np.linalg.lstsq(columns, values.T, rcond=None)[0]
    left = (values.T - columns @ amplitudes).ravel()
    return np.concatenate([left.real, left.imag]), amplitudes


def _fitted(speed: np.ndarray, values: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what one mode more than those known leaves, the position, and its covariance."""
    from scipy.optimize import least_squares

    half = known.size // 2

    def beside(place: float) -> np.ndarray:
        return np.array([*known[:half], place, *known[half:], math.log(FIRST_RATIO)])

    places = np.linspace(speed.min(), speed.max(), LOOKS).tolist()
    starts = [beside(place) for place in places]
    first = min(starts, key=lambda start: float((_left(start, speed, values)[0] ** 2).sum()))
    low = [0.5 * speed.min()] * (half + 1) + [math.log(SHARPEST)] * (half + 1)
    high = [2.0 * speed.max()] * (half + 1) + [math.log(BROADEST)] * (half + 1)
    start = np.clip(first, np.array(low) + 1e-9, np.array(high) - 1e-9)
    found = least_squares(lambda p: _left(p, speed, values)[0], start, bounds=(low, high), x_scale="jac")
    freedom = max(found.fun.size - _unknowns(half + 1, len(values)), 1)
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * float(found.fun @ found.fun) / freedom
    return found.fun, found.x, covariance * _repeated(found.fun, speed.size)


def _repeated(left: np.ndarray, points: int) -> float:
    """Return by how much neighbours that are wrong alike make the variance of a fit larger (first-order process)."""
    each = left.reshape(2, points, -1)
    alike = float((each[:, 1:] * each[:, :-1]).sum()) / max(float((each**2).sum()), 1e-300)
    alike = min(max(alike, 0.0), 0.99)
    return (1 + alike) / (1 - alike)


def _unknowns(modes: int, channels: int) -> int:
    return 2 * modes + 2 * channels * (modes + 2)


def _criterion(left: np.ndarray, modes: int, channels: int) -> float:
    """Return the Bayesian information criterion."""
    power = max(float(left @ left), 1e-300)
    return left.size * math.log(power / left.size) + _unknowns(modes, channels) * math.log(left.size)


def _parts(position: np.ndarray, speed: np.ndarray, values: np.ndarray) -> np.ndarray:
    modes = np.abs(_columns(position, speed)[:, : position.size // 2]).max(axis=0)
    amplitudes = np.abs(_left(position, speed, values)[1][: position.size // 2])
    return (modes[:, None] * amplitudes / np.abs(values).max(axis=1)).max(axis=1)


def _stated(found: _Modes, speed: np.ndarray, rate: np.ndarray) -> list[CriticalSpeed]:
    """Return the modes that were passed whole and slowly enough.

    How late a mode shows is taken off, to half of that: F. M. Lewis, Vibration during acceleration through a critical
    speed, Trans. ASME 54 (1932), has the rate in squares of the decay rate as the only parameter.
    """
    count = found.position.size // 2
    spread = REACH * np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    stated = []
    for number in range(count):
        own, ratio = float(found.position[number] * speed.mean()), math.exp(found.position[count + number])
        unsure = math.exp(min(float(spread[count + number]), 50.0))
        decay_1_s = ratio * own * math.pi / 30
        late = float(rate[np.argmin(np.abs(speed - own))]) / decay_1_s
        reach = float(spread[number] * speed.mean()) + 0.5 * abs(late)
        whole = own - ratio * own > speed.min() and own + ratio * own < speed.max()
        if found.parts[number] < LEAST_PART or not whole or abs(late) > FASTEST * ratio * own:
            continue
        own -= late
        stated.append(CriticalSpeed(own, max(own - reach, 0.0), own + reach, ratio, ratio / unsure, ratio * unsure))
    return stated
