"""Lines between and beyond the first orders: who owns them, whether they can be told apart, whether they rose."""

from __future__ import annotations

from dataclasses import replace

from .compare import order_change_db
from .observe import Observation
from .result import Line

_RISE_THAT_COUNTS = 2.0  # a line counts against a baseline when it at least doubled
_BEARING_MOVES = 0.025  # slip, load and contact angle move a bearing's rhythm by up to this share
_LEAST_PLACES = 4.0  # places of a line that this range must hold before a bearing's line is told from the shaft's


def long_comb(now: Observation, baseline: Observation) -> float:
    """Return the share of the orders 4X to 10X that at least tripled on some channel against the baseline, 0 to 1.

    A joint that opens, or a rotor that touches, cuts the motion off: a long comb of harmonics.
    """
    orders = [float(order) for order in range(4, 11) if not owned_by_machine(now, float(order))]
    if not orders:
        return 0.0
    risen = sum(bool((order_change_db(now, baseline, order) > 10.0).any()) for order in orders)
    return risen / len(orders)


def strongest_line(now: Observation, baseline: Observation | None, order: float) -> Line | None:
    """Return the most prominent line at a fractional order over the channels, or None.

    Lines that another shaft or a bearing owns do not count, nor lines that a baseline shows about as strong.
    """
    if owned_by_machine(now, order):
        return None
    best: Line | None = None
    for channel in range(now.channel_count):
        line = replace(now.line(order, channel=channel), expected_order=order)
        if baseline is not None:
            before = baseline.line(order, channel=channel)
            line = replace(line, baseline_amplitude=before.amplitude)
            if line.amplitude < _RISE_THAT_COUNTS * max(before.amplitude, before.noise_floor):
                continue
        if now.is_significant(line) and (best is None or line.signal_to_noise > best.signal_to_noise):
            best = line
    return best


def owned_by_machine(now: Observation, order: float) -> bool:
    """Return whether a line at this order may belong to a bearing, another shaft or a gear (within 2.5 %)."""
    plate = now.recording.nameplate
    others: list[float] = []
    for gear in plate.gears:
        for ratio in (gear.driver_ratio, gear.driven_ratio):
            if ratio is not None and abs(ratio - 1.0) > 1e-6:
                # Whole orders are the reference shaft's own, whatever else falls on them.
                others += [ratio * k for k in range(1, 15) if abs(ratio * k - round(ratio * k)) > 1e-6]
    return _near(order, others) or (near_a_bearing(now, order) and not locked_to_the_shaft(now, order))


def near_a_bearing(now: Observation, order: float) -> bool:
    """Return whether a rhythm of a known bearing, or its sideband of the shaft, lies within 2.5 % of this order."""
    owners: list[float] = []
    for bearing in now.recording.nameplate.bearings:
        orders = bearing.geometry.defect_orders()
        for base in (
            orders.outer_race,
            orders.inner_race,
            orders.ball_spin,
            2 * orders.ball_spin,
            orders.cage,
        ):
            scaled = base * bearing.shaft_ratio
            owners += [scaled * k for k in range(1, 5)] + [
                abs(scaled - 1),
                abs(scaled + 1),
                abs(scaled - 2),
                scaled + 2,
            ]
    return _near(order, owners)


def locked_to_the_shaft(now: Observation, order: float) -> bool:
    """Return whether the record shows that the line at this order is the shaft's and not a bearing's beside it.

    The shaft's line stands at the order itself. A bearing's may stand anywhere within the 2.5 % that slip, load and
    contact angle move it; where that is no wider than four times what the record tells of a line's place, a bearing's
    line would too often be taken for the shaft's, and nothing is decided. Without a significant line there is nothing
    to own.
    """
    if not bearing_resolved(now, order):
        return False
    place = _place_hz(now, order)
    lines = [now.line(order, channel=channel) for channel in range(now.channel_count)]
    seen = [line for line in lines if now.is_significant(line)]
    if not seen:
        return True
    clearest = max(seen, key=lambda line: line.signal_to_noise)
    return abs(clearest.frequency_hz - order * now.speed_hz) <= place


def bearing_resolved(now: Observation, order: float) -> bool:
    """Return whether record and speed are good enough to tell a line at this order from a bearing's beside it."""
    return _BEARING_MOVES * order * now.speed_hz >= _LEAST_PLACES * _place_hz(now, order)


def _place_hz(now: Observation, order: float) -> float:
    """Return how well the record tells the place of a line: a quarter of a bin, and the doubt of the speed."""
    return 0.25 * now.spectrum.resolution_hz + now.speed_doubt_hz(order)


def _near(order: float, owners: list[float]) -> bool:
    return any(abs(owner / order - 1.0) < _BEARING_MOVES for owner in owners)


def fractions_resolved(now: Observation) -> bool:
    """Return whether the record can show fractional orders: the speed is confirmed and 40 turns separate the lines."""
    return now.speed is not None and now.turning and now.turns >= 40 and now.speed.method != "hint only"


def doubt_of_shafts(now: Observation) -> float:
    """Return the factor for other owners of fractional orders.

    0.4 for a machine with a shaft of unknown speed; half for a speed found without any hint, since lines at fractions
    of it may just as well be multiples of the true one; else 1.
    """
    known = 1.0 if now.speed is None or now.speed.method != "vibration" else 0.5
    return known * (0.4 if any(gear.driven_teeth is None for gear in now.recording.nameplate.gears) else 1.0)
