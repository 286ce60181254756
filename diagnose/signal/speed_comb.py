"""A comb of lines at the multiples of a speed, scored against lines placed by chance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .speed_peaks import Peaks
from .supply_lines import of_supply

#: Chance that the n-th harmonic of a turning shaft shows above the noise, n = 1, 2, ...
HARMONIC_SHOWS = np.array([0.9, 0.8, 0.7, 0.6, 0.5, 0.45, 0.4, 0.35, 0.3, 0.3, 0.25, 0.25, 0.2, 0.2, 0.2])

#: Share of a speed within which there is no other shaft; power over the own line from which one beside speaks against
#: the speed, and how fast the chance falls that it is none: by the cube.
BESIDE, FAR_STRONGER, STEEP = 0.08, 100.0, 3.0


def candidate_speeds(channels: list[Peaks], lowest_hz: float, highest_hz: float) -> np.ndarray:
    """Return the speeds worth scoring: every low line, divided by 1 to 4; shape (candidates,), sorted."""
    found: list[np.ndarray] = []
    for peaks in channels:
        strongest = np.argsort(peaks.power_ratio)[::-1]
        for divisor in (1, 2, 3, 4):
            speeds = peaks.frequency_hz[strongest] / divisor
            found.append(speeds[(speeds >= lowest_hz) & (speeds <= highest_hz)][:80])
    return np.unique(np.concatenate(found))


def best_of_clusters(candidates: np.ndarray, posterior: np.ndarray, width_hz: float) -> np.ndarray:
    """Return the best posterior of every group of candidates closer than a width."""
    if not candidates.size:
        return np.empty(0)
    starts = np.flatnonzero(np.concatenate([[True], np.diff(candidates) > width_hz]))
    return np.maximum.reduceat(posterior, starts)


def comb_scores(channels: list[Peaks], speeds_hz: np.ndarray, *, orders: np.ndarray, shows: np.ndarray) -> np.ndarray:
    """Return the log Bayes factor of a comb at each speed against lines placed by chance, shape (speeds,).

    Each order adds ln(1 - q + q B), q being the chance that it shows and B the density of the nearest line's
    position under the comb over its density under chance (one over the mean spacing of lines as strong nearby).
    A missing likely line counts against the speed, which is what tells a speed from its half. Per order the best
    channel counts, less the price of choosing it. Lines below a speed count against it: a shaft has few, while
    below the comb of a bearing there is the whole shaft.
    """
    below = np.max([lines_below(peaks, speeds_hz) for peaks in channels], axis=0)
    return comb_gains(channels, speeds_hz, orders=orders, shows=shows) - below


def comb_gains(channels: list[Peaks], speeds_hz: np.ndarray, *, orders: np.ndarray, shows: np.ndarray) -> np.ndarray:
    """Return `comb_scores` without what lines below a speed say against it, shape (speeds,)."""
    gains = np.max([order_gains(peaks, speeds_hz, orders, shows) for peaks in channels], axis=0)
    gains -= np.log(len(channels)) * (gains > 0)
    inside = orders[None, :] * speeds_hz[:, None] < channels[0].span_hz
    return np.where(inside, gains, 0.0).sum(axis=1)


def lines_below(peaks: Peaks, speeds_hz: np.ndarray) -> np.ndarray:
    """Return how many strong lines lie below 0.7 of each speed, at most 8, shape (speeds,)."""
    strong = np.concatenate([[0], np.cumsum(peaks.power_ratio > 40)])
    return np.minimum(strong[np.searchsorted(peaks.frequency_hz, 0.7 * speeds_hz)], 8.0)


def lost_to_neighbour(channels: list[Peaks], speeds_hz: np.ndarray) -> np.ndarray:
    """Return what a far stronger line close beside speaks against each speed, shape (speeds,).

    Turning shafts hardly differ by less than `BESIDE`: of two lines so close the shaft's own is the strong one, however
    many lines of a bearing lie at multiples of the other. Lines of the supply (a motor of two poles has one beside its
    1X) do not count.
    """
    own, beside = np.zeros(speeds_hz.shape), np.zeros(speeds_hz.shape)
    for peaks in channels:
        counted = np.where(of_supply(peaks.frequency_hz, 1e-3 * peaks.frequency_hz), 0.0, peaks.power_ratio)
        edges = np.searchsorted(peaks.frequency_hz, np.outer([1 - BESIDE, 1 + BESIDE], speeds_hz))
        for i, (first, last) in enumerate(edges.T):
            near = slice(first, last)
            away = np.abs(peaks.frequency_hz[near] - speeds_hz[i])
            at = away <= np.maximum(5 * peaks.deviation_hz[near], 1e-3 * speeds_hz[i])
            own[i] += peaks.power_ratio[near][at].max(initial=0.0)
            beside[i] += counted[near][~at].max(initial=0.0)
    return STEEP * np.log1p(beside / (FAR_STRONGER * np.maximum(own, len(channels))))


def order_gains(peaks: Peaks, speeds_hz: np.ndarray, orders: np.ndarray, shows: np.ndarray) -> np.ndarray:
    """Return what each order of each speed gains by the line nearest to it, shape (speeds, orders)."""
    return place_gains(peaks, orders[None, :] * speeds_hz[:, None], speeds_hz, shows)


def place_gains(peaks: Peaks, wanted: np.ndarray, speeds_hz: np.ndarray, shows: np.ndarray) -> np.ndarray:
    """Return what frequencies that belong to speeds gain by the lines nearest to them, shape (speeds, places).

    Parameters
    ----------
    peaks : Peaks
    wanted : numpy.ndarray, shape (speeds, places)
    speeds_hz : numpy.ndarray, shape (speeds,)
        Lines within half a speed of a place say how densely lines lie there by chance.
    shows : numpy.ndarray, shape (places,)
        Chance that each shows above the noise.
    """
    right = np.minimum(np.searchsorted(peaks.frequency_hz, wanted), peaks.frequency_hz.size - 1)
    left = np.maximum(right - 1, 0)
    to_left, to_right = np.abs(peaks.frequency_hz[left] - wanted), np.abs(peaks.frequency_hz[right] - wanted)
    nearer = np.where(to_left < to_right, left, right)
    deviation = np.sqrt(peaks.deviation_hz[nearer] ** 2 + (2e-4 * wanted) ** 2)
    distance = np.minimum(to_left, to_right) / deviation
    # Lines come in crowds; the spacing that chance would give is the local one.
    width = 0.5 * speeds_hz[:, None]
    count = np.searchsorted(peaks.frequency_hz, wanted + width) - np.searchsorted(peaks.frequency_hz, wanted - width)
    spacing = 2 * width / np.maximum(count, 1)
    # Neighbouring lines and a wandering speed pull some peaks: one in seven is taken five times less certain.
    density = 0.85 * np.exp(-0.5 * distance**2) + 0.15 / 5 * np.exp(-0.5 * (distance / 5) ** 2)
    bayes = spacing / (np.sqrt(2 * np.pi) * deviation) * density
    return np.log(1.0 - shows + shows * bayes)


def refine_speed(
    scores_of: Callable[[np.ndarray], np.ndarray], speed_hz: float, *, resolution_hz: float
) -> tuple[float, float]:
    """Return the best speed within one bin of a candidate, and a half interval of about 95 %.

    ``scores_of`` returns the scores of speeds by which the candidate was chosen: a score by others would leave it. They
    are the log likelihood itself; twice the standard deviation under it is the half interval.
    """
    grid = speed_hz + resolution_hz * np.linspace(-1.0, 1.0, 401)
    scores = scores_of(grid)
    inside = np.abs(grid - grid[int(np.argmax(scores))]) < 0.5 * resolution_hz
    weight = np.where(inside, np.exp(scores - scores.max()), 0.0)
    weight /= weight.sum()
    mean = float((weight * grid).sum())
    spread = float(np.sqrt((weight * (grid - mean) ** 2).sum()))
    return mean, 2.0 * max(spread, resolution_hz / 400)
