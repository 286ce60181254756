"""Unbalance, misalignment, a bent shaft and a near resonance: the 1X, 2X and 3X lines of the shaft.

How abnormal the lines are comes from the change against a baseline, or else from the severity zone; the pattern then
shares that probability between the causes. No fixed ratio of 2X to 1X decides: on measured misaligned rigs it fails.
Without a unit and without a baseline the level says nothing, and the answer stays weak.
"""

from __future__ import annotations

import numpy as np

from ..compare import comparable, floor_rise_near, odds_of_rise, order_change_db, repeatability_db, risen_db
from ..new_motion import NewMotion, new_motion
from ..observe import Observation
from ..order_lines import long_comb, owned_by_machine
from ..result import Finding, Line

#: Chance that something is wrong with the shaft, by severity zone of the measurement; None: no zone known.
_ABNORMAL = {"A": 0.03, "B": 0.10, "C": 0.50, "D": 0.80, None: 0.20}
_PRIOR_OF_RISE = 0.15
_FORCES_THAT_CANCEL = 0.25  # share of new forces that leave 1X of some sensors as it was; a judgement, not measured
_TELLING_HARMONICS = 0.02  # of 1X, in velocity: half as telling (a judgement)
_STOPPED_DB = -20.0  # a 1X that fell so far belongs to a machine that is not running as it did
_CHECKS = {
    "unbalance": "Check deposits, lost weights and the phase between bearings; balance with a trial weight.",
    "misalignment": "Check coupling alignment hot and cold, soft foot and pipe strain.",
    "resonance": "Change the speed by 10 % or do a bump test at rest: a resonance stays where it is.",
    "bent_shaft": "Measure run-out with a dial gauge on slow roll; check phase between both ends axially.",
    "rub": "Check seals and clearances; look for a drifting 1X vector at constant speed (thermal bow).",
    "looseness": "Check bolts, bearing fits and foundation; watch these lines while a bolt is tightened.",
}
_SPLIT_1X = (
    "One speed cannot tell unbalance, a bow and misalignment apart. Record slow roll and two other speeds: unbalance "
    "grows with the speed squared, a bow is there in slow roll; misalignment changes with load or temperature."
)
_SPLIT_HARMONICS = (
    "Misalignment changes with coupling and load, a loose joint with its bolts; a rub has a threshold and hysteresis "
    "in speed. A cracked shaft makes the same lines: look for a 2X peak at half the critical speed in a run-down."
)


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return what the shaft lines speak for."""
    if now.speed is None or not now.turning or now.speed.method == "hint only":
        return []
    if baseline is not None and comparable(now, baseline):
        return _judge_change(now, baseline)
    return _judge_level(now)


def _strongest_lines(now: Observation, baseline: Observation | None, orders: tuple[float, ...]) -> tuple[Line, ...]:
    from dataclasses import replace

    found = []
    for order in orders:
        for channel in range(now.channel_count):
            line = now.line(order, channel=channel)
            if now.is_significant(line):
                before = None if baseline is None else baseline.line(order, channel=channel).amplitude
                found.append(replace(line, expected_order=order, baseline_amplitude=before))
    return tuple(found)


def shaft_pattern(now: Observation) -> tuple[float, float, float | None]:
    """Return the shares of 1X and of 2X + 3X in the velocity energy, and the axial over radial level of 1X-3X."""
    radial = now.radial_channels()
    one = float(np.median([now.velocity_share(1, channel=channel) for channel in radial]))
    more = float(np.median([now.velocity_share(2, channel=c) + now.velocity_share(3, channel=c) for c in radial]))
    axial = now.axial_channels()
    if not axial or len(axial) == now.channel_count:
        return one, more, None
    return one, more, _level(now, axial) / max(_level(now, radial), 1e-300)


def _level(now: Observation, channels: list[int]) -> float:
    velocities = []
    for channel in channels:
        for order in (1.0, 2.0, 3.0):
            line = now.line(order, channel=channel)
            velocities.append(line.amplitude * float(now.velocity_factor(channel, line.frequency_hz)))
    return float(np.sqrt(np.mean(np.square(velocities)) * 3))


def _shares(one: float, more: float, axial: float | None, *, shaft_probes: bool) -> dict[str, float]:
    """Return how a pattern of shaft lines is shared between its causes; the rest is none of them.

    Shaft probes show a bow and the run-out of their track as 1X too, and a sound rotor near a critical speed is far
    louder at the shaft than at the housing: one record at one speed says less there.
    """
    tilt = 0.5 if axial is None else min(axial, 1.0)
    weight = {
        "unbalance": 0.45 * 5 * one**4 / (0.5 + tilt),
        "misalignment": 0.20 * (one + 2 * more) * (0.5 + tilt),
        "bent_shaft": 0.08 * 2 * one * (0.5 + tilt),
    }
    if shaft_probes:
        weight["bent_shaft"] *= 4
        weight["resonance"] = 0.6 * one
    return {name: value / (sum(weight.values()) + 0.25) for name, value in weight.items()}


def _judge_level(now: Observation) -> list[Finding]:
    one, more, axial = shaft_pattern(now)
    abnormal = _ABNORMAL[now.zone]
    level = "level unknown: no unit and no baseline" if now.zone is None else f"severity zone {now.zone}"
    if axial is not None:
        level += f"; axial over radial {axial:.2f}"
    summary = f"1X carries {one:.0%} and 2X + 3X {more:.0%} of the radial velocity; {level}."
    rivals = {"unbalance": ("bent_shaft", "misalignment", "resonance"), "misalignment": ("unbalance", "bent_shaft")}
    findings = []
    seen = {now.recording.channels[index].quantity for index in now.radial_channels()}
    for fault, share in _shares(one, more, axial, shaft_probes=seen == {"displacement"}).items():
        lines = _strongest_lines(now, None, (1.0,) if fault == "unbalance" else (1.0, 2.0, 3.0))
        others = rivals.get(fault, ("unbalance", "misalignment"))
        if lines:
            findings.append(Finding(fault, abnormal * share, summary, lines, _CHECKS[fault], others))
    return findings


def _judge_change(now: Observation, baseline: Observation) -> list[Finding]:
    """Judge the change: a risen 1X is shared between its causes, and so are 2X and 3X that rose without a long comb."""
    scatter = repeatability_db(now, baseline)
    radial = now.radial_channels()
    change = {order: order_change_db(now, baseline, order) for order in (1.0, 2.0, 3.0)}
    one = float(np.median(change[1.0][radial]))
    if one < _STOPPED_DB:
        return []
    rise, said_by = risen_db(change[1.0][radial], scatter)
    rose = _probability_of_rise(rise, scatter, typical_db=15.0, spread_db=8.0)
    share = float(np.median([now.velocity_share(1, channel=channel) for channel in radial]))
    text = ", ".join(
        f"{order:.0f}X {np.median(values[radial]):+.0f} dB ({values.min():+.0f} to {values.max():+.0f})"
        for order, values in change.items()
    )
    note = "; the transfer path changed too, so small changes mean nothing" if scatter > 5 else ""
    if len(said_by) < len(radial):
        names = [now.recording.channels[radial[index]].name for index in said_by]
        text += f"; 1X rose most on {', '.join(names)}"
    summary = f"Against the baseline {text}; 1X carries {share:.0%} of the radial velocity{note}."
    usable = _own_harmonics(now)
    others = np.delete(change[1.0][radial], said_by)
    causes = _causes_of_1x(now, baseline, change, share, usable, _stayed(others, scatter))
    of_one = {fault: rose * part for fault, part in causes.items()}
    largest = _risen_harmonics(now, change, usable, max(one, 0.0), scatter)
    harmonics = 0.7 * _probability_of_rise(largest, scatter, typical_db=8.0, spread_db=6.0)
    harmonics *= 1 - long_comb(now, baseline)
    shared = _causes_of_harmonics(now, change, usable, one, new_motion(now, baseline, usable))
    of_more = {fault: harmonics * part for fault, part in shared.items()}
    findings = []
    for fault in dict.fromkeys((*of_one, *of_more)):
        first, more = of_one.get(fault, 0.0), of_more.get(fault, 0.0)
        # The same lines speak twice for a misalignment, so its two probabilities do not add up.
        carried_by, split = (of_one, _SPLIT_1X) if first >= more else (of_more, _SPLIT_HARMONICS)
        lines = _strongest_lines(now, baseline, (1.0,) if carried_by is of_one else (1.0, 2.0, 3.0))
        rivals = tuple(other for other in carried_by if other != fault)
        findings.append(Finding(fault, max(first, more), summary, lines, f"{_CHECKS[fault]} {split}", rivals))
    return findings


def _probability_of_rise(change_db: float, scatter: float, *, typical_db: float, spread_db: float) -> float:
    odds = odds_of_rise(change_db, repeatability=scatter, typical_db=typical_db, spread_db=spread_db)
    odds *= _PRIOR_OF_RISE / (1 - _PRIOR_OF_RISE)
    return odds / (1 + odds)


def _stayed(others_db: np.ndarray, scatter: float) -> float:
    """Return how surely 1X stayed where it was on the channels beside those that tell of a rise; 0 without any."""
    if not others_db.size:
        return 0.0
    return 1.0 / (1.0 + float(np.exp(np.clip((others_db.mean() - 2 * scatter) / 2, -40, 40))))


def _causes_of_1x(
    now: Observation,
    baseline: Observation,
    change: dict[float, np.ndarray],
    share: float,
    usable: list[float],
    stayed: float,
) -> dict[str, float]:
    """Return how a risen 1X is shared between its causes; the rest is none of them.

    Unbalance, a bow and a coupling that pulls all turn with the shaft: at one speed their 1X is the same force.
    Unbalance is the most frequent by far and gets most. An axial 1X that rose more than the radial one speaks for a
    bent shaft; 2X and 3X that rose more than 1X for misalignment, although a linear coupling makes 1X only; risen noise
    beside 1X, or one radial direction that rose alone, for a resonance that came near. Where some channels stayed as
    they were, a force must act elsewhere than the old one and cancel there, which few do.
    """
    radial, axial = now.radial_channels(), now.axial_channels()
    first = change[1.0]
    tilt = 0.0
    if axial and len(axial) < now.channel_count:
        tilt = float(np.median(first[axial]) - np.median(first[radial]))
    noise = floor_rise_near(now, baseline, 1.0)
    spread = float(np.ptp(first[radial])) if len(radial) > 1 else 0.0
    beyond = max((float(np.median((change[order] - first)[radial])) for order in usable), default=-np.inf)
    coupled = odds_of_rise(beyond, repeatability=repeatability_db(now, baseline), typical_db=8.0, spread_db=6.0)
    coupled = min(0.5 + 0.5 * coupled, 10.0)
    # Harmonics of the one direction in which 1X rose are those of a contact that stands still, judged on their own.
    contact = stayed * _one_direction(now, change, usable, max(float(np.median(first[radial])), 0.0))
    coupled += (0.5 - coupled) * contact
    force = 1 - (1 - _FORCES_THAT_CANCEL) * stayed
    weight = {
        "unbalance": force * 0.80 * min(1.0, 0.5 + share),
        "misalignment": force * 0.30 * coupled,
        "bent_shaft": force * 0.15 * float(np.exp(np.clip(tilt / 5, -2.0, 3.0))),
        "resonance": 0.06 * float(np.exp(np.clip((noise - 3) / 3, -2.0, 3.0) + np.clip((spread - 15) / 10, -1.0, 1.5))),
    }
    total = sum(weight.values()) + 0.10
    return {fault: value / total for fault, value in weight.items()}


def _causes_of_harmonics(
    now: Observation, change: dict[float, np.ndarray], usable: list[float], one: float, motion: NewMotion | None
) -> dict[str, float]:
    """Return how risen 2X and 3X are shared between their causes; the rest is none of them.

    A misaligned coupling bends the shaft as it turns, which shows in both radial directions. A contact that stands
    still in space, a stop that is touched or a joint that opens, acts in its own direction: then the three share. A
    joint opens upwards as a rule, a stop is touched anywhere. Fractions of 1X, which tell a rub or looseness, have
    rules of their own. A misalignment that matters makes more than every joint's and bearing's own nonlinearity does.
    """
    size = _size_of_harmonics(now, usable)
    telling = size / (size + _TELLING_HARMONICS)
    if motion is None:
        part = _one_direction(now, change, usable, max(one, 0.0))
        return {"misalignment": (1 - 0.6 * part) * telling, "rub": 0.3 * part, "looseness": 0.3 * part}
    rub, loose = (0.25, 0.45) if motion.vertical else (0.55, 0.15)
    part = motion.contact
    return {"misalignment": (1 - 0.7 * part) * telling, "rub": rub * part, "looseness": loose * part}


def _size_of_harmonics(now: Observation, usable: list[float]) -> float:
    """Return the largest 2X or 3X over 1X of any channel, in velocity."""
    found = [0.0]
    for channel in range(now.channel_count):
        base = now.line(1.0, channel=channel)
        for order in usable:
            line = now.line(order, channel=channel)
            if now.is_significant(line):
                ratio = line.amplitude / max(base.amplitude, base.noise_floor, 1e-300)
                factors = [float(now.velocity_factor(channel, one.frequency_hz)) for one in (line, base)]
                found.append(ratio * factors[0] / factors[1])
    return max(found)


def _one_direction(now: Observation, change: dict[float, np.ndarray], usable: list[float], dragged: float) -> float:
    """Return how surely 2X and 3X rose in one radial direction only, 0 to 1; 0.25 where directions are not known."""
    sides = [
        [index for index, channel in enumerate(now.recording.channels) if channel.direction == direction]
        for direction in ("horizontal", "vertical")
    ]
    if not usable or not all(sides):
        return 0.25
    order = max(usable, key=lambda one: float(change[one].max()))
    rises = [max(float(np.median(change[order][side])), dragged) for side in sides]
    # The directions of a sound support differ by up to a factor of four (12 dB): less means nothing.
    return 1.0 / (1.0 + float(np.exp(-(abs(rises[0] - rises[1]) - 12.0) / 3.0)))


def _own_harmonics(now: Observation) -> list[float]:
    """Return which of 2X and 3X no bearing, other shaft or twice the line frequency owns."""
    return [order for order in (2.0, 3.0) if not owned_by_machine(now, order) and not _on_twice_line(now, order)]


def _risen_harmonics(
    now: Observation, change: dict[float, np.ndarray], usable: list[float], dragged: float, scatter: float
) -> float:
    """Return the largest rise of 2X and 3X beyond what a risen 1X drags along and what choosing the largest brings.

    1X drags them along by as much as it rose on that channel, and at least by as much as in the median.
    """
    if not usable:
        return -np.inf
    beside = np.maximum(change[1.0], dragged)
    largest = max(float((change[order] - beside).max()) for order in usable)
    return largest - 0.7 * scatter * float(np.sqrt(2 * np.log(len(usable) * now.channel_count + 1e-9)))


def _on_twice_line(now: Observation, order: float) -> bool:
    line_frequency = now.recording.nameplate.line_frequency_hz
    if line_frequency is None:
        return False
    return abs(2 * line_frequency - order * now.speed_hz) < 3 * now.spectrum.resolution_hz
