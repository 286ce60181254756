"""Data checks before any diagnosis: what makes a channel unusable or doubtful."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .spectrum import averaged_power_density
from .tacho import pulse_times, repaired_pulses

_LARGEST = 1e30  # beyond it, and below its inverse, squares leave the number range
_USUAL_GAP = 2.5  # periods from a tacho's last pulse to the record's end: a machine that runs down has longer ones
_SHORTEST_DROPOUT = 30  # samples at one value
_MOST_STEPS = 200  # of a coarse signal
#: Codes of findings that spoil a channel for diagnosis; the others only warn.
UNUSABLE = ("dead", "mostly missing", "out of range")


@dataclass(frozen=True)
class DataCheck:
    """One defect of the data.

    Attributes
    ----------
    code : str
        ``"missing samples"``, ``"mostly missing"``, ``"out of range"``, ``"dead"``, ``"dropouts"``, ``"clipping"``,
        ``"offset"``, ``"drift"``, ``"aliasing"``, ``"coarse"``, ``"tacho"``.
    channel : str
    message : str
        What was seen, with numbers, and what to do.
    severity : float
        0 (a note) to 1 (the channel cannot be trusted).
    """

    code: str
    channel: str
    message: str
    severity: float


def check_channel(signal: np.ndarray, *, rate_hz: float, name: str) -> list[DataCheck]:
    """Return the defects of one channel.

    Parameters
    ----------
    signal : numpy.ndarray, shape (samples,)
    rate_hz : float
    name : str
        For the messages.

    Examples
    --------
    >>> import numpy as np
    >>> wave = np.sin(np.arange(10000) * 0.05)
    >>> [check.code for check in check_channel(np.clip(wave, -0.7, 0.7), rate_hz=1000, name="x")]
    ['clipping']
    """
    found: list[DataCheck] = []
    finite = np.isfinite(signal)
    if not finite.all():
        share = 1.0 - float(finite.mean())
        code = "mostly missing" if share > 0.2 else "missing samples"
        found.append(
            DataCheck(
                code,
                name,
                f"{name}: {share:.2%} of the samples are missing (NaN or infinite).",
                min(1.0, 5 * share),
            )
        )
        if code == "mostly missing":
            return found
        signal = signal[finite]
    largest = float(np.abs(signal).max(initial=0.0))
    if largest > _LARGEST or 0.0 < largest < 1.0 / _LARGEST:
        message = f"{name}: values up to {largest:.3g} are no measurement. Check unit, sensitivity and number format."
        return [*found, DataCheck("out of range", name, message, 1.0)]
    if signal.size == 0 or float(np.ptp(signal)) == 0.0:
        found.append(DataCheck("dead", name, f"{name}: constant signal, no sensor or no cable.", 1.0))
        return found
    for check in (_dropouts, _clipping, _offset_and_drift, _coarse):
        found += check(signal, name)
    return found + _aliasing(signal, rate_hz, name)


def _dropouts(signal: np.ndarray, name: str) -> list[DataCheck]:
    """Find stretches held at one value in the middle of a moving signal.

    A slow signal in steps is held as well, at its turning points: but it enters and leaves by one step.
    """
    still = signal[1:] == signal[:-1]
    if np.count_nonzero(still) <= _SHORTEST_DROPOUT:
        return []
    moves = np.flatnonzero(~still)
    jumps = np.abs(signal[moves + 1] - signal[moves])
    lengths = np.diff(moves) - 1
    if lengths.max(initial=0) <= _SHORTEST_DROPOUT:
        return []
    low, high = np.percentile(signal, [0.5, 99.5])
    held = signal[moves[1:]]
    abrupt = np.maximum(jumps[:-1], jumps[1:]) > 2.5 * jumps.min()
    typical = float(np.median(lengths)) if lengths.size else 0.0
    long_stretches = abrupt & (held > low) & (held < high) & (lengths > max(_SHORTEST_DROPOUT, 30 * typical))
    lost = int(lengths[long_stretches].sum())
    if lost < max(_SHORTEST_DROPOUT, 0.001 * signal.size):
        return []
    message = (
        f"{name}: {int(long_stretches.sum())} dropouts, {lost / signal.size:.1%} of the samples held at one value."
    )
    return [DataCheck("dropouts", name, message, min(1.0, 0.3 + 5 * lost / signal.size))]


def _clipping(signal: np.ndarray, name: str) -> list[DataCheck]:
    """Find a heap of samples at an end of the range, denser than the samples just inside it.

    A sine puts at most 2.4 times as many samples in the outermost slice as in the next one; clipping piles them up.
    Where values come in steps (quantised, or few samples a period), the next step inwards is the next slice. Crests
    that are always sampled at the same two places make a heap too, which scatters about a step further in: what is
    clipped lies at the end itself, or stays there for three samples or more.
    """
    span = float(np.ptp(signal))
    slice_width = 2e-3 * span
    worst = 0
    for extreme in (signal - signal.min(), signal.max() - signal):
        near = extreme < 0.5 * slice_width
        outer = int(np.count_nonzero(near))
        if outer <= max(8, 2e-5 * signal.size):
            continue
        following = int(((extreme >= 0.5 * slice_width) & (extreme < 3 * slice_width)).sum())
        inner = extreme[extreme >= 0.5 * slice_width]
        following = max(following, int((inner < inner.min() + slice_width).sum()))
        runs = int(((extreme[1:] == extreme[:-1]) & (extreme[1:] == 0)).sum())
        at_end, staying = int(np.count_nonzero(extreme == 0)), int((near[2:] & near[1:-1] & near[:-2]).sum())
        if outer > 3 * max(following, 1) and runs >= 4 and (2 * at_end >= outer or staying >= 4):
            worst = max(worst, outer)
    if not worst:
        return []
    share = worst / signal.size
    message = f"{name}: clipped, {worst} samples ({share:.2%}) lie at the end of the range. Reduce the gain and repeat."
    return [DataCheck("clipping", name, message, min(1.0, 0.4 + 20 * share))]


def _offset_and_drift(signal: np.ndarray, name: str) -> list[DataCheck]:
    mean, deviation = float(signal.mean()), float(signal.std())
    found = []
    if abs(mean) > 20 * deviation:
        message = f"{name}: constant offset {mean:.3g} is {abs(mean) / deviation:.0f} times the vibration; removed."
        found.append(DataCheck("offset", name, message, 0.0))
    if signal.size >= 2000:
        starts = np.arange(20) * signal.size // 20
        sizes = np.diff(starts, append=signal.size)
        means = np.add.reduceat(signal, starts) / sizes
        apart = signal - np.repeat(means, sizes)
        rest = float(np.median(np.sqrt(np.add.reduceat(apart * apart, starts) / sizes)))
        if np.ptp(means) > 5 * rest and rest > 0:
            message = f"{name}: the mean drifts by {np.ptp(means):.3g}, {np.ptp(means) / rest:.0f} times the vibration."
            found.append(DataCheck("drift", name, message, 0.4))
    return found


def _coarse(signal: np.ndarray, name: str) -> list[DataCheck]:
    """Find a quantisation step that is large beside the vibration."""
    # A few samples say it of most signals; sorting many takes longer.
    if signal.size < 1000 or np.unique(signal[:1000]).size > _MOST_STEPS:
        return []
    steps = np.unique(signal[:20000])
    if steps.size > _MOST_STEPS:
        return []
    step = float(np.median(np.diff(steps))) if steps.size > 1 else 0.0
    deviation = float(signal.std())
    # A tone locked to the sampling rate has few values however fine the steps are: it repeats exactly.
    repeats = any(np.array_equal(signal[:800], signal[lag : lag + 800]) for lag in range(1, 201))
    if step < 0.5 * deviation or repeats:
        return []
    message = f"{name}: resolution step {step:.3g} beside a vibration of {deviation:.3g} rms. Increase the gain."
    return [DataCheck("coarse", name, message, 0.5)]


def _aliasing(signal: np.ndarray, rate_hz: float, name: str) -> list[DataCheck]:
    """Suspect aliasing when the spectrum is not rolled off at the end of the band.

    An anti-alias filter leaves the last part of the band far below the rest. A spectrum that rises towards the end,
    well above its own middle, has energy that must continue beyond it. A flat noise floor says nothing, and neither
    does the foot of a strong line.
    """
    if signal.size < 4096:
        return []
    _, density = averaged_power_density(signal[None, : 1 << 19], rate_hz=rate_hz, segment_samples=2048)
    count = density.size
    end = _middling_power(density[0], int(0.97 * count), count - 2)
    if end == 0:
        return []
    # What leaked is in it: a floor that a line's foot covers there, and not at the end, may be the same.
    middle = float(np.median(density[0, int(0.2 * count) : int(0.8 * count)]))
    if end <= 4 * middle:
        return []
    excess = f"{10 * np.log10(end / middle):.0f} dB above" if middle > 0 else "far above"
    message = (
        f"{name}: the spectrum is strongest at the end of its band ({excess} the "
        "middle): content beyond half the sampling rate may be folded in. Was there an anti-alias filter?"
    )
    return [DataCheck("aliasing", name, message, 0.3)]


def _middling_power(density: np.ndarray, first: int, last: int) -> float:
    """Return the median power density of bins ``first`` to ``last`` - 1; what may have leaked there counts as 0."""
    size = density.size
    leaked = np.convolve(density, _leakage_shape(size)[first : last + size - 1], mode="valid")
    part = density[first:last]
    return float(np.median(np.where(part > np.maximum(3 * leaked, 1e-16 * density.max()), part, 0.0)))


@lru_cache(maxsize=4)
def _leakage_shape(size: int) -> np.ndarray:
    """Return the most that the Hann window lets leak from bins three away and further, shape (2 size - 1,).

    At d bins a line is down to at most 1 / (pi d^3) in amplitude. No distance is in the middle.
    """
    distance = np.abs(np.arange(1 - size, size)).astype(float)
    shape = np.where(distance >= 3, 1 / (np.pi * np.maximum(distance, 1) ** 3) ** 2, 0.0)
    shape.setflags(write=False)
    return shape


def check_tacho(signal: np.ndarray, *, rate_hz: float, name: str) -> list[DataCheck]:
    """Return what was put right in a tacho's pulse train: pulses filled in, false ones left out, ends without pulses.

    Parameters
    ----------
    signal : numpy.ndarray, shape (samples,)
        Finite.
    rate_hz : float
    name : str
        For the message.
    """
    times = pulse_times(signal, rate_hz=rate_hz)
    if times.size < 3:
        return []
    found = repaired_pulses(times)
    silent = _silent_ends(found.times_s, signal.size / rate_hz, name)
    if not found.missing and not found.false:
        return silent
    message = (
        f"{name}: of {found.times_s.size} pulses {found.missing} were missing and filled in, {found.false} false ones "
        "left out. Check gap and reflecting mark of the tacho."
    )
    share = (found.missing + found.false) / found.times_s.size
    return [DataCheck("tacho", name, message, min(1.0, 5 * share)), *silent]


def _silent_ends(times_s: np.ndarray, duration_s: float, name: str) -> list[DataCheck]:
    """Say how long a record goes on before its first and after its last pulse, where that is no usual distance."""
    periods = np.diff(times_s)
    spans = (times_s[0], periods[0], "before the first"), (duration_s - times_s[-1], periods[-1], "after the last")
    found = []
    for span, period, where in spans:
        if span > _USUAL_GAP * period:
            message = (
                f"{name}: no pulses in the {span:.3g} s {where} one; there the speed is taken as constant, and phases "
                "are guesses. Cut the record, or look for the fault of the tacho."
            )
            found.append(DataCheck("tacho", name, message, min(1.0, 2 * span / duration_s)))
    return found


def repair(signal: np.ndarray) -> np.ndarray:
    """Return the signal with missing samples interpolated linearly; unchanged when none is missing, 0 when all are."""
    finite = np.isfinite(signal)
    if finite.all():
        return signal
    if not finite.any():
        return np.zeros_like(signal)
    index = np.arange(signal.size)
    return np.interp(index, index[finite], signal[finite])
