"""Time-synchronous average of a gear, what is left of it without its regular lines, and the usual indicators.

The average over turns of one shaft keeps what repeats with that shaft. Without the tooth-mesh harmonics and the shaft's
own first two orders it is the residual signal; without the first sidebands of the mesh too, the difference signal: a
sound gear leaves next to nothing there, a damaged tooth a burst.
(P. D. McFadden, MSSP 1 (1987) 83; R. M. Stewart, ISVR report MHM/R/10/77 (1977) for FM0 and FM4; J. J. Zakrajsek,
NASA TM-105950 (1993) for NA4; P. D. Samuel and D. J. Pines, J. Sound Vib. 282 (2005) 475 for a review.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy import fft

from ...simulators.errors import InvalidValueError
from .order_map import samples_a_turn
from .order_tracking import angular_resample
from .spectrum import fast_length
from .vold_kalman import order_waveforms


@dataclass(frozen=True, eq=False)
class SynchronousAverage:
    """One turn of a shaft, averaged.

    Attributes
    ----------
    average : numpy.ndarray, shape (channels, samples)
        The mean turn; its first sample is at angle zero.
    deviation : numpy.ndarray, shape (channels, samples)
        Standard deviation of the mean, from the scatter over turns; NaN of a single turn.
    turns : int
    """

    average: np.ndarray
    deviation: np.ndarray
    turns: int

    def orders(self) -> np.ndarray:
        """Return the complex amplitudes of orders 0, 1, 2, ..., shape (channels, samples // 2 + 1), peak values."""
        spectrum = fft.rfft(self.average, axis=1) * (2.0 / self.average.shape[1])
        spectrum[:, 0] *= 0.5
        return spectrum


@dataclass(frozen=True)
class GearIndicators:
    """Condition indicators of one gear on one channel; all without a unit.

    Attributes
    ----------
    fm0 : float
        Peak to peak of the average over the summed amplitudes of the mesh harmonics: rises where one tooth strikes, or
        where the whole mesh fades.
    fm4 : float
        Kurtosis of the difference signal, 3 for noise: rises with one or two bad teeth, falls again with many.
    na4 : float
        Fourth moment of the residual over the squared mean variance of healthy records: rises with spread too.
    energy_ratio : float
        Rms of the difference over the rms of the regular lines: rises with wear and with any modulation beyond the
        first sidebands.
    """

    fm0: float
    fm4: float
    na4: float
    energy_ratio: float


def phase_locked_to_mesh(
    signals: np.ndarray, *, rate_hz: float, phase_turns: np.ndarray, mesh_order: float, bandwidth_hz: float
) -> np.ndarray:
    """Return the shaft angle corrected by the phase of the tooth mesh, shape (samples,), in turns.

    Without a tacho a speed known to 1e-4 is half a tooth off after a few hundred turns. The mesh line itself, on the
    channel that has it strongest, tells the angle (J. Combet and L. Gelman, MSSP 21 (2007) 2590).

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    rate_hz : float
    phase_turns : numpy.ndarray, shape (samples,)
        Angle of the reference shaft to within the bandwidth.
    mesh_order : float
        Tooth-mesh frequency over that shaft's speed.
    bandwidth_hz : float
        Of the mesh line; below half the speed of the slower shaft, so that its sidebands do not count.

    Raises
    ------
    InvalidValueError
        See `order_waveforms`.
    """
    found = order_waveforms(
        signals, rate_hz=rate_hz, phase_turns=phase_turns, orders=[mesh_order], bandwidth_hz=bandwidth_hz
    )
    envelope = found.envelope[:, 0]
    strongest = envelope[int(np.argmax(np.median(np.abs(envelope), axis=1)))]
    return phase_turns + np.unwrap(np.angle(strongest)) / (2 * np.pi * mesh_order)


def synchronous_average(signals: np.ndarray, *, phase_turns: np.ndarray, highest_order: float) -> SynchronousAverage:
    """Return the average over the whole turns of a shaft.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
    phase_turns : numpy.ndarray, shape (samples,)
        Rising angle of the shaft to average over, in turns of that shaft.
    highest_order : float
        Kept up to here; four mesh harmonics are usual.

    Notes
    -----
    N turns leave 1/N of the power of what does not repeat with the shaft, but for a line whose order is nearly whole.

    Examples
    --------
    >>> turn = np.arange(40000) / 1000
    >>> x = np.cos(2 * np.pi * 20 * turn) + np.random.default_rng(0).normal(0, 1, turn.size)
    >>> found = synchronous_average(x, phase_turns=turn, highest_order=80)
    >>> round(float(abs(found.orders()[0, 20])), 1)
    1.0
    """
    if not highest_order > 0:
        raise InvalidValueError(f"Highest order {highest_order}; allowed: above 0. Four times the teeth are usual.")
    per_turn = fast_length(samples_a_turn(highest_order))
    even = angular_resample(signals, phase_turns=phase_turns, samples_per_turn=per_turn)
    turns = even.reshape(even.shape[0], -1, per_turn)
    count = turns.shape[1]
    mean = turns.mean(axis=1)
    scatter = turns.std(axis=1, ddof=1) / np.sqrt(count) if count > 1 else np.full(mean.shape, np.nan)
    return SynchronousAverage(mean, scatter, count)


def residual_signal(average: np.ndarray, *, teeth: int) -> np.ndarray:
    """Return the average without its mean, orders 1 and 2, and all harmonics of the tooth mesh, same shape."""
    return _without(average, _regular(average.shape[-1], teeth, sidebands=0))


def difference_signal(average: np.ndarray, *, teeth: int) -> np.ndarray:
    """Return the residual signal without the first pair of sidebands of every mesh harmonic too, same shape."""
    return _without(average, _regular(average.shape[-1], teeth, sidebands=1))


def _regular(samples: int, teeth: int, *, sidebands: int) -> np.ndarray:
    if not 3 <= teeth <= samples // 2:
        raise InvalidValueError(
            f"{teeth} teeth on a turn of {samples} samples; allowed: 3 to {samples // 2}. Keep higher orders."
        )
    mesh = np.arange(teeth, samples // 2 + 1, teeth)
    around = (mesh[:, None] + np.arange(-sidebands, sidebands + 1)).ravel()
    return np.concatenate([[0, 1, 2], around[around <= samples // 2]])


def _without(average: np.ndarray, orders: np.ndarray) -> np.ndarray:
    spectrum = fft.rfft(average, axis=-1)
    spectrum[..., orders] = 0.0
    return fft.irfft(spectrum, n=average.shape[-1], axis=-1)


def gear_indicators(average: np.ndarray, *, teeth: int, healthy_variance: float | None = None) -> GearIndicators:
    """Return the condition indicators of one channel's synchronous average.

    Parameters
    ----------
    average : numpy.ndarray, shape (samples,)
    teeth : int
        Of the gear on the shaft that was averaged over.
    healthy_variance : float or None
        Mean variance of the residual signal over healthy records of the same gear and load, for NA4; None takes this
        record's own, which makes NA4 the kurtosis of the residual.

    Examples
    --------
    >>> angle = np.arange(1000) / 1000
    >>> mesh = np.cos(2 * np.pi * 20 * angle)
    >>> burst = 0.3 * np.exp(-((angle - 0.5) ** 2) / 0.02**2) * np.cos(2 * np.pi * 30 * angle)
    >>> noise = np.random.default_rng(0).normal(0, 0.01, 1000)
    >>> bool(gear_indicators(mesh + burst + noise, teeth=20).fm4 > 6 > gear_indicators(mesh + noise, teeth=20).fm4)
    True
    """
    row = np.asarray(average, dtype=float)
    residual, difference = residual_signal(row, teeth=teeth), difference_signal(row, teeth=teeth)
    tiny = np.finfo(float).tiny
    amplitude = np.abs(fft.rfft(row)) * (2.0 / row.size)
    mesh = float(amplitude[teeth::teeth].sum())
    regular = row - row.mean() - difference
    reference = float(residual.var()) if healthy_variance is None else healthy_variance
    return GearIndicators(
        fm0=float(np.ptp(row)) / max(mesh, tiny),
        fm4=float((difference**4).mean() / max(float((difference**2).mean()) ** 2, tiny)),
        na4=float(((residual - residual.mean()) ** 4).mean() / max(reference**2, tiny)),
        energy_ratio=float(difference.std() / max(float(regular.std()), tiny)),
    )
