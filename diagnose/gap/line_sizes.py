"""Sizes of lines that have no phase to the shaft: beside its orders, at fixed frequencies, and in the envelope.

The record's own order lines and its drift are taken off first. A line's power is what its band holds beyond the noise
floor on both sides; its amplitude is that of the sine with this power, 0 where the floor holds more. Slipping and
wandering lines fill a band, so that no peak is picked.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .line_noise import carriers_of
from .lines import LineKind

#: Half width of a line's band as a share of its frequency: bearings slip; supply and speed wander.
SLIP, WANDER = 0.02, 0.004
#: Least half width in lines of the spectrum: the main lobe of a Hann window.
LEAST_BINS = 2.5
#: The floor is taken from the band's edge to this many half widths, at least so many lines of the spectrum a side.
FLOOR_WIDTHS, FLOOR_BINS = 4.0, 6.0
#: Mean over median of the power of noise in one line of the spectrum.
MEAN_OVER_MEDIAN = 1 / np.log(2)
#: Independent values in a row of Hann-weighted spectral lines.
HANN_INDEPENDENT = 2 / 3
#: Band of the envelope as a share of the sampling rate, and its lowest order.
ENVELOPE_BAND, ENVELOPE_LOWEST_ORDER = (0.1, 0.4), 15.0
#: Pieces of the envelope's band within which noise is taken to be even.
NOISE_PIECES = 16
#: Quarter of an envelope's power, in that of noise, up to which a series of so many terms is exact to 1e-14.
SERIES_TO, SERIES_TERMS = 0.1, 9
#: Lines above this share of the sampling rate are bent by the anti-alias filter; below so many periods in the record
#: a line is not told from the mean.
HIGHEST_SHARE, FEWEST_PERIODS = 0.4, 2.5
#: Powers of time, from 0, that are taken off a record before slow lines are looked at.
DRIFT_POWERS = 3
#: A size is repeated no better than this share.
REPEATED = 0.1
#: Half width of a Hann window's main lobe in lines of the spectrum.
MAIN_LOBE = 2.0
#: Share of a line at a fixed distance in Hz from which on a line at an order, in its band, may be what is seen there.
HELD = 0.3
#: Widths of an order within which its skirt is looked for.
SKIRT = 4.0
#: Share of its distance from an order by which a line must be clear of the order's wander for a record to tell it.
APART = 0.25
#: Share of an order's wander beyond which a band that begins there does not overlap it: rounding.
TOUCHING = 0.999
#: Distance to the nearest locked order that a band keeps, as a share; half orders are locked up to this order.
KEPT_CLEAR = 0.8
HALVES_TO = 6.5


def line_sizes(
    signals: np.ndarray,
    *,
    rate_hz: float,
    turns: np.ndarray,
    locked: tuple[np.ndarray, np.ndarray],
    orders: Sequence[float],
    kinds: Sequence[LineKind],
    accelerations: Sequence[bool],
    missing_noise: np.ndarray | None = None,
    doubted: bool = True,
    carriers: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitudes and standard deviations, both (channels, lines); infinite deviations where nothing is seen.

    Parameters
    ----------
    signals : ndarray (channels, samples)
    rate_hz : float
    turns : ndarray (samples,)
        Shaft angle in turns.
    locked : tuple of ndarray (orders,), ndarray (channels, orders)
        The record's phase-locked orders and their complex amplitudes, taken off first.
    orders, kinds : sequence
        Of the lines wanted.
    accelerations : sequence of bool
        Which channels have an envelope worth looking at.
    missing_noise : ndarray (channels,), optional
        Standard deviation of the noise in the envelope's band that the signals do not hold, but the records that they
        are compared with do.
    doubted : bool
        Whether deviations hold what neighbouring lines and orders may have left in a band.
    carriers : ndarray (orders, samples), optional
        `carriers_of` the locked orders, where they are known already.
    """
    speed_hz = (turns[-1] - turns[0]) / (turns.size - 1) * rate_hz
    carriers = carriers_of(locked[0], turns) if carriers is None else carriers
    left = _without_drift(signals - np.real(np.conj(locked[1]) @ carriers))
    spectra = {False: line_power(left)}
    if any(kind.envelope for kind in kinds):
        spectra[True] = _envelope_power(left, rate_hz, speed_hz, missing_noise)
    resolution = rate_hz / turns.size
    sizes = np.zeros((signals.shape[0], len(orders)))
    deviations = np.full(sizes.shape, np.inf)
    bands: dict[int, tuple[float, float]] = {}
    for column, (order, kind) in enumerate(zip(orders, kinds, strict=True)):
        frequency = abs(order * speed_hz + kind.frequency_hz)
        half = _half_width(order, speed_hz, resolution, kind)
        highest = HIGHEST_SHARE * rate_hz * (0.5 if kind.envelope else 1.0)
        if half <= 0 or frequency + FLOOR_WIDTHS * half > highest or frequency < FEWEST_PERIODS * resolution:
            continue
        size, deviation = _in_band(spectra[kind.envelope], frequency / resolution, half / resolution)
        unseen = kind.envelope & ~np.array(accelerations, dtype=bool)
        sizes[:, column], deviations[:, column] = size, np.where(unseen, np.inf, np.hypot(deviation, REPEATED * size))
        if not kind.envelope:
            bands[column] = frequency, half
    if doubted:
        in_hz = [bool(order and kind.frequency_hz) for order, kind in zip(orders, kinds, strict=True)]
        _doubt_neighbours(sizes, deviations, bands, MAIN_LOBE * resolution, in_hz)
        large = np.append(locked[0], _meshes(orders, kinds)) * speed_hz
        _doubt_beside_orders(sizes, deviations, bands, large, spectra[False], resolution)
    return sizes, deviations


def _without_drift(signals: np.ndarray) -> np.ndarray:
    """Return signals (channels, samples) less their mean, slope and curvature.

    A sensor that warms up moves a thousand times as much as a slow line, and reaches under any window into the bands of
    the first lines of the spectrum.
    """
    time = np.linspace(-1.0, 1.0, signals.shape[1])
    basis, _ = np.linalg.qr(np.stack([time**power for power in range(DRIFT_POWERS)], axis=1))
    return signals - (signals @ basis) @ basis.T


def _envelope_power(left: np.ndarray, rate_hz: float, speed_hz: float, missing_noise: np.ndarray | None) -> np.ndarray:
    """Return the power of every line of the envelope's spectrum, in the noise that the signals do not hold."""
    magnitude = high_envelope(left, rate_hz=rate_hz, speed_hz=speed_hz)
    if missing_noise is not None:
        magnitude = mean_envelope_in_noise(magnitude, missing_noise[:, None])
    return line_power(magnitude - magnitude.mean(axis=1, keepdims=True))


def _doubt_neighbours(
    sizes: np.ndarray,
    deviations: np.ndarray,
    bands: dict[int, tuple[float, float]],
    lobe_hz: float,
    beside: Sequence[bool],
) -> None:
    """Widen, in place, the deviation of lines whose band holds a part of another line's main lobe.

    Of a larger one; and of what lies ``beside`` an order, at a fixed distance in Hz, where its band holds a line at an
    order by itself. The sideband of a slow wheel lies 5 Hz beside the mesh at some speeds: what is seen there then is
    no line at 5 Hz, and the sideband is doubted by what is there beyond it only.
    """
    own = sizes.copy()
    for column, (frequency, half) in bands.items():
        for other, (place, reach) in bands.items():
            away = abs(place - frequency)
            if other == column or away >= half + lobe_hz:
                continue
            larger = np.where(own[:, other] > own[:, column], own[:, other], 0.0)
            if beside[column] and not beside[other] and away < half:
                larger = np.where(own[:, other] > HELD * own[:, column], own[:, column], larger)
            elif beside[other] and not beside[column] and away < reach:
                larger = np.sqrt(np.maximum(larger**2 - own[:, column] ** 2, 0.0))
            deviations[:, column] = np.hypot(deviations[:, column], larger)


def _doubt_beside_orders(
    sizes: np.ndarray,
    deviations: np.ndarray,
    bands: dict[int, tuple[float, float]],
    orders_hz: np.ndarray,
    power: np.ndarray,
    resolution_hz: float,
) -> None:
    """Widen, in place, the deviation of lines whose band the rest of a larger order reaches into.

    A drifting order does not come off whole, and its skirt looks like a line beside it: it overlaps the band, or the
    spectrum rises from the band towards the order.
    """
    frequency = np.arange(power.shape[1]) * resolution_hz
    reaches = np.maximum(WANDER * orders_hz, LEAST_BINS * resolution_hz)
    for column, (place, half) in bands.items():
        beyond = np.abs(orders_hz - place) - half
        for number in np.flatnonzero(beyond < SKIRT * reaches):
            order_hz, reach = orders_hz[number], reaches[number]
            inside = np.abs(frequency - place) <= half
            around = (np.abs(frequency - order_hz) <= reach) & ~inside
            edge = place + np.sign(order_hz - place) * (half + 1.5 * resolution_hz)
            beside = np.abs(frequency - edge) <= 1.5 * resolution_hz
            rises = power[:, beside & ~inside].max(axis=1, initial=0.0) > power[:, inside].max(axis=1, initial=0.0)
            rest = 2 * np.sqrt(power[:, around].sum(axis=1))
            overlaps = beyond[number] < TOUCHING * reach
            larger = np.where((rest > sizes[:, column]) & (rises | overlaps), rest, 0.0)
            deviations[:, column] = np.hypot(deviations[:, column], larger)


def least_seconds(order: float, kind: LineKind, speed_hz: float) -> float:
    """Return the shortest record in which a line's band holds all of the line and nothing of the shaft's orders.

    0 for a line at no frequency, or at a half order of the shaft: no length will do.
    """
    frequency_hz = abs(order * speed_hz + kind.frequency_hz)
    if not frequency_hz:
        return 0.0
    periods = FEWEST_PERIODS / frequency_hz
    if order and kind.frequency_hz:
        # Nor of the order that it stands beside, where that does not wander into its band whatever the length.
        beside = abs(kind.frequency_hz)
        away = beside - WANDER * frequency_hz
        periods = max(periods, (LEAST_BINS + MAIN_LOBE) / beside, MAIN_LOBE / away if away > APART * beside else 0.0)
    if kind.envelope or frequency_hz > HALVES_TO * speed_hz:
        return periods
    clear = _clear(frequency_hz, speed_hz)
    return max(periods, (LEAST_BINS + MAIN_LOBE) / clear) if clear else 0.0


def _clear(frequency_hz: float, speed_hz: float) -> float:
    """Return the distance to the nearest half order, in Hz."""
    halves = frequency_hz / speed_hz * 2
    return abs(halves - round(halves)) / 2 * speed_hz


def high_envelope(signals: np.ndarray, *, rate_hz: float, speed_hz: float) -> np.ndarray:
    """Return the envelope of what lies in the high band, shape (channels, samples)."""
    from scipy.fft import fft, ifft, next_fast_len

    samples = signals.shape[1]
    length = int(next_fast_len(samples) or samples)
    spectrum = np.asarray(fft(signals, length, axis=1))
    low, high = envelope_band(rate_hz, speed_hz)
    frequency = np.arange(length) * rate_hz / length
    spectrum[:, (frequency < low) | (frequency > high)] = 0
    return 2 * np.abs(np.asarray(ifft(spectrum, axis=1))[:, :samples])


def envelope_band(rate_hz: float, speed_hz: float) -> tuple[float, float]:
    """Return the lowest and the highest frequency (Hz) of the band whose envelope is looked at."""
    return max(ENVELOPE_BAND[0] * rate_hz, ENVELOPE_LOWEST_ORDER * speed_hz), ENVELOPE_BAND[1] * rate_hz


def envelope_noise(signals: np.ndarray, *, rate_hz: float, speed_hz: float) -> np.ndarray:
    """Return the standard deviation of the noise in the envelope's band, shape (channels,).

    From the median power of each piece of the band: lines that stand out of it are no noise.
    """
    power = line_power(signals - signals.mean(axis=1, keepdims=True))
    frequency = np.arange(power.shape[1]) * rate_hz / signals.shape[1]
    low, high = envelope_band(rate_hz, speed_hz)
    band = power[:, (frequency >= low) & (frequency <= high)]
    if not band.shape[1]:
        return np.zeros(signals.shape[0])
    pieces = np.array_split(band, min(NOISE_PIECES, band.shape[1]), axis=1)
    total = sum(MEAN_OVER_MEDIAN * np.median(piece, axis=1) * piece.shape[1] for piece in pieces)
    # A sine of amplitude A has the power A^2 / 4 in these lines and A^2 / 2 in the signal.
    return np.sqrt(2 * total)


def mean_envelope_in_noise(magnitude: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return the mean of an envelope to which noise of this standard deviation is added (S. O. Rice, 1945).

    Noise hides what is smaller than itself: sigma sqrt(pi / 2) L_1/2(-m^2 / 2 sigma^2), which is m + sigma^2 / 2m of a
    large m and grows with its square only of a small one.
    """
    from scipy.special import i0e, i1e

    deviation = np.maximum(noise, 1e-9 * magnitude.max(initial=0.0) + 1e-300)
    half = (magnitude / deviation) ** 2 / 4
    # Most of an envelope is smaller than the noise: Kummer's series there, as the functions take ten times as long.
    factor, large = np.ones_like(half), half > SERIES_TO
    for n in range(SERIES_TERMS, 0, -1):
        factor = 1 - (2 * n - 3) / n**2 * half * factor
    rest = half[large]
    factor[large] = (1 + 2 * rest) * i0e(rest) + 2 * rest * i1e(rest)
    return deviation * np.sqrt(np.pi / 2) * factor


def line_power(signals: np.ndarray) -> np.ndarray:
    """Return the power of every line of the spectrum under a Hann window, shape (channels, lines).

    Summed over the lines of a sine of amplitude A it is A^2 / 4.
    """
    from scipy.fft import rfft

    window = np.hanning(signals.shape[1])
    spectrum = np.asarray(rfft(signals * window, axis=1))
    return np.abs(spectrum) ** 2 / (signals.shape[1] * float((window**2).sum()))


def _is_beside_mesh(order: float, kind: LineKind) -> bool:
    """Return whether a line stands at a distance in Hz from an order that is not taken off, as a gear mesh."""
    return order > HALVES_TO and kind.frequency_hz != 0 and not kind.envelope


def _meshes(orders: Sequence[float], kinds: Sequence[LineKind]) -> np.ndarray:
    """Return the orders that some line stands beside so."""
    return np.unique([order for order, kind in zip(orders, kinds, strict=True) if _is_beside_mesh(order, kind)])


def _half_width(order: float, speed_hz: float, resolution_hz: float, kind: LineKind) -> float:
    """Return the half width of a line's band; 0 where a locked order lies too close."""
    frequency_hz = abs(order * speed_hz + kind.frequency_hz)
    least = LEAST_BINS * resolution_hz
    half = max((SLIP if kind.envelope else WANDER) * frequency_hz, least)
    if _is_beside_mesh(order, kind):
        # Both wander together; the band begins where the wander of the larger one ends.
        half = max(min(half, abs(kind.frequency_hz) - WANDER * order * speed_hz), least)
    if kind.envelope or frequency_hz > HALVES_TO * speed_hz:
        return half
    clear = _clear(frequency_hz, speed_hz)
    # The middle of a locked order's main lobe is no part of the line's band; what else is left of it doubts the line.
    # Of a drift, which is not told from a line, nothing is.
    lobe = MAIN_LOBE if frequency_hz < speed_hz / 4 else MAIN_LOBE / 2
    room = min(KEPT_CLEAR * clear, clear - lobe * resolution_hz)
    return min(half, room) if room >= least / 2 else 0.0


def _in_band(power: np.ndarray, centre: float, half: float) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitude and standard deviation of the line in a band, centre and half width in lines of the spectrum.

    The deviation is infinite where there is no noise at all: nothing was read, as from an envelope's band that is empty
    at a low rate.
    """
    reach = max(FLOOR_WIDTHS * half, half + FLOOR_BINS)
    index = np.arange(max(int(centre - reach), 1), min(int(centre + reach) + 2, power.shape[1]))
    inside = np.abs(index - centre) <= half
    beside = (np.abs(index - centre) > half + 1) & (np.abs(index - centre) <= reach)
    floor = MEAN_OVER_MEDIAN * np.median(power[:, index[beside]], axis=1)
    count, around = int(inside.sum()), int(beside.sum())
    held = power[:, index[inside]].sum(axis=1)
    independent = HANN_INDEPENDENT * count
    deviation = floor * count * np.sqrt(1 / independent + 1.4 / (HANN_INDEPENDENT * around))
    line = np.maximum(held - floor * count, 0.0)
    # A = 2 sqrt(P). The deviation is that of a line of nothing at all: a line of its own would have a smaller one, but
    # noise that happens to be large must not look certain.
    return 2 * np.sqrt(line), np.where(deviation > 0, 2 * np.sqrt(deviation), np.inf)
