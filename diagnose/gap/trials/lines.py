"""Order lines of a clean record by weighted least squares, and how well a change of them can be seen.

Detectability of a change dA of the complex lines A, summed over conditions c, probes p and orders k:

    d2 = sum |dA|^2 / (s_n^2 + (0.01 |A|)^2),   s_n^2 = 3 s^2 / N

with the noise's rms s in that record and channel, N samples, and A the line with the effect. s_n is the standard
deviation of the real (or imaginary) part of a line taken with a Hann window: 2 s^2 / N for a plain mean, times 1.5.
0.01 |A| is the gain's error. The orders are 1/2, 1, ... 6 of the reference shaft; with a gear mesh also those of the
other shaft (1, 2) and three multiples of the mesh with sidebands of both shafts, and the lines that the effect itself
states, wherever they lie (a bearing defect's, a load's frequency). Noise and the mean do not count. A longer record
does not help beyond the gain's error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....simulators.effect import Effect
from ....simulators.machine import Machine
from ....simulators.rotor_dynamics.gear_mesh_stiffness import SpurPair
from .recorder import GAIN_DEVIATION

#: Noise power of a Hann-weighted mean over that of a plain mean.
_HANN = 1.5
_FLAT = 0.4
#: From the middle of a Hann window's line to its first zero, in bins.
_LOBE = 2.0


@dataclass(frozen=True, eq=False)
class Lines:
    """Complex lines of one condition.

    Attributes
    ----------
    amplitudes : ndarray (probes, orders), complex
    samples : int
    """

    amplitudes: np.ndarray
    samples: int


def orders_of(machine: Machine) -> np.ndarray:
    """Return the orders that count for a machine, increasing; see the module's docstring."""
    found = set(np.arange(1, 13) / 2)
    for part in machine.bare_assembly().components.values():
        pair = getattr(part, "pair", None)
        if isinstance(pair, SpurPair):
            ratio = pair.pinion.teeth / pair.wheel.teeth
            around = (0.0, 1.0, -1.0, ratio, -ratio)
            found |= {ratio, 2 * ratio} | {n * part.mesh_order + beside for n in (1, 2, 3) for beside in around}
    return np.array(sorted(found))


def with_stated(
    orders: np.ndarray, effects: Sequence[Effect], machine: Machine, *, speed_rpm: float, turns: float
) -> np.ndarray:
    """Return the orders and those of the lines that effects state, but for what a record cannot tell from another.

    Parameters
    ----------
    orders : ndarray
    effects : sequence of Effect
    machine : Machine
        With these effects.
    speed_rpm : float
    turns : float
        Length of the record: lines closer than two of its bins count once.
    """
    found = [0.0, *orders]
    for effect in effects:
        for line in effect.signature(machine):
            order = line.order_at(speed_rpm)
            if min(abs(order - other) for other in found) >= _LOBE / turns:
                found.append(order)
    return np.array(found[1:])


def lines_of(signals: np.ndarray, phase_rad: np.ndarray, orders: np.ndarray, *, rate_hz: float) -> Lines:
    """Return the lines of a record; 0 above 0.4 of the sampling rate.

    Parameters
    ----------
    signals : ndarray (probes, samples)
    phase_rad : ndarray (samples,)
        Shaft angle, as the tacho tells it.
    orders : ndarray (orders,)
    rate_hz : float
    """
    count = phase_rad.size
    weight = np.sin(np.pi * (np.arange(count) + 0.5) / count)  # its square is a Hann window
    speed_hz = (phase_rad[-1] - phase_rad[0]) / (2 * np.pi * (count - 1)) * rate_hz
    seen = orders * speed_hz < _FLAT * rate_hz
    angle = orders[seen, None] * phase_rad
    columns = np.concatenate([np.ones((1, count)), np.cos(angle), np.sin(angle)]) * weight
    # Whole turns make the columns all but orthogonal: the normal equations lose nothing and are ten times as fast.
    found = np.linalg.solve(columns @ columns.T, columns @ (signals * weight).T)
    half = int(seen.sum())
    amplitudes = np.zeros((signals.shape[0], orders.size), dtype=complex)
    amplitudes[:, seen] = (found[1 : half + 1] - 1j * found[half + 1 :]).T
    return Lines(amplitudes, count)


def detectability(
    with_effect: Sequence[Lines], without: Sequence[Lines], noise_rms: Sequence[np.ndarray], rows: Sequence[int]
) -> float:
    """Return d2 of the change between two sets of conditions over the probes ``rows``; see the module's docstring."""
    total = 0.0
    for now, before, noise in zip(with_effect, without, noise_rms, strict=True):
        line = np.abs(now.amplitudes[rows])
        variance = 2 * _HANN * noise[rows, None] ** 2 / now.samples + (GAIN_DEVIATION * line) ** 2
        change = np.abs(now.amplitudes - before.amplitudes)[rows] ** 2
        # A channel that stands still has neither noise nor change.
        total += float((change / np.maximum(variance, 1e-300)).sum())
    return total
