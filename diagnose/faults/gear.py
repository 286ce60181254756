"""Gear faults: mesh lines and their sidebands at the speed of the faulty shaft.

Amplitude or phase modulation at the speed of one shaft puts sidebands round the mesh lines at that shaft's spacing;
their spacing names the gear (R. B. Randall, "A new method of modeling gear faults", J. Mech. Des. 104 (1982) 259). One
pair is eccentricity; many pairs are a local defect; risen mesh lines without sidebands are wear.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...datasets.recording import Channel, GearPair
from ..compare import comparable, odds_of_rise, order_change_db, path_changed, risen_db
from ..observe import Observation
from ..result import Finding, Line
from ..signal.sidebands import SidebandFamily, find_sidebands

_PAIRS = 6
_MESH_HARMONICS = (1, 2, 3)
_REPEATABILITY_DB = 4.0
_PRIOR = 0.15
_OTHER_SUPPORT = 0.2  # share of looseness in risen mesh lines where directions cannot be compared
_ANOTHER_PATH_DB = 6.0  # as for the noise floor in ``compare.path_changed``
_LEAST_SIDEBAND = 1e-4  # of the mesh line, 80 dB below it: no gear is so round that less means anything (a judgement)
_TELLING_SIDEBAND = 2.5e-3  # of the mesh line: smaller ones tell of a fault less than half (a judgement)
_NOT_OF_THE_SERIES = 2.0  # times the first pair: what a shaft modulates once a turn has its strongest pair first
_RISEN_ALIKE = 0.35  # share of tooth and run-out faults where the mesh rose as much as its sidebands
_SHARE_OF_WHIRL = 0.5  # of modulation once a turn, where the shaft whirls more than before
_RIVALS = {
    # Once a turn the centre distance changes, whether the gear runs out or its shaft whirls.
    "gear_eccentricity": ("gear_tooth_fault", "unbalance"),
    "gear_tooth_fault": ("gear_eccentricity",),
    "gear_wear": ("looseness",),
    "looseness": ("gear_wear",),
    "unbalance": ("gear_eccentricity",),
}
_CHECKS = {
    "gear_eccentricity": "Measure run-out of the gear; check bore, key and shaft. Unbalance of the shaft modulates the "
    "mesh once a turn too, but grows with the speed squared.",
    "gear_tooth_fault": "Inspect the teeth of this gear; take a synchronous average with a tacho on this shaft.",
    "unbalance": "Measure run-out of the gear; record two other speeds: the force of an unbalance grows with the speed "
    "squared, run-out does not.",
    "gear_wear": "Inspect tooth flanks and oil debris; compare with records at the same load. Wear lifts the mesh "
    "lines of all directions alike, a loose joint does not.",
    "looseness": "Check bolts and bearing fits; watch the mesh lines while a bolt is tightened. Wear lifts them in all "
    "directions alike.",
}


@dataclass(frozen=True)
class Family:
    """The sidebands of one mesh harmonic at one shaft's spacing, on one channel."""

    mesh: int
    wheel: str
    ratio: float
    channel: int
    found: SidebandFamily


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return what mesh lines and sidebands speak for, gear by gear."""
    if now.speed is None or not now.turning:
        return []
    findings: list[Finding] = []
    for gear in now.recording.nameplate.gears:
        reference = baseline if comparable(now, baseline) else None
        findings += _judge_pair(now, reference, gear)
    return findings


def shafts(gear: GearPair) -> list[tuple[str, float]]:
    """Return name and speed ratio of both shafts; of one only when the other's teeth are unknown."""
    found = [(f"{gear.driver_teeth}-tooth gear", gear.driver_ratio)]
    if gear.driven_ratio is not None and abs(gear.driven_ratio / gear.driver_ratio - 1.0) > 1e-6:
        found.append((f"{gear.driven_teeth}-tooth gear", gear.driven_ratio))
    return found


def families(now: Observation, gear: GearPair) -> list[Family]:
    """Return every sideband family of a gear pair."""
    return [
        Family(
            mesh,
            name,
            ratio,
            channel,
            find_sidebands(
                now.spectrum,
                channel=channel,
                carrier_hz=mesh * gear.mesh_order * now.speed_hz,
                modulator_hz=ratio * now.speed_hz,
                pairs=_PAIRS,
                significant_ratio=now.significant_ratio,
            ),
        )
        for mesh in _MESH_HARMONICS
        if mesh * gear.mesh_order * now.speed_hz < 0.9 * now.spectrum.frequency_hz[-1]
        for channel in range(now.channel_count)
        for name, ratio in shafts(gear)
    ]


def attributions(now: Observation) -> list[str]:
    """Return, for each shaft of each pair, one sentence on the sidebands that its gear makes, if any is significant."""
    if now.speed is None or not now.turning:
        return []
    found = []
    for gear in now.recording.nameplate.gears:
        for name, ratio in shafts(gear):
            mine = [one for one in families(now, gear) if one.wheel == name and one.found.modulation_index > 0]
            if not mine:
                continue
            clearest = max(mine, key=lambda one: max(s.power_ratio for s in one.found.sidebands if abs(s.number) == 1))
            sides = [side for side in clearest.found.sidebands if abs(side.number) == 1]
            ratios = " and ".join(f"{np.sqrt(side.power_ratio):.0f}" for side in sides)
            channel = now.recording.channels[clearest.channel].name
            found.append(
                f"Sidebands at {ratio * now.speed_hz:.2f} Hz round {clearest.found.carrier.frequency_hz:.1f} Hz "
                f"(tooth mesh x {clearest.mesh}) belong to the {name}: {ratios} times the noise on {channel}, "
                f"modulation index {clearest.found.modulation_index:.2f}."
            )
    return found


def _judge_pair(now: Observation, baseline: Observation | None, gear: GearPair) -> list[Finding]:
    current = families(now, gear)
    if not any(one.found.carrier.power_ratio > now.significant_ratio for one in current):
        return []
    if baseline is not None:
        return _judge_growth(now, baseline, gear, current)
    findings = []
    for name, ratio in shafts(gear):
        mine = [one for one in current if one.wheel == name]
        lines = _lines(now, mine)
        if not lines:
            continue
        # The typical index over mesh harmonics and channels: a single one is ruled by the transfer path.
        carried = [one for one in mine if one.found.carrier.power_ratio > now.significant_ratio]
        index = float(np.median([one.found.modulation_index for one in carried])) if carried else 0.0
        pairs = float(np.median([_significant_pairs(now, one) for one in mine]))
        summary = (
            f"Sidebands at {ratio * now.speed_hz:.2f} Hz, the speed of the {name}, round the mesh at "
            f"{gear.mesh_order * now.speed_hz:.1f} Hz: modulation index {index:.2f} in the median, {pairs:.0f} pairs. "
            "Without a baseline this may be normal for this gear."
        )
        strength = index / (index + 0.5)
        many = min(max(pairs - 1.0, 0.0) / 5.0, 1.0)
        for fault, probability in (
            ("gear_eccentricity", 0.5 * strength * (1 - 0.5 * many)),
            ("gear_tooth_fault", 0.5 * strength * 0.6 * many),
        ):
            findings.append(Finding(fault, probability, summary, lines, _CHECKS[fault], _RIVALS[fault]))
    return _best_of_each(findings)


def _significant_pairs(now: Observation, family: Family) -> int:
    numbers = {abs(s.number) for s in family.found.sidebands if s.power_ratio > now.significant_ratio}
    return len(numbers)


def _lines(now: Observation, chosen: list[Family], limit: int = 14) -> tuple[Line, ...]:
    """Return the most prominent sidebands as lines, with their carriers."""
    found: list[Line] = []
    for family in chosen:
        channel = now.recording.channels[family.channel]
        mesh = "mesh" if family.mesh == 1 else f"{family.mesh} x mesh"
        for side in (family.found.carrier, *family.found.sidebands):
            if side.power_ratio <= now.significant_ratio:
                continue
            sign = "-" if side.number < 0 else "+"
            name = mesh if side.number == 0 else f"{mesh} {sign} {abs(side.number)} x {family.wheel}"
            order = side.frequency_hz / now.speed_hz
            found.append(
                Line(
                    name,
                    channel.name,
                    side.frequency_hz,
                    order,
                    side.amplitude,
                    side.noise_floor,
                    channel.unit,
                )
            )
    unique = {(line.name, line.channel): line for line in found}
    return tuple(sorted(unique.values(), key=lambda line: -line.signal_to_noise)[:limit])


@dataclass(frozen=True)
class Growth:
    """Growth in dB of a family's mesh line, and of its first and wider sidebands beyond that of the mesh line.

    A mesh that got louder takes its sidebands along; only what they grow beyond it is modulation. ``size`` is the
    larger of first and wider sidebands over the mesh line.
    """

    family: Family
    mesh: float
    first: float
    wide: float
    size: float


def _growth(now: Observation, family: Family, earlier: Family, mesh_before: float, mesh_now: float) -> Growth:
    """Return the growth of a family, whose mesh line was and is so high in the strongest direction at its place."""
    least = _LEAST_SIDEBAND * mesh_before
    old = {side.number: side for side in (earlier.found.carrier, *earlier.found.sidebands)}

    def rises(numbers: range) -> list[float]:
        found = []
        for side in (family.found.carrier, *family.found.sidebands):
            was = old.get(side.number)
            if abs(side.number) not in numbers or was is None:
                continue
            high, low = max(side.amplitude, side.noise_floor, least), max(was.amplitude, was.noise_floor, least)
            rise = 20 * float(np.log10(max(high, 1e-300) / max(low, 1e-300)))
            # A risen floor (a bearing's impacts, cavitation) is no risen sideband.
            found.append(rise if side.power_ratio > now.significant_ratio else min(rise, 0.0))
        return found

    mesh, pair, wide = rises(range(1)), rises(range(1, 2)), rises(range(2, _PAIRS + 1))
    louder = max(mesh[0], 0.0) if mesh else 0.0
    # Modulation makes both sidebands; one alone is a line of something else that happens to lie there.
    first = min(float(np.mean(pair)), min(pair) + _REPEATABILITY_DB) if pair else 0.0
    # A local defect lifts some sidebands more than others; the lift that scatter alone gives them is taken off.
    several = float(np.percentile(wide, 75)) - 0.67 * _REPEATABILITY_DB if len(wide) >= 3 else 0.0
    one, more = _heights(family)
    # Where the following ones are much higher than the first, another shaft, a bearing or twice a turn made them.
    if more > _NOT_OF_THE_SERIES * one:
        several, more = min(several, first), one
    size = max(one, more) / max(mesh_now, 1e-300)
    return Growth(family, mesh[0] if mesh else 0.0, first - louder, several - louder, size)


def _heights(family: Family) -> tuple[float, float]:
    """Return the mean of the first pair, and what the stronger ones of the wider sidebands reach."""
    pair = [side.amplitude for side in family.found.sidebands if abs(side.number) == 1]
    wide = [side.amplitude for side in family.found.sidebands if abs(side.number) > 1]
    return float(np.mean(pair)) if pair else 0.0, float(np.percentile(wide, 75)) if wide else 0.0


def _mesh_amplitudes(at: Observation, found: list[Family]) -> dict[tuple[int, int], float]:
    """Return, by mesh harmonic and channel, the mesh line in the strongest direction at the place of the channel.

    Sidebands are measured by it, lest a direction across the tooth force, which shows next to no mesh, makes much of
    nothing.
    """
    channels = at.recording.channels
    return {
        (one.mesh, one.channel): max(
            other.found.carrier.amplitude
            for other in found
            if other.mesh == one.mesh
            and (other.channel == one.channel or _same_place(channels[other.channel], channels[one.channel]))
        )
        for one in found
    }


def _same_place(one: Channel, other: Channel) -> bool:
    return one.location is not None and (one.location, one.quantity) == (other.location, other.quantity)


def _local(now: Observation, baseline: Observation | None, current: list[Family], earlier: list[Family]) -> float:
    """Return how surely one shaft's modulation is a short event, 0 to 1, from the decay of its new sidebands.

    Sidebands are the Fourier series of the modulation over one turn. Run-out is one sine: even a phase modulation of
    2 rad keeps pairs 2 to 6 at least 11 dB below the first (Bessel functions J1 to J6). A pulse over one to three of
    20 teeth has a sinc for a series: -1 to -7 dB. Sidebands that noise hides may have any height up to visible.
    """
    before = {(one.mesh, one.channel): one for one in earlier}
    told = [_decay(now, one, before.get((one.mesh, one.channel))) for one in current]
    weight = sum(one[1] for one in told)
    return sum(one[0] * one[1] for one in told) / weight if weight > 0 else 0.5


def _decay(now: Observation, family: Family, earlier: Family | None) -> tuple[float, float]:
    """Return how surely one family's new sidebands are those of a short event, and how much that weighs."""
    old = {} if earlier is None else {side.number: side.amplitude for side in earlier.found.sidebands}
    visible = {side.number for side in family.found.sidebands if side.power_ratio > now.significant_ratio}
    seen, hidden, lines = np.zeros(2), np.zeros(2), np.zeros(2)
    for side in family.found.sidebands:
        kind = 0 if abs(side.number) == 1 else 1
        lines[kind] += 1
        # A series goes on from line to line; one that stands alone is a line of something else.
        foreign = kind == 1 and not {side.number - 1, side.number + 1} & visible
        if side.number in visible and not foreign:
            seen[kind] += max(side.amplitude**2 - old.get(side.number, side.noise_floor) ** 2, 0.0)
        else:
            hidden[kind] += side.noise_floor**2 * now.significant_ratio
    if not family.found.sidebands or not lines.all() or not seen.any():
        return 0.5, 0.0
    (first, wide), (first_hidden, wide_hidden) = seen / lines, hidden / lines
    pairs = ((first + first_hidden, wide), (first, wide + wide_hidden))
    decay = np.array([10 * np.log10((high + 1e-300) / (low + 1e-300)) for low, high in pairs])
    local = float(np.mean(1.0 / (1.0 + np.exp(-np.clip((decay + 9.0) / 1.5, -40, 40)))))
    floor = float(np.mean([side.noise_floor for side in family.found.sidebands]))
    return local, float(np.sqrt(seen.sum())) / max(floor, 1e-300)


def _judge_growth(now: Observation, baseline: Observation, gear: GearPair, current: list[Family]) -> list[Finding]:
    """Judge, for each shaft, the family that grew most; the price of choosing it is taken off its growth."""
    before = families(baseline, gear)
    earlier = {(one.mesh, one.wheel, one.channel): one for one in before}
    was, now_is = _mesh_amplitudes(baseline, before), _mesh_amplitudes(now, current)
    findings: list[Finding] = []
    for name, ratio in shafts(gear):
        grown = [
            _growth(now, one, earlier[key], was[one.mesh, one.channel], now_is[one.mesh, one.channel])
            for one in current
            if one.wheel == name and (key := (one.mesh, one.wheel, one.channel)) in earlier
        ]
        if not grown:
            continue
        best = max(grown, key=lambda one: max(one.first, one.wide) + 0.5 * one.mesh)
        loudest = max(grown, key=lambda one: one.mesh)
        # Largest of several families: each figure joins a few lines, so it scatters about half as much as one line.
        price = 0.35 * _REPEATABILITY_DB * float(np.sqrt(2 * np.log(len(grown))))
        first, wide, mesh = (_posterior(value - price) for value in (best.first, best.wide, loudest.mesh))
        mine = [one for one in current if one.wheel == name]
        local = _local(now, baseline, mine, [one for one in before if one.wheel == name])
        loose = _OTHER_SUPPORT if path_changed(now, baseline) else _other_support(grown)
        summary = (
            f"Against the baseline, on {now.recording.channels[best.family.channel].name} round "
            f"{best.family.found.carrier.frequency_hz:.1f} Hz (mesh x {best.family.mesh}): "
            f"mesh line {best.mesh:+.0f} dB (largest of all {loudest.mesh:+.0f} dB), beyond it "
            f"first sidebands at {ratio * now.speed_hz:.2f} Hz ({name}) {best.first:+.0f} dB, "
            f"sidebands 2-{_PAIRS} {best.wide:+.0f} dB."
        )
        # Sidebands that grew only as much as the mesh mean a stronger mesh: wear as a rule, a bad tooth now and then.
        alike = max(_posterior(max(one.first, one.wide) + max(one.mesh, 0.0) - price) for one in grown)
        index = max(first, wide)
        telling = best.size / (best.size + _TELLING_SIDEBAND)
        modulated = 0.8 * (index + _RISEN_ALIKE * max(alike - index, 0.0)) * telling
        whirl = _SHARE_OF_WHIRL * _whirl(now, baseline, ratio)
        worn = 0.8 * mesh * (1 - 0.7 * index)
        findings += [
            _finding(now, baseline, best, "gear_tooth_fault", modulated * local, summary),
            _finding(now, baseline, best, "gear_eccentricity", modulated * (1 - local) * (1 - whirl), summary),
            _finding(now, baseline, best, "unbalance", modulated * (1 - local) * whirl, summary),
            _finding(now, baseline, loudest, "gear_wear", worn * (1 - loose), summary),
            _finding(now, baseline, loudest, "looseness", worn * loose, summary),
        ]
    return _best_of_each(findings)


def _whirl(now: Observation, baseline: Observation, ratio: float) -> float:
    """Return how surely the shaft of a gear whirls more than before, 0 to 1, from its 1X sideways."""
    sideways = [i for i in now.radial_channels() if now.recording.channels[i].direction != "torsion"]
    if not sideways:
        return 0.0
    rise, _ = risen_db(order_change_db(now, baseline, ratio)[sideways], _REPEATABILITY_DB)
    return _posterior(rise)


def _finding(
    now: Observation,
    baseline: Observation,
    shown: Growth,
    fault: str,
    probability: float,
    summary: str,
) -> Finding:
    lines = _with_baseline(_lines(now, [shown.family]), baseline)
    return Finding(fault, probability, summary, lines, _CHECKS[fault], _RIVALS[fault])


def _other_support(grown: list[Growth]) -> float:
    """Return the share of looseness in risen mesh lines, 0 to 0.6, from how differently the channels rose.

    Worn teeth change the force in the mesh, and through an unchanged structure every channel follows by the same ratio.
    A joint that opened changes the structure: the mesh then rises in one direction and not, or less, in the other. So
    do a sensor that was moved and a resonance that came near, so that looseness never gets all.
    """
    for channel in {one.family.channel for one in grown}:
        here = [one.mesh for one in grown if one.family.channel == channel]
        if min(here) < -_ANOTHER_PATH_DB and max(here) > _ANOTHER_PATH_DB:
            # One harmonic much stronger, another much weaker on one sensor: re-assembled gearboxes do that.
            return _OTHER_SUPPORT
    spreads = []
    for mesh in _MESH_HARMONICS:
        rises = [one.mesh for one in grown if one.family.mesh == mesh]
        if len(rises) > 1 and max(rises) > 0:
            spreads.append(max(rises) - min(rises))
    if not spreads:
        return _OTHER_SUPPORT
    return 0.6 / (1.0 + float(np.exp(-(float(np.median(spreads)) - 2.5 * _REPEATABILITY_DB) / 2.0)))


def _posterior(growth_db: float) -> float:
    odds = (
        odds_of_rise(growth_db, repeatability=_REPEATABILITY_DB, typical_db=12.0, spread_db=6.0) * _PRIOR / (1 - _PRIOR)
    )
    return odds / (1 + odds)


def _with_baseline(lines: tuple[Line, ...], baseline: Observation) -> tuple[Line, ...]:
    channels = {channel.name: index for index, channel in enumerate(baseline.recording.channels)}
    return tuple(
        replace(
            line,
            baseline_amplitude=baseline.line(line.order, channel=channels[line.channel], name=line.name).amplitude,
        )
        for line in lines
        if line.channel in channels
    )


def _best_of_each(findings: list[Finding]) -> list[Finding]:
    """Return the likeliest finding of each fault: both gears of a pair share the mesh."""
    best: dict[str, Finding] = {}
    for finding in findings:
        if finding.fault not in best or finding.probability > best[finding.fault].probability:
            best[finding.fault] = finding
    return list(best.values())
