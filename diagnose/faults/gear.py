"""Gear faults: mesh lines and their sidebands at the speed of the faulty shaft.

Amplitude or phase modulation at the speed of one shaft puts sidebands round the mesh lines at that shaft's spacing;
their spacing names the gear (R. B. Randall, "A new method of modeling gear faults", J. Mech. Des. 104 (1982) 259). One
pair is eccentricity; many pairs are a local defect; risen mesh lines without sidebands are wear.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...datasets.recording import GearPair
from ..compare import comparable, odds_of_rise, order_change_db, path_changed, risen_db
from ..observe import Observation
from ..result import Finding, Line
from ..sideband_growth import (
    MESH_HARMONICS,
    PAIRS,
    REPEATABILITY_DB,
    Family,
    Growth,
    families,
    growth,
    local_event,
    mesh_amplitudes,
    shafts,
)

_PRIOR = 0.15
_OTHER_SUPPORT = 0.2  # share of looseness in risen mesh lines where directions cannot be compared
_ANOTHER_PATH_DB = 6.0  # as for the noise floor in ``compare.path_changed``
_TELLING_SIDEBAND = 2.5e-3  # of the mesh line: smaller ones tell of a fault less than half (a judgement)
_RISEN_ALIKE = 0.35  # share of tooth and run-out faults where the mesh rose as much as its sidebands
_TELLING_HARMONIC = 0.02  # of the highest mesh harmonic: half as telling (a judgement)
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


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return what mesh lines and sidebands speak for, gear by gear."""
    if now.speed is None or not now.turning:
        return []
    findings: list[Finding] = []
    for gear in now.recording.nameplate.gears:
        reference = baseline if comparable(now, baseline) else None
        findings += _judge_pair(now, reference, gear)
    return findings


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


def _judge_growth(now: Observation, baseline: Observation, gear: GearPair, current: list[Family]) -> list[Finding]:
    """Judge, for each shaft, the family that grew most; the price of choosing it is taken off its growth."""
    before = families(baseline, gear)
    earlier = {(one.mesh, one.wheel, one.channel): one for one in before}
    was, now_is = mesh_amplitudes(baseline, before), mesh_amplitudes(now, current)
    findings: list[Finding] = []
    for name, ratio in shafts(gear):
        grown = [
            growth(now, one, earlier[key], was[one.mesh, one.channel], now_is[one.mesh, one.channel])
            for one in current
            if one.wheel == name and (key := (one.mesh, one.wheel, one.channel)) in earlier
        ]
        if not grown:
            continue
        best = max(grown, key=lambda one: max(one.first, one.wide) + 0.5 * one.mesh)
        loudest = max(grown, key=lambda one: _posterior(one.mesh) * _mesh_telling(one, now_is))
        # Largest of several families: each figure joins a few lines, so it scatters about half as much as one line.
        price = 0.35 * REPEATABILITY_DB * float(np.sqrt(2 * np.log(len(grown))))
        first, wide, mesh = (_posterior(value - price) for value in (best.first, best.wide, loudest.mesh))
        mesh *= _mesh_telling(loudest, now_is)
        mine = [one for one in current if one.wheel == name]
        local = local_event(now, baseline, mine, [one for one in before if one.wheel == name])
        loose = _OTHER_SUPPORT if path_changed(now, baseline) else _other_support(grown)
        summary = (
            f"Against the baseline, on {now.recording.channels[best.family.channel].name} round "
            f"{best.family.found.carrier.frequency_hz:.1f} Hz (mesh x {best.family.mesh}): "
            f"mesh line {best.mesh:+.0f} dB (largest of all {loudest.mesh:+.0f} dB), beyond it "
            f"first sidebands at {ratio * now.speed_hz:.2f} Hz ({name}) {best.first:+.0f} dB, "
            f"sidebands 2-{PAIRS} {best.wide:+.0f} dB."
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


def _mesh_telling(one: Growth, mesh_now: dict[tuple[int, int], float]) -> float:
    """Return how much the rise of a mesh harmonic tells, 0 to 1, from its size beside the highest on its channel."""
    highest = max(height for (_, channel), height in mesh_now.items() if channel == one.family.channel)
    share = one.family.found.carrier.amplitude / max(highest, 1e-300)
    return share / (share + _TELLING_HARMONIC)


def _whirl(now: Observation, baseline: Observation, ratio: float) -> float:
    """Return how surely the shaft of a gear whirls more than before, 0 to 1, from its 1X sideways."""
    sideways = [i for i in now.radial_channels() if now.recording.channels[i].direction != "torsion"]
    if not sideways:
        return 0.0
    rise, _ = risen_db(order_change_db(now, baseline, ratio)[sideways], REPEATABILITY_DB)
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
    for mesh in MESH_HARMONICS:
        rises = [one.mesh for one in grown if one.family.mesh == mesh]
        if len(rises) > 1 and max(rises) > 0:
            spreads.append(max(rises) - min(rises))
    if not spreads:
        return _OTHER_SUPPORT
    return 0.6 / (1.0 + float(np.exp(-(float(np.median(spreads)) - 2.5 * REPEATABILITY_DB) / 2.0)))


def _posterior(growth_db: float) -> float:
    odds = (
        odds_of_rise(growth_db, repeatability=REPEATABILITY_DB, typical_db=12.0, spread_db=6.0) * _PRIOR / (1 - _PRIOR)
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
