"""Sampling rate from a column of time stamps, and what is wrong with the stamps."""

from __future__ import annotations

import numpy as np


def rate_from_times(times_s: np.ndarray) -> tuple[float | None, tuple[str, ...]]:
    """Return the sampling rate and warnings about the stamps.

    The rate is (n - 1) / (last - first), or that of the nine steps in ten that agree where a few are broken.

    Parameters
    ----------
    times_s : numpy.ndarray, shape (samples,)
        Seconds.

    Returns
    -------
    rate_hz : float or None
        None when the stamps do not rise. A rate within one part in a million of a whole number is that
        number: stamps printed with few digits are not more exact than that.
    warnings : tuple of str
    """
    times = times_s[np.isfinite(times_s)]
    warnings: list[str] = []
    if times.size < times_s.size:
        warnings.append(f"{times_s.size - times.size} time stamps are missing or not numbers.")
    if times.size < 2 or not times[-1] > times[0]:
        return None, (*warnings, "The time column does not rise; the sampling rate cannot be taken from it.")
    steps = np.diff(times)
    step = _typical_step(steps)
    warnings.extend(_step_warnings(steps, step, float(times[0])))
    rate = float(1.0 / step)
    if round(rate) > 0 and abs(rate - round(rate)) < 1e-6 * rate:
        rate = float(round(rate))
    return rate, tuple(warnings)


def _typical_step(steps: np.ndarray) -> float:
    """Return the step to take the rate from: the mean, or the usual step where a few steps are broken.

    A gap or a jump changes the mean, and every frequency with it. When nine steps in ten agree, those count.
    """
    mean = float(steps.mean())
    usual = float(np.median(steps))
    agree = np.abs(steps - usual) <= 0.02 * abs(usual)
    if usual > 0 and 0.9 <= float(agree.mean()) < 1.0:
        return float(steps[agree].mean())
    return mean


def _step_warnings(steps: np.ndarray, mean_step: float, first: float) -> list[str]:
    found: list[str] = []
    if backwards := int(np.count_nonzero(steps < 0)):
        found.append(f"Time runs backwards at {backwards} places; samples may be out of order.")
    if duplicates := int(np.count_nonzero(steps == 0)):
        found.append(
            f"{duplicates} of {steps.size + 1} time stamps repeat the one before; even sampling at the "
            "mean rate is assumed."
        )
    usual = float(np.median(steps)) or mean_step
    gaps = steps > 3.0 * max(usual, mean_step)
    if gaps.any():
        found.append(
            f"Gaps in the time stamps ({int(gaps.sum())}), the longest {float(steps.max()):.4g} s where "
            f"{usual:.4g} s "
            "is usual; samples are missing there."
        )
    rest = steps[~gaps & (steps > 0)]
    # Stamps of large value (seconds since 1970) carry their own rounding; that is not uneven sampling.
    allowed = 0.05 * mean_step + 4 * np.spacing(abs(first) + abs(mean_step) * steps.size)
    if rest.size and float(np.max(np.abs(rest - np.median(rest)))) > allowed:
        found.append(
            f"Uneven time steps ({float(rest.min()):.4g} to {float(rest.max()):.4g} s); even sampling at "
            "the mean rate is assumed, and every frequency depends on it."
        )
    return found


def is_steady_rise(values: np.ndarray) -> bool:
    """Whether a column rises by one constant step, within the rounding of its digits."""
    if values.size < 3 or not np.isfinite(values).all():
        return False
    steps = np.diff(values)
    mean = float(steps.mean())
    return mean > 0 and bool(np.max(np.abs(steps - mean)) <= 0.02 * mean + 4 * np.spacing(np.max(np.abs(values))))


def is_row_count(values: np.ndarray) -> bool:
    """Whether a column is whole numbers going up by one: a row number, not time.

    Milliseconds since 1970 at 1000 Hz also do, but no file has that many rows.
    """
    whole = np.all(values == np.round(values)) and np.all(np.diff(values) == 1)
    return values.size >= 2 and abs(float(values[0])) < 1e9 and bool(whole)


def epoch_scale(first: float) -> float:
    """Return the seconds in one unit of a stamp that counts from 1970; 1 when the value is no such count.

    Today is about 1.7e9 s after 1970, so 1e12 to 1e13 can only be milliseconds, and so on.
    """
    for low, scale in ((1e11, 1e-3), (1e14, 1e-6), (1e17, 1e-9)):
        if low <= abs(first) < low * 1e3:
            return scale
    return 1.0
