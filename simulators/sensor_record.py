"""What a measuring chain hands on from link to link: signals with their clock, shaft angle and channels.

The links stand in a fixed order, so that the order in which effects are given does not matter: the *surface* that a
proximity probe looks at, the *mounting* of the sensor, the *transducer*, the *cable*, the anti-alias *filter*, the
*clock* that takes the samples, the *converter* and the *recorder*. Up to the filter the record may be sampled at a
multiple of the output rate, so that an imperfect filter has something to let through.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .assembly import Probe
from .errors import InvalidValueError

LINKS = ("surface", "mounting", "transducer", "cable", "filter", "clock", "converter", "recorder")


@dataclass(frozen=True)
class SensorRecord:
    """Signals of several channels with one clock.

    Attributes
    ----------
    signals : ndarray (channels, samples)
    rate_hz : float
        Of ``signals``; a multiple of ``output_rate_hz`` before the filter.
    output_rate_hz : float
        Of the finished record.
    phase_rad, speed_rad_s : ndarray (samples,)
        Of the reference shaft at the instant of each sample.
    channels : tuple of Probe
    shaft_ratios : tuple of float
        Speed of the part that a channel looks at over the speed of the reference shaft.
    full_scale, middle : ndarray (channels,)
        Measuring range of each channel, from ``middle - full_scale`` to ``middle + full_scale``, in its unit.
    leak : ndarray (channels,)
        Share of what lies above half the output rate that the anti-alias filter lets through; 0 for a good filter.
    """

    signals: np.ndarray
    rate_hz: float
    output_rate_hz: float
    phase_rad: np.ndarray
    speed_rad_s: np.ndarray
    channels: tuple[Probe, ...]
    shaft_ratios: tuple[float, ...]
    full_scale: np.ndarray
    middle: np.ndarray
    leak: np.ndarray

    @property
    def time_s(self) -> np.ndarray:
        """Time of each sample by the recorder's clock, shape (samples,)."""
        return np.arange(self.signals.shape[1]) / self.rate_hz

    def with_signals(self, signals: np.ndarray) -> SensorRecord:
        """Return the record with other signals of the same shape."""
        return replace(self, signals=signals)


def filtered(
    signals: np.ndarray, rate_hz: float, transfer: Callable[[np.ndarray], np.ndarray], *, mean_over_s: float = 0.0
) -> np.ndarray:
    """Return signals behind a linear filter of known transfer function, without the error of a digital imitation.

    Parameters
    ----------
    signals : ndarray (channels, samples)
    rate_hz : float
    transfer : callable
        ``transfer(frequency_hz) -> complex ndarray`` of the same shape, for frequencies from 0 to half the rate.
    mean_over_s : float
        Of a filter that takes away the mean: the stretch at either end that tells what the mean is there.

    Notes
    -----
    The signal is continued at both ends by its point reflection, so that steady signals have no transient. Reflected
    in its last sample it would get another mean, which AC coupling answers with a slow decay from twice that sample's
    height; there it is reflected in the mean.
    """
    # Twice as fast as numpy's: it takes two channels together.
    from scipy.fft import irfft, next_fast_len, rfft

    count = signals.shape[1]
    # The last sample's reflection needs neighbours; a single sample is its own steady signal.
    pad = max(count - 1, 0)
    # A length of large prime factors costs a Fourier transform twelve times as much.
    beyond = next_fast_len(count + 2 * pad, real=True) - count - pad
    if not pad:
        long = signals
    elif mean_over_s > 0:
        long = _reflected_in_mean(signals, pad, beyond, stretch=max(round(mean_over_s * rate_hz), 1))
    else:
        long = np.pad(signals, ((0, 0), (pad, beyond)), mode="reflect", reflect_type="odd")
    spectrum = rfft(long, axis=1)
    spectrum *= transfer(np.fft.rfftfreq(long.shape[1], 1 / rate_hz))
    filtered = np.asarray(irfft(spectrum, long.shape[1], axis=1, overwrite_x=True))
    return filtered[:, pad : pad + count]


def _reflected_in_mean(signals: np.ndarray, before: int, after: int, *, stretch: int) -> np.ndarray:
    """Return signals continued by their reflection in the mean of a stretch at either end, with the sign turned."""
    window = np.hanning(min(stretch, signals.shape[1]) + 2)[1:-1]
    window /= window.sum()
    first, last = signals[:, : window.size] @ window, signals[:, -window.size :] @ window
    turned = np.pad(signals, ((0, 0), (before, after)), mode="reflect")
    turned[:, :before] = 2 * first[:, None] - turned[:, :before]
    turned[:, before + signals.shape[1] :] = 2 * last[:, None] - turned[:, before + signals.shape[1] :]
    return turned


def resonance(frequency_hz: np.ndarray, *, period_s: float, damping_ratio: float) -> np.ndarray:
    """Return H = 1 / (1 - (f T)^2 + 2 i zeta f T), a mass on a spring with natural frequency 1 / T."""
    share = frequency_hz * period_s
    return 1 / (1 - share**2 + 2j * damping_ratio * share)


def anti_alias(frequency_hz: np.ndarray, *, rate_hz: float) -> np.ndarray:
    """Return a low-pass that is 1 up to 0.4 of the output rate and 0 from 0.6 on, with a cosine between.

    What it leaves between 0.5 and 0.6 folds back above 0.4 only: the same promise as the simulation's own decimation.
    """
    across = np.clip((frequency_hz / rate_hz - 0.4) / 0.2, 0.0, 1.0)
    return 0.5 * (1 + np.cos(np.pi * across))


def sampled(record: SensorRecord) -> SensorRecord:
    """Return the record at its output rate, behind the anti-alias filter and what that filter lets through.

    Raises
    ------
    InvalidValueError
        When the record's rate is no multiple of the output rate.
    """
    factor = round(record.rate_hz / record.output_rate_hz)
    if not np.isclose(factor * record.output_rate_hz, record.rate_hz) or factor < 1:
        raise InvalidValueError(
            f"A record at {record.rate_hz:g} Hz cannot become one at {record.output_rate_hz:g} Hz; allowed: a whole "
            "multiple of the output rate."
        )
    if factor == 1:
        return record
    low = filtered(record.signals, record.rate_hz, lambda f: anti_alias(f, rate_hz=record.output_rate_hz))
    mixed = low + record.leak[:, None] * (record.signals - low)
    return replace(
        record,
        signals=np.ascontiguousarray(mixed[:, ::factor]),
        rate_hz=record.output_rate_hz,
        phase_rad=record.phase_rad[::factor],
        speed_rad_s=record.speed_rad_s[::factor],
    )


def rounded(signals: np.ndarray, step: np.ndarray | float) -> np.ndarray:
    """Return signals rounded to whole steps; a step of 0 rounds nothing."""
    step = np.broadcast_to(np.asarray(step, float), signals.shape)
    safe = np.where(step > 0, step, 1.0)
    return np.where(step > 0, np.round(signals / safe) * safe, signals)
