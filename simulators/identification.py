"""Stiffness harmonics of a coupling from measured order amplitudes.

Two ways. `identify_by_swarm` is that of paper 000, Eqs (12)-(15): the amplitudes of all channels are added for each
order, and a particle swarm looks for the harmonics that give the same sums. `identify_by_least_squares` fits the
complex amplitudes of every channel.

The sums of M orders are M numbers; they cannot determine the 4 N coefficients a_n .. d_n when 4 N > M, whatever the
optimiser. `identifiability` shows from the singular values of the sensitivity how many combinations the data determine,
and how well. The bounds 0 <= p <= 1 of Eq (15) besides allow stiffnesses below zero as soon as the coefficients of one
direction add up to more than 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from .coupling_response import CouplingResponse
from .errors import InvalidValueError
from .particle_swarm import SwarmResult, particle_swarm


@dataclass(frozen=True)
class Condition:
    """One measured condition: a speed, unbalance and misalignment that are known.

    Parameters
    ----------
    response : CouplingResponse
        The machine there, without stiffness harmonics.
    amplitudes : ndarray (probes, M), complex
        Measured at the orders 1 .. M, one-sided, phase against the tacho: probe = Re sum_m A_m exp(i m phi). For the
        swarm the absolute values suffice.
    """

    response: CouplingResponse
    amplitudes: np.ndarray

    def __post_init__(self) -> None:
        probes, orders = len(self.response.probes), self.response.highest_order
        shape = np.shape(self.amplitudes)
        if len(shape) != 2 or shape[0] != probes or not 1 <= shape[1] <= orders:
            raise InvalidValueError(
                f"Amplitudes of shape {shape}; allowed: {probes} probes by 1 to {orders} orders, beginning with 1X."
            )


@dataclass(frozen=True)
class Identifiability:
    """What data say about unknowns, from the sensitivity S of all numbers fitted.

    Attributes
    ----------
    singular_values : ndarray
        Of S, largest first, in m of vibration for a change of 1 in the combination.
    rank : int
        Combinations of unknowns that the data react to at all (singular value above 1e-9 of the largest).
    determined : int
        Combinations known within 0.1, one standard deviation, with the noise given.
    unknowns : int
    """

    singular_values: np.ndarray
    rank: int
    determined: int
    unknowns: int


@dataclass(frozen=True)
class Identification:
    """Stiffness harmonics found by least squares.

    Attributes
    ----------
    coefficients : ndarray (directions, N)
        a_n, b_n, c_n, d_n as rows for x, y, angle_x, angle_y.
    half_width_95 : ndarray (directions, N)
        95 % intervals are coefficients +- this, from the noise given; infinite where the data say nothing.
    residual_m : float
        Root mean square of what is not explained, per real number fitted.
    identifiability : Identifiability
    """

    coefficients: np.ndarray
    half_width_95: np.ndarray
    residual_m: float
    identifiability: Identifiability


def fft_amplitudes(
    signals: np.ndarray, *, rate_hz: float, speed_rpm: float, orders: int, search_hz: float = 5.0
) -> np.ndarray:
    """Return the amplitudes of paper 000, Eqs (12) and (13): the highest line within 5 Hz of each order.

    Where the order lies between two lines, this reads too low, by up to 36 %: 1X of 4000 rpm in a record of one second
    by 17 %, since 66.67 Hz is a third of a line off. It cancels only if model and measurement are read alike.

    Parameters
    ----------
    signals : ndarray (probes, samples)
    rate_hz, speed_rpm : float
    orders : int
        M; the orders are 1 .. M.
    search_hz : float

    Returns
    -------
    ndarray (probes, M)
        Peak amplitudes in the signals' unit.
    """
    count = signals.shape[-1]
    spectrum = 2 / count * np.abs(np.fft.rfft(signals - signals.mean(axis=-1, keepdims=True)))
    frequency = np.fft.rfftfreq(count, 1 / rate_hz)
    found = []
    for order in range(1, orders + 1):
        near = np.abs(frequency - order * speed_rpm / 60) <= search_hz
        if not near.any():
            raise InvalidValueError(
                f"No spectral line within {search_hz:g} Hz of order {order}; allowed: orders below {rate_hz / 2:g} Hz "
                f"and records longer than {1 / search_hz:g} s. Ask for fewer orders, or record faster or longer."
            )
        found.append(spectrum[:, near].max(axis=-1))
    return np.stack(found, axis=-1)


def identify_by_swarm(
    conditions: Sequence[Condition], *, harmonics: int, seed: int, particles: int = 50, iterations: int = 100
) -> SwarmResult:
    """Return the harmonics whose summed amplitudes fit best, Eqs (14) and (15), with bounds 0 and 1.

    ``best`` holds a_1 .. a_N, then b, c, d; ``value`` is J in m. Several seeds show how little J determines.
    """
    unknowns = _unknowns(conditions, harmonics)

    def objective(points: np.ndarray) -> np.ndarray:
        total = np.zeros(len(points))
        for condition in conditions:
            measured = np.abs(condition.amplitudes).sum(axis=0)
            cos = points.reshape(len(points), -1, harmonics)
            sums = np.abs(condition.response.amplitudes(cos)).sum(axis=-2)
            total += np.abs(sums[:, 1 : measured.size + 1] - measured).sum(axis=-1)
        return total

    low, high = np.zeros(unknowns), np.ones(unknowns)
    return particle_swarm(objective, low=low, high=high, seed=seed, particles=particles, iterations=iterations)


def identify_by_least_squares(
    conditions: Sequence[Condition], *, harmonics: int, noise_m: float, start: np.ndarray | None = None
) -> Identification:
    """Return the harmonics whose complex amplitudes fit best, with intervals (Gauss-Newton, Levenberg-Marquardt).

    Parameters
    ----------
    conditions : sequence of Condition
    harmonics : int
        N.
    noise_m : float
        Standard deviation of the real and of the imaginary part of each amplitude.
    start : ndarray (directions, N), optional
        Zero when left out.
    """
    from scipy.optimize import least_squares
    from scipy.stats import norm

    unknowns = _unknowns(conditions, harmonics)
    _require_noise(noise_m)
    begin = np.zeros(unknowns) if start is None else np.ravel(start)

    def residual(point: np.ndarray) -> np.ndarray:
        cos = point.reshape(-1, harmonics)
        return (
            np.concatenate([_real((_orders(c, c.response.amplitudes(cos)) - c.amplitudes).ravel()) for c in conditions])
            / noise_m
        )

    def jacobian(point: np.ndarray) -> np.ndarray:
        return complex_sensitivity(conditions, point.reshape(-1, harmonics)) / noise_m

    fit = least_squares(residual, begin, jac=cast(Any, jacobian), method="lm", xtol=1e-12, ftol=1e-12, gtol=1e-12)
    sensitivity = jacobian(fit.x) * noise_m
    _, values, directions = np.linalg.svd(sensitivity, full_matrices=True)
    deviation = np.full(unknowns, np.inf)
    deviation[: values.size] = np.divide(noise_m, values, out=deviation[: values.size], where=values > 1e-9 * values[0])
    with np.errstate(invalid="ignore"):
        variance = np.where(directions == 0, 0.0, directions**2 * (deviation**2)[:, None]).sum(axis=0)
    half_width = norm.ppf(0.975) * np.sqrt(variance)
    return Identification(
        coefficients=fit.x.reshape(-1, harmonics),
        half_width_95=half_width.reshape(-1, harmonics),
        residual_m=float(noise_m * np.sqrt(np.mean(fit.fun**2))),
        identifiability=identifiability(sensitivity, noise_m=noise_m),
    )


def complex_sensitivity(conditions: Sequence[Condition], cos: np.ndarray) -> np.ndarray:
    """Return the derivative of all real and imaginary parts by the coefficients, shape (numbers, directions x N)."""
    parts = []
    for condition in conditions:
        full = _orders(condition, condition.response.sensitivity(cos), axis=1)
        parts.append(_real(full.reshape(-1, cos.size)))
    return np.concatenate(parts)


def summed_sensitivity(conditions: Sequence[Condition], cos: np.ndarray) -> np.ndarray:
    """Return the derivative of the summed amplitudes of Eq (14) by the coefficients, shape (orders, directions x N)."""
    parts = []
    for condition in conditions:
        amplitudes = _orders(condition, condition.response.amplitudes(cos))
        change = _orders(condition, condition.response.sensitivity(cos), axis=1)
        toward = np.exp(-1j * np.angle(amplitudes))
        parts.append(np.einsum("rm,rmdn->mdn", toward, change).real.reshape(-1, cos.size))
    return np.concatenate(parts)


def identifiability(sensitivity: np.ndarray, *, noise_m: float) -> Identifiability:
    """Return how many combinations of unknowns (columns) a sensitivity determines with this noise."""
    _require_noise(noise_m)
    values = np.linalg.svd(sensitivity, compute_uv=False)
    rank = int(np.sum(values > 1e-9 * values[0]))
    return Identifiability(values, rank, int(np.sum(noise_m < 0.1 * values)), sensitivity.shape[1])


def _orders(condition: Condition, values: np.ndarray, *, axis: int = -1) -> np.ndarray:
    """Keep the orders that were measured: 1 .. M of 0 .. H."""
    return np.take(values, np.arange(1, condition.amplitudes.shape[1] + 1), axis=axis)


def _real(values: np.ndarray) -> np.ndarray:
    """Stack real over imaginary parts."""
    return np.concatenate([np.real(values), np.imag(values)])


def _unknowns(conditions: Sequence[Condition], harmonics: int) -> int:
    if not conditions or harmonics < 1:
        raise InvalidValueError(
            f"{len(conditions)} conditions and {harmonics} harmonics; allowed: at least one of each. Give measurements."
        )
    return len(conditions[0].response.directions) * harmonics


def _require_noise(noise_m: float) -> None:
    if not noise_m > 0:
        raise InvalidValueError(f"Noise {noise_m} m; allowed: more than 0. Give the noise of the amplitudes.")
