"""Effects that the waveform itself shows, whatever the machine does: clipping, gaps, drift, coarse steps, folded lines.

These are found by the data checks before any line is compared. A channel that shows one counts for less afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...datasets.recording import Recording
from ..result import SpeedEstimate
from ..signal.checks import check_channel
from ..signal.speed import speed_from_tacho
from .lines import OrderLines
from .lost_samples import LEFT
from .phase_wander import phase_wander

#: The effect of the catalogue that each data check shows.
SHOWN_BY = {
    "clipping": "clipping",
    "dropouts": "dropped_samples",
    "missing samples": "dropped_samples",
    "mostly missing": "dropped_samples",
    "drift": "dc_drift",
    "coarse": "quantisation",
    "aliasing": "aliasing",
}
#: Only the waveform shows these; order lines do not, or only so little that other effects explain it as well.
ONLY_IN_WAVEFORM = frozenset((*SHOWN_BY.values(), "speed_wander"))
#: Of these, the ones that lose a part of the signal (`lost_samples`).
LOSSY = ("clipping", "dropped_samples")
#: A spectrum that rises towards its end may be folded, or be a resonance that a bearing's defect rings.
SUSPECTED = frozenset({"aliasing"})
#: Relative error of the lines of a channel that shows a defect, where that was not mended.
DOUBT = 0.2
#: Change of speed within a record, by its tacho, that counts as wander, and growth over the healthy records, which also
#: holds for what only the phase of 1X shows.
WANDER, WANDER_GROWTH = 0.002, 3.0
#: The least that counts where the healthy record nearest in speed has that much less: edges of a tacho are known to a
#: part of a sample, and make up to so much of their own.
LEAST_WANDER = 5e-4
#: Growth over the healthy records from which held samples, steps and trends count, and the least that counts at all:
#: share of samples held, step over the standard deviation, trend over the standard deviation.
GROWTH, LEAST_HELD, LEAST_STEP, LEAST_TREND = 4.0, 2e-3, 1e-3, 0.05
#: A line changes by so many times the relative change of speed at most: at the half-power point of a resonance with 5 %
#: of damping, 1 / (2 x 0.05).
STEEPEST = 10.0
#: Change of speed that the phase of 1X shows from which on an order's sidebands are what it makes:
#: 0.35 % of 1X each where 1500 rpm hunt at 1 Hz.
HUNTS = 2e-4
#: A wandering speed itself gives every order sidebands up to so far away: 95 % of controllers hunt below (prior of
#: ``speed_wander``).
WANDER_HZ = 3.2
#: The means of a record's pieces follow a trend, not chance, where their changes from piece to piece are this small
#: against their scatter: von Neumann's ratio is 2 by chance, 0.1 on a line, 0.3 where the offset dies out in a fifth of
#: the record (J. von Neumann, Ann. Math. Stat. 12 (1941) 367).
SMOOTH = 0.5
#: They move one way where they go less than this many times as far as from lowest to highest: a whole swing goes
#: twice as far, noise about a drift a few per cent further.
ONE_WAY = 1.5
#: What sensors of the shaft's speed measure.
SPEEDS = ("rotational_speed",)
#: Equal samples in a row that count as held. Two already where samples mostly differ by so many steps of the converter:
#: there equal neighbours are about as many as neighbours one step apart on either side, and the others were held.
HELD_RUN, ROUGH = 4, 3.0
#: Standard deviations by which equal neighbours must be more than those that chance makes.
BEYOND_CHANCE = 3.0
PIECES = 10


def seen_in_waveform(
    recordings: Sequence[Recording], healthy: Sequence[Recording], channels: Sequence[str]
) -> dict[str, tuple[str, ...]]:
    """Return the channels that show each effect in at least half of the recordings, and in no healthy one."""
    found: dict[str, list[str]] = {}
    for name in channels:
        before = set().union(*(_shown(one, name) for one in healthy)) if healthy else set()
        usual = _worst([_statistics(one, name) for one in healthy])
        counts: dict[str, int] = {}
        for one in recordings:
            own = _shown(one, name) - before
            if usual is not None:
                own |= _grown(_statistics(one, name), usual)
            if not _is_smooth(_row(one, name)):
                own.discard("dc_drift")
            for effect in own:
                counts[effect] = counts.get(effect, 0) + 1
        for effect, count in counts.items():
            if 2 * count >= len(recordings):
                found.setdefault(effect, []).append(name)
    if _wanders(recordings, healthy):
        found["speed_wander"] = []
        # A sensor of the speed drifts with the speed.
        found["dc_drift"] = [name for name in found.get("dc_drift", []) if not _shows_speed(recordings[0], name)]
    return {effect: tuple(names) for effect, names in found.items() if names or effect == "speed_wander"}


def _wanders(recordings: Sequence[Recording], healthy: Sequence[Recording]) -> bool:
    """Return whether the speed wanders within most recordings, by the tacho or by the phase of 1X against it."""
    if np.median(variations(recordings)) > max(WANDER, WANDER_GROWTH * variations(healthy).max(initial=0.0)):
        return True
    if 2 * _grown_wander(recordings, healthy) > len(recordings):
        return True
    # Every machine's speed wanders a little: without healthy records that tell, it is no news. How little of it shows
    # depends on the speed.
    usual = [(_speed_hz(one), change) for one in healthy if (change := phase_wander(one)[0]) > 0]
    grown = 0
    for one in recordings:
        change, shown = phase_wander(one)
        # Where the tacho follows the shaft, what the phase moves beyond it is the lag of a machine near resonance.
        shown &= _variation(one) < WANDER
        before = min(usual, key=lambda known: abs(known[0] - _speed_hz(one)))[1] if shown and usual else WANDER
        grown += shown and change > WANDER_GROWTH * before
    return 2 * grown > len(recordings)


def _grown_wander(recordings: Sequence[Recording], healthy: Sequence[Recording]) -> int:
    """Return in how many recordings the speed varies clearly more than in the healthy one nearest in speed."""
    usual = [(_speed_hz(one), change) for one in healthy if (change := _variation(one)) > 0]
    if not usual:
        return 0
    pairs = [(_variation(one), min(usual, key=lambda known: abs(known[0] - _speed_hz(one)))[1]) for one in recordings]
    return sum(change > max(LEAST_WANDER, WANDER_GROWTH * before) for change, before in pairs)


def _shows_speed(recording: Recording, name: str) -> bool:
    return any(one.name == name and one.quantity in SPEEDS for one in recording.channels)


@dataclass(frozen=True)
class _Statistics:
    """Share of held samples, and step and trend over the standard deviation."""

    held: float
    step: float
    trend: float


def _statistics(recording: Recording, name: str) -> _Statistics:
    signal = _row(recording, name)
    signal = signal[np.isfinite(signal)]
    deviation = float(signal.std()) or 1.0
    same = np.concatenate([[0], np.diff(signal) == 0, [0]]).astype(int)
    edges = np.flatnonzero(np.diff(same))
    runs = edges[1::2] - edges[::2] + 1
    # Samples held at an end of the range are clipped, not lost.
    inside = (signal[edges[::2]] > signal.min()) & (signal[edges[::2]] < signal.max())
    runs = runs[inside]
    levels = np.unique(signal)
    step = float(np.diff(levels).min()) if levels.size > 1 else 0.0
    held = float(runs[runs >= HELD_RUN].sum())
    apart = np.abs(np.diff(signal))
    if step and np.median(apart) >= ROUGH * step:
        by_chance = float(((apart > 0) & (apart < 1.5 * step)).sum()) / 2
        # Both are counts: of the first, and half of the second.
        scatter = math.sqrt(1.5 * by_chance)
        held = max(held, float(runs.sum()) - 2 * (by_chance + BEYOND_CHANCE * scatter))
    means = _means(signal)
    # What a straight line through the pieces' means changes over the record.
    trend = float(abs(np.polyfit(np.arange(PIECES), means, 1)[0]) * PIECES)
    return _Statistics(held / signal.size, step / deviation, trend / deviation)


def _means(signal: np.ndarray) -> np.ndarray:
    return np.array([piece.mean() for piece in np.array_split(signal[np.isfinite(signal)], PIECES)])


def _is_smooth(signal: np.ndarray) -> bool:
    """Return whether the mean moves steadily one way: slow vibration and coarse steps shift it as well, to and fro."""
    means = _means(signal)
    if float(np.abs(np.diff(means)).sum()) > ONE_WAY * float(np.ptp(means)):
        return False
    return float(np.sum(np.diff(means) ** 2)) < SMOOTH * float(np.sum((means - means.mean()) ** 2))


def _worst(found: Sequence[_Statistics]) -> _Statistics | None:
    if not found:
        return None
    return _Statistics(max(s.held for s in found), max(s.step for s in found), max(s.trend for s in found))


def _grown(now: _Statistics, usual: _Statistics) -> set[str]:
    found = set()
    coarse = now.step > max(GROWTH * usual.step, LEAST_STEP)
    if coarse:
        found.add("quantisation")
    # Coarse steps hold samples as well.
    elif now.held > max(GROWTH * usual.held, LEAST_HELD):
        found.add("dropped_samples")
    if now.trend > max(GROWTH * usual.trend, LEAST_TREND):
        found.add("dc_drift")
    return found


def _shown(recording: Recording, name: str) -> set[str]:
    return {SHOWN_BY[code] for code in _codes(recording, name) if code in SHOWN_BY}


def _row(recording: Recording, name: str) -> np.ndarray:
    return recording.signals[[channel.name for channel in recording.channels].index(name)]


def with_doubt(
    lines: OrderLines,
    seen: Mapping[str, Sequence[str]],
    variation: np.ndarray,
    as_recorded: OrderLines | None = None,
    turning: Sequence[str] = (),
) -> OrderLines:
    """Return the lines, less certain at the probes whose waveform shows a defect.

    Probes that have lost a part of their signal are left out, where others remain, but where the lost samples were put
    back; and sidebands that a wandering speed makes.

    Parameters
    ----------
    lines : OrderLines
    seen : mapping of str to sequence of str
        From `seen_in_waveform`.
    variation : ndarray (conditions,)
        Of the speed within each record, see `variations`: where the speed wanders, so do all lines.
    as_recorded : OrderLines, optional
        Where lost samples were put back in ``lines``: the same without that.
    turning : sequence of str
        Probes of an angular velocity: they may show as much as the speed itself wanders, at whatever frequency.
    """
    left = 0.0 if as_recorded is None else LEFT * np.abs(lines.amplitudes - as_recorded.amplitudes)
    lossy = lossy_channels(seen) if as_recorded is None else set()
    bad = {name for effect, names in seen.items() for name in names if effect not in LOSSY} | lossy
    doubt = np.array([DOUBT if probe in bad else 0.0 for probe in lines.probes])
    if lossy and not lossy.issuperset(lines.probes):
        doubt[[probe in lossy for probe in lines.probes]] = np.inf
    # 0 times infinity: a line of exactly nothing at a probe that is left out.
    share = np.where(np.isinf(doubt)[None, :, None], np.inf, 0.0)
    share = share + np.where(np.isinf(doubt), 0.0, doubt)[None, :, None] * np.abs(lines.amplitudes)
    if "speed_wander" in seen:
        smeared = np.minimum(STEEPEST * variation, 1.0)[:, None, None] * np.abs(lines.amplitudes)
        share = np.where(_beside_an_order(lines)[:, None, :], np.inf, np.hypot(share, smeared))
        sizes = np.array([not kind.phase for kind in lines.kinds])
        shown = np.array([probe in turning for probe in lines.probes])[:, None] & sizes
        wander = variation * np.array([one.speed_rpm for one in lines.conditions]) * 2 * np.pi / 60
        share = np.hypot(share, np.where(shown[None], wander[:, None, None], 0.0))
    return replace(lines, deviations=np.hypot(lines.deviations, np.hypot(share, left)))


def without_hunting(lines: OrderLines, recordings: Sequence[Recording]) -> OrderLines:
    """Return the lines, those without phase left out that lie beside an order where its phase moves with the shaft's.

    A machine near a resonance lags behind a speed that hunts, whatever the tacho follows, and so much of the order
    stands beside it.
    """
    hunts = np.array([shown and change > HUNTS for change, shown in map(phase_wander, recordings)])
    left_out = _beside_an_order(lines) & hunts[:, None]
    return replace(lines, deviations=np.where(left_out[:, None, :], np.inf, lines.deviations))


def lossy_channels(seen: Mapping[str, Sequence[str]]) -> set[str]:
    """Return the channels that have lost a part of their signal."""
    return {name for effect in LOSSY for name in seen.get(effect, ())}


def _beside_an_order(lines: OrderLines) -> np.ndarray:
    """Return where a line without phase lies so near to an order that hunting may make it, (conditions, orders)."""
    speed_hz = np.array([one.speed_rpm for one in lines.conditions])[:, None] / 60
    orders, added = np.array(lines.orders), np.array([kind.frequency_hz for kind in lines.kinds])
    sizes = np.array([not kind.phase and not kind.envelope for kind in lines.kinds])
    # A stated sideband lies beside an order whether or not that has a line of its own here.
    both = zip(lines.orders, lines.kinds, strict=True)
    locked = np.array([order for order, kind in both if order and (kind.phase or kind.frequency_hz)])
    if not locked.size:
        return np.zeros((len(lines.conditions), orders.size), dtype=bool)
    place = np.abs(orders * speed_hz + added)
    away = np.abs(place[:, :, None] - locked * speed_hz[:, :, None]).min(axis=2)
    return sizes & (away > 0) & (away <= WANDER_HZ)


def accounts_for_lines(seen: Mapping[str, Sequence[str]], probes: Sequence[str], *, mended: bool) -> bool:
    """Return whether what the waveform shows may itself be why no effect explains the lines.

    A wandering speed, and parts lost at every probe and not put back, change lines by nobody knows how much. The other
    defects change them by less than `DOUBT`, which the comparison allows for: what it still lacks is something else.
    """
    return "speed_wander" in seen or (not mended and lossy_channels(seen).issuperset(probes))


def _codes(recording: Recording, name: str) -> set[str]:
    signal = _row(recording, name)
    return {check.code for check in check_channel(signal, rate_hz=recording.rate_hz, name=name)}


def variations(recordings: Sequence[Recording]) -> np.ndarray:
    """Return the relative variation of the speed within each record, 0 without a tacho."""
    return np.array([_variation(one) for one in recordings])


def _variation(recording: Recording) -> float:
    found = _by_tacho(recording)
    return found.variation if found else 0.0


def _speed_hz(recording: Recording) -> float:
    found = _by_tacho(recording)
    return found.speed_hz if found else 0.0


def _by_tacho(recording: Recording) -> SpeedEstimate | None:
    for index, channel in enumerate(recording.channels):
        if channel.quantity == "tacho":
            found = speed_from_tacho(
                recording.signals[index],
                rate_hz=recording.rate_hz,
                pulses_per_revolution=recording.pulses_per_revolution,
            )
            if found is not None:
                return found[0]
    return None
