"""The orders of a file over its run: what ``rotorwise orders`` shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..simulators.errors import InvalidValueError
from .look import Looked, Shaft, shaft_of, without_speed
from .memory import MemoryNeed
from .probe_pair import probe_pair

if TYPE_CHECKING:
    from .signal.orbit import Ellipse, FullSpectrum
    from .signal.order_map import OrderMap, Waterfall
    from .signal.vold_kalman import OrderKnots

#: Peak of the whole command with its report: 40 bytes a sample of one channel and 62 to 72 of four, measured between 2
#: and 60 minutes at 25.6 kHz with a tacho and without, and 0.16 to 0.27 GB besides.
MEMORY = MemoryNeed(always=0.3e9, a_sample=32.0, a_value=11.0)
_POINTS = 400
_FRAME_TURNS = 16
_RUN_UP = 1.1  # highest over lowest speed from which orders and fixed frequencies part visibly
#: Above the noise: less tells no phase and no orbit.
CLEAR_DB = 10.0
#: Bandwidth of the order filters over the lowest speed: neighbouring half orders are still kept apart.
_BANDWIDTH = 0.15


@dataclass(frozen=True, eq=False)
class FollowedOrder:
    """One order on one channel over the run.

    Attributes
    ----------
    channel : int
    order : float
    amplitude, phase_deg : numpy.ndarray, shape (points,)
        Peak amplitude, NaN where the order exceeds half the sampling rate, and the lead over the tacho's mark (over
        an arbitrary zero without one).
    noise : float
        Amplitude that noise has in a frame of the order map near this order.
    """

    channel: int
    order: float
    amplitude: np.ndarray
    phase_deg: np.ndarray
    noise: float


@dataclass(frozen=True, eq=False)
class Orders:
    """What the command shows: speed, map, orders at some points of time, and where the first orbit lies.

    ``full`` is over orders, where two probes are at right angles; ``waterfall`` where the speed varies; the bandwidth
    is that of the order filters.
    """

    shaft: Shaft
    map: OrderMap
    time_s: np.ndarray
    speed_hz: np.ndarray
    followed: tuple[FollowedOrder, ...]
    waveforms: OrderKnots
    orbits: tuple[tuple[float, Ellipse, complex, complex], ...]
    orbit_channels: tuple[int, int] | None
    full: FullSpectrum | None
    waterfall: Waterfall | None
    bandwidth_hz: float

    @property
    def goes_one_way(self) -> bool:
        """Whether the speed rises or falls throughout: going up and down would draw every curve over itself."""
        speed, total = self.speed_hz, float(np.abs(np.diff(self.speed_hz)).sum())
        return bool(np.ptp(speed) > 0.05 * speed.mean() and total < 1.2 * abs(speed[-1] - speed[0]))


def measure(
    looked: Looked,
    wanted: tuple[float, ...],
    *,
    highest_order: float,
    bandwidth_hz: float | None = None,
    range_hz: tuple[float, float] | None = None,
) -> Orders:
    """Return the orders of a file.

    Raises
    ------
    InvalidValueError
        Without a speed, when the record is too short for one frame, or for orders or a bandwidth that it cannot hold.
    """
    from .signal.order_map import order_map
    from .signal.vold_kalman import order_knots

    shaft = shaft_of(looked, range_hz=range_hz)
    if shaft is None:
        raise without_speed(looked, range_hz)
    _check_orders(wanted, shaft, looked.recording.rate_hz, bandwidth_hz)
    recording, phase = looked.recording, shaft.phase_turns
    turns = int(np.floor(phase[-1]) - np.ceil(phase[0]))
    frame = max(min(_FRAME_TURNS, turns // 2), 1)
    found = order_map(
        recording.signals,
        rate_hz=recording.rate_hz,
        phase_turns=phase,
        # Where an order is followed the map says what noise is.
        highest_order=max(highest_order, *wanted),
        turns_a_frame=frame,
        turns_a_step=max(frame // 4, 1),
    )
    bandwidth = _BANDWIDTH * shaft.lowest_hz if bandwidth_hz is None else bandwidth_hz
    waveforms = order_knots(
        recording.signals, rate_hz=recording.rate_hz, phase_turns=phase, orders=wanted, bandwidth_hz=bandwidth
    )
    # The filters are still filling at both ends.
    edge = min(int(recording.rate_hz / shaft.lowest_hz * 4), recording.samples // 8)
    first, last = _with_pulses(shaft, recording.rate_hz, edge, recording.samples - 1 - edge)
    at = np.linspace(first, last, min(_POINTS, recording.samples)).astype(int)
    envelopes = waveforms.envelope_at(at)
    speed = np.interp(at / recording.rate_hz, shaft.time_s, shaft.speed_hz)
    followed = _followed(wanted, envelopes, speed, found, 0.5 * recording.rate_hz)
    pair, orbits = _orbits(looked, wanted, envelopes)
    highest = float(found.orders[-1])
    return Orders(
        shaft, found, at / recording.rate_hz, speed, followed, waveforms, orbits, pair,
        None if pair is None else _full_spectrum(looked, pair, phase, highest), _waterfall(looked, shaft, highest),
        bandwidth,
    )  # fmt: skip


def _followed(
    wanted: tuple[float, ...], envelopes: np.ndarray, speed_hz: np.ndarray, found: OrderMap, highest_hz: float
) -> tuple[FollowedOrder, ...]:
    """Return each channel's orders: beyond half the sampling rate one is not zero but unknown."""
    return tuple(
        FollowedOrder(
            channel,
            order,
            np.where(order * speed_hz < highest_hz, np.abs(one), np.nan),
            np.degrees(np.angle(one)),
            _noise_at(found, channel, order, highest_hz),
        )
        for channel, rows in enumerate(envelopes)
        for order, one in zip(wanted, rows, strict=True)
    )


def _check_orders(wanted: tuple[float, ...], shaft: Shaft, rate_hz: float, bandwidth_hz: float | None) -> None:
    """Raise InvalidValueError for orders that the record cannot hold, or a filter that cannot keep them apart."""
    highest = 0.5 * rate_hz / shaft.lowest_hz
    if max(wanted) >= highest:
        raise InvalidValueError(
            f"Order {max(wanted):g}; allowed: below {highest:.4g}, half the sampling rate at "
            f"{60 * shaft.lowest_hz:.0f} rpm. Leave it out."
        )
    widest = min(np.diff([0.0, *sorted(wanted)])) * shaft.highest_hz
    if bandwidth_hz is not None and bandwidth_hz > widest:
        raise InvalidValueError(
            f"Bandwidth {bandwidth_hz:g} Hz; allowed: up to {widest:.4g} Hz, the distance of these orders from each "
            f"other and from zero at {60 * shaft.highest_hz:.0f} rpm. Give a narrower one."
        )


def _with_pulses(shaft: Shaft, rate_hz: float, first: int, last: int) -> tuple[int, int]:
    """Return the part of a range of samples in which a tacho tells the angle; the whole range without one."""
    if shaft.method != "tacho":
        return first, last
    # The speed's times are middles, a turn or more from its ends.
    begin = int((shaft.time_s[0] - 1 / shaft.speed_hz[0]) * rate_hz)
    end = int((shaft.time_s[-1] + 1 / shaft.speed_hz[-1]) * rate_hz)
    if max(first, begin) < min(last, end):
        return max(first, begin), min(last, end)
    return max(begin, 0), min(end, shaft.phase_turns.size - 1)


def _noise_at(found: OrderMap, channel: int, order: float, highest_hz: float) -> float:
    """Return the noise floor of the order map beside an order, over the frames that can hold it."""
    from .signal.spectrum import noise_floor

    held = order * found.speed_hz < highest_hz
    rows = found.amplitude[channel, held if held.any() else slice(None)]
    mean = np.sqrt((np.abs(rows) ** 2).mean(axis=0))[None]
    floor = noise_floor(mean, half_width_bins=max(int(1.0 / found.orders[1]), 8))[0]
    return float(floor[int(np.argmin(np.abs(found.orders - order)))])


def _orbits(
    looked: Looked, wanted: tuple[float, ...], envelopes: np.ndarray
) -> tuple[tuple[int, int] | None, tuple[tuple[float, Ellipse, complex, complex], ...]]:
    """Return the pair of probes, and each order's ellipse where it is largest."""
    from .signal.orbit import ellipse

    pair = probe_pair(looked.recording.channels)
    if pair is None:
        return None, ()
    found = []
    for number, order in enumerate(wanted):
        x, y = (envelopes[channel, number] for channel in pair)
        largest = int(np.argmax(np.abs(x) ** 2 + np.abs(y) ** 2))
        one, other = complex(x[largest]), complex(y[largest])
        found.append((float(order), ellipse(one, other), one, other))
    return pair, tuple(found)


def _full_spectrum(looked: Looked, pair: tuple[int, int], phase: np.ndarray, highest_order: float) -> FullSpectrum:
    """Return the whirl of the two probes over orders: its frequencies are in turns of the shaft."""
    from .signal.orbit import full_spectrum
    from .signal.order_map import samples_a_turn
    from .signal.order_tracking import angular_resample

    per_turn = samples_a_turn(highest_order)
    x, y = angular_resample(looked.recording.signals[list(pair)], phase_turns=phase, samples_per_turn=per_turn)
    return full_spectrum(x, y, rate_hz=float(per_turn))


def _waterfall(looked: Looked, shaft: Shaft, highest_order: float) -> Waterfall | None:
    """Return spectra over time of a run whose speed varies: what stays at its frequency there is no order."""
    if shaft.highest_hz < _RUN_UP * shaft.lowest_hz:
        return None
    from .signal.order_map import waterfall

    recording = looked.recording
    highest_hz = min(highest_order * shaft.highest_hz, 0.5 * recording.rate_hz)
    # Finer, and a line would move through several bins within a frame.
    resolution_hz = max(0.5 * shaft.lowest_hz, 4 / recording.duration_s)
    if resolution_hz > recording.rate_hz / 16:
        return None
    return waterfall(
        recording.signals, rate_hz=recording.rate_hz, highest_hz=highest_hz, resolution_hz=resolution_hz, frames=200
    )


def summary(found: Orders, one: FollowedOrder) -> dict[str, Any]:
    """Return one order in numbers, SI units: median, largest value, where it is, its phase there, and over noise.

    A phase is stated where it has a mark to refer to and the order stands 10 dB above the noise.
    """
    top = int(np.nanargmax(one.amplitude))
    over_noise = 20 * float(np.log10(max(one.amplitude[top], 1e-300) / max(one.noise, 1e-300)))
    has_phase = found.shaft.has_mark and over_noise > CLEAR_DB
    return {
        "order": one.order,
        "median": float(np.nanmedian(one.amplitude)),
        "largest": float(one.amplitude[top]),
        "rpm_at_largest": float(60 * found.speed_hz[top]),
        "phase_deg_at_largest": float(one.phase_deg[top]) if has_phase else None,
        "over_noise_db": over_noise,
    }
