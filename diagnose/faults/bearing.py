"""Rolling-bearing defects: envelope lines at the defect orders, and how deep they modulate the band.

Significance is not enough: a healthy loaded bearing also shows its ball-pass order faintly (variable compliance). The
depth decides: the root sum of squares of the modulation depths of the first three harmonics, plus sidebands, is about
the share of the band's energy that comes as impacts in that rhythm. Tooth-mesh lines that a sound bearing's changing
stiffness modulates are taken off: their sidebands stand beside the mesh, those of impacts do not
(J. Antoni and R. B. Randall, "Differential diagnosis of gear and bearing faults", J. Vib. Acoust. 124 (2002) 165).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...datasets.recording import MountedBearing
from ..bearing_rhythm import (
    EVEN_DEPTH,
    STEEPNESS,
    DefectRhythm,
    RhythmEvidence,
    alone,
    defect_odds,
    envelope_line,
    of_another,
    on_shaft,
    shaft_ratios,
)
from ..compare import comparable, order_change_db, path_changed
from ..heard_envelopes import speaking
from ..impact_share import modulated_mesh, share_of_impacts
from ..observe import Observation
from ..result import Finding, Line
from ..signal.envelope import EnvelopeSpectrum
from ..signal.spectrum import peak_near

_SLIP = 0.02  # rolling elements slip up to 2 % against the kinematic order
_CAGE_LAG = 0.03  # a cage under light load lags more at times; what it passes on the outer race comes that much later
_EVEN_EXCESS = 0.2  # the same against a baseline, whose own depth is taken off
_LEAST_PROBABILITY = 0.02
_SHARED_WITH_SHAFT = 0.7  # jaws of a coupling, blades or a shaft out of round make one multiple alone too
_LOUDER = 2.0  # times the rhythm's own lines: then another, unknown rhythm rules the envelope
_SECOND_DEFECT = 0.3  # a second defect at once is rarer, and a strong first one stirs everything

_CHECKS = {
    "bearing_outer_race": "Listen at the housing, check grease and race fit; compare with a record after greasing.",
    "bearing_inner_race": "Check clearance and inner-race fit; plan the replacement if the line grows.",
    "bearing_ball": "Inspect rolling elements; the rhythm varies from record to record, so repeat the measurement.",
    "bearing_cage": "Check lubrication and cage wear; repeat the measurement.",
}


def rhythms(bearing: MountedBearing) -> list[DefectRhythm]:
    """Return the rhythms of one bearing, in orders of the reference shaft."""
    orders = bearing.geometry.defect_orders()
    shaft = bearing.shaft_ratio
    return [
        DefectRhythm("bearing_outer_race", "BPFO", orders.outer_race * shaft, None),
        DefectRhythm("bearing_inner_race", "BPFI", orders.inner_race * shaft, shaft),
        DefectRhythm("bearing_ball", "2BSF", 2 * orders.ball_spin * shaft, orders.cage * shaft),
        DefectRhythm("bearing_cage", "FTF", orders.cage * shaft, None),
    ]


def judge(now: Observation, baseline: Observation | None) -> list[Finding]:
    """Return the bearing defects that the envelopes speak for.

    The likeliest rhythm of all bearings is taken first; the others must live on what it does not explain.
    """
    if now.speed is None or not now.turning:
        return []
    heard = speaking(now)
    waiting = [(bearing, rhythm) for bearing in now.recording.nameplate.bearings for rhythm in rhythms(bearing)]
    taken: list[RhythmEvidence] = []
    findings: list[Finding] = []
    while waiting:
        found = [(one, pair) for pair in waiting if (one := confirmed(now, pair[1], taken, heard)) is not None]
        if not found:
            break
        evidence, pair = max(found, key=lambda one: one[0].odds)
        if evidence.odds < 0.02:
            break
        crowd = _SECOND_DEFECT if any(other.odds > 1 for other in taken) or _overruled(now, evidence) else 1.0
        taken.append(evidence)
        findings.append(_finding(now, baseline, pair[0], evidence, crowd))
        waiting = [other for _, other in found if other is not pair]
    shared = [one for bearing in now.recording.nameplate.bearings for one in _ball_or_cage(findings, place_of(bearing))]
    return [one for one in shared if one.probability >= _LEAST_PROBABILITY]


def place_of(bearing: MountedBearing) -> str:
    """Return what the report calls a bearing."""
    return bearing.location or bearing.geometry.designation or "the bearing"


def strongest(
    now: Observation,
    rhythm: DefectRhythm,
    taken: list[RhythmEvidence],
    envelopes: Sequence[EnvelopeSpectrum] | None = None,
) -> RhythmEvidence | None:
    """Return the envelope, of those given or of all, in which a rhythm speaks loudest; None where it is nowhere so."""
    best: RhythmEvidence | None = None
    for envelope in now.envelopes if envelopes is None else envelopes:
        # In most envelopes nothing stands out at all.
        if envelope.spectrum.highest_ratio <= now.significant_ratio:
            continue
        for frequency in _candidates(now, envelope, rhythm):
            evidence = _measure(now, envelope, rhythm, frequency, taken)
            if evidence is not None and (best is None or evidence.odds > best.odds):
                best = evidence
    return best


def confirmed(
    now: Observation, rhythm: DefectRhythm, taken: list[RhythmEvidence], envelopes: Sequence[EnvelopeSpectrum]
) -> RhythmEvidence | None:
    """Return what the loudest envelope says of a rhythm; with gears, what it says of impacts in that rhythm."""
    gears = bool(now.recording.nameplate.gears)
    best: RhythmEvidence | None = None
    for envelope in envelopes:
        for frequency in _candidates(now, envelope, rhythm, lag=_CAGE_LAG if rhythm.label == "BPFO" else _SLIP):
            evidence = _measure(now, envelope, rhythm, frequency, taken, strict=True)
            if evidence is None:
                continue

            def depth_of(one: EnvelopeSpectrum, at: float = frequency) -> float:
                there = _measure(now, one, rhythm, at, taken, strict=True)
                return 0.0 if there is None else there.depth

            if gears:
                evidence = replace(evidence, depth=share_of_impacts(now, envelope, depth_of))
            if best is None or evidence.odds > best.odds:
                best = evidence
    return best


def _candidates(
    now: Observation, envelope: EnvelopeSpectrum, rhythm: DefectRhythm, *, lag: float = _SLIP
) -> list[float]:
    """Return the significant lines within slip of the rhythm, and half of those at its second harmonic."""
    found: list[float] = []
    spectrum = envelope.spectrum
    ratio = spectrum.power_ratio[0]
    resolution = spectrum.resolution_hz
    # A race strikes at its own order; a ball that touches one race at a time and a cage may show twice the order only.
    for harmonic in (1,) if rhythm.label in ("BPFO", "BPFI") else (1, 2):
        expected = harmonic * rhythm.order * now.speed_hz
        low = max(int((expected * (1 - lag)) / resolution), 2)
        high = min(int(np.ceil(expected * (1 + _SLIP) / resolution)) + 1, ratio.size - 2)
        # One comparison says where nothing does.
        if ratio[low : high + 1].max(initial=0.0) <= now.significant_ratio:
            continue
        bins = np.arange(low, high + 1)
        bins = bins[(ratio[bins] >= ratio[bins - 1]) & (ratio[bins] >= ratio[bins + 1])]
        bins = bins[ratio[bins] > now.significant_ratio]
        for index in bins[np.argsort(ratio[bins])[::-1][:2]]:
            found.append(peak_near(spectrum, 0, index * resolution, tolerance_hz=0.6 * resolution)[0] / harmonic)
    return found


def _measure(
    now: Observation,
    envelope: EnvelopeSpectrum,
    rhythm: DefectRhythm,
    frequency_hz: float,
    taken: list[RhythmEvidence],
    *,
    strict: bool = False,
) -> RhythmEvidence | None:
    """Return what one envelope says; ``strict`` lets a race's harmonics and sidebands count as far as its own line."""
    race = strict and rhythm.label in ("BPFO", "BPFI")
    lines: list[Line] = []
    power = 0.0
    harmonics = 0
    significant = shared = False
    highest = np.inf
    for harmonic in (1, 2, 3):
        line = envelope_line(now, envelope, harmonic * frequency_hz, f"{harmonic} x {rhythm.label}", rhythm, harmonic)
        foreign = line is None or of_another(now, envelope, line.frequency_hz, taken)
        if line is not None and not foreign and on_shaft(now, envelope, line.frequency_hz):
            shared |= race and harmonic == 1 and alone(now, envelope, line)
            foreign = not (shared and harmonic == 1)
        if foreign or line is None:
            if race and harmonic == 1:
                return None
            continue
        ratio = line.signal_to_noise**2
        power += max(min(line.amplitude, highest) ** 2 - line.noise_floor**2, 0.0)
        if race:
            # Strikes once a pass have their first line highest; what exceeds it belongs to something else.
            highest = min(highest, line.amplitude)
        if ratio > now.significant_ratio:
            significant = True
            lines.append(line)
            harmonics += 1
    if not significant:
        return None
    if rhythm.modulator is not None:
        sidebands = _sidebands(now, envelope, rhythm, frequency_hz, taken)
        # A full modulation has sidebands half as high as their line: much of a higher one is another rhythm's.
        power += sum(min(line.amplitude, highest) ** 2 for line in sidebands)
        lines += sidebands
    expected = rhythm.order * now.speed_hz
    depth = float(np.sqrt(power)) * (1.0 - modulated_mesh(now, envelope, frequency_hz))
    return RhythmEvidence(rhythm, envelope, depth, frequency_hz, expected, tuple(lines), harmonics, shared)


def _sidebands(
    now: Observation,
    envelope: EnvelopeSpectrum,
    rhythm: DefectRhythm,
    frequency_hz: float,
    taken: list[RhythmEvidence],
) -> list[Line]:
    found = []
    for harmonic in (1, 2):
        for side in (-1, 1):
            wanted = harmonic * frequency_hz + side * (rhythm.modulator or 0.0) * now.speed_hz
            modulator = f"{rhythm.modulator or 0:g}X" if rhythm.fault == "bearing_inner_race" else "FTF"
            name = f"{harmonic} x {rhythm.label} {'-' if side < 0 else '+'} {modulator}"
            line = envelope_line(now, envelope, wanted, name, rhythm, None)
            if line is None or line.signal_to_noise**2 < now.significant_ratio:
                continue
            at = line.frequency_hz
            if not on_shaft(now, envelope, at) and not of_another(now, envelope, at, taken):
                found.append(line)
    return found


def _overruled(now: Observation, evidence: RhythmEvidence) -> bool:
    """Return whether a line that is neither this rhythm's nor a shaft's towers over it in its own envelope."""
    spectrum = evidence.envelope.spectrum
    resolution = spectrum.resolution_hz
    modulator = (evidence.rhythm.modulator or 1.0) * now.speed_hz
    family = np.array([h * evidence.frequency_hz + k * modulator for h in range(7) for k in range(-3, 4)])
    shafts = np.concatenate([np.arange(1, 40) * ratio * now.speed_hz for ratio in shaft_ratios(now)])
    own = max((line.amplitude for line in evidence.lines), default=0.0)
    loud = np.flatnonzero((spectrum.amplitude[0] > _LOUDER * own) & (spectrum.power_ratio[0] > now.significant_ratio))
    away = [
        np.abs(places - spectrum.frequency_hz[index]).min()
        for index in loud
        if index > 2
        for places in (np.concatenate([family, shafts]),)
    ]
    return any(distance > 2.5 * resolution for distance in away)


def _finding(
    now: Observation,
    baseline: Observation | None,
    bearing: MountedBearing,
    evidence: RhythmEvidence,
    crowd: float,
) -> Finding:
    odds = evidence.odds * crowd
    lines = evidence.lines
    note = ""
    own = now.recording.channels[evidence.envelope.channel].name
    if (
        baseline is not None
        and baseline.speed is not None
        and any(channel.name == own for channel in baseline.recording.channels)
    ):
        # A baseline without this sensor says nothing of it. The best of all channels is compared with the best of all.
        before = confirmed(baseline, evidence.rhythm, [], speaking(baseline))
        earlier = before.depth if before is not None else 0.0
        # What the healthy machine shows is its own; only the rest speaks for a defect, and less of it is enough.
        excess = max(evidence.depth - earlier, 0.0)
        even = _EVEN_EXCESS * _load_factor(now, baseline)
        odds *= (max(excess, 1e-6) / even) ** STEEPNESS / defect_odds(evidence.depth)
        note = f" (baseline {earlier:.0%})"
    place = place_of(bearing)
    low, high = evidence.envelope.low_hz, evidence.envelope.high_hz
    channel = now.recording.channels[evidence.envelope.channel].name
    summary = (
        f"{evidence.rhythm.label} of {place} at {evidence.frequency_hz / now.speed_hz:.3f}X "
        f"(theory {evidence.rhythm.order:.3f}X) modulates {channel} by {evidence.depth:.0%}{note} "
        f"in {low:.0f}-{high:.0f} Hz; "
        f"{evidence.harmonics_seen} harmonic{'s' if evidence.harmonics_seen > 1 else ''} above the noise."
    )
    if evidence.depth < EVEN_DEPTH:
        summary += " Shallow: a healthy loaded bearing can do this too."
    probability = odds / (1 + odds)
    if evidence.shared_with_shaft:
        probability *= _SHARED_WITH_SHAFT
        summary += " This record cannot tell it from a multiple of the shaft's speed: record longer, with a tacho."
    return Finding(evidence.rhythm.fault, probability, summary, lines, _CHECKS[evidence.rhythm.fault])


def _load_factor(now: Observation, baseline: Observation) -> float:
    """Return how much more modulation means nothing where something else changed.

    A risen 1X is a rotating load, which makes a sound bearing beat too; another way to the sensor shows other bands.
    """
    if not comparable(now, baseline):
        return 2.0
    rise = float(np.median(order_change_db(now, baseline, 1.0)[now.radial_channels()]))
    other_path = 1.5 if path_changed(now, baseline) else 1.0
    return other_path * (1.0 + max(10 ** (rise / 20) - 1.0, 0.0) / 5)


def _ball_or_cage(findings: list[Finding], place: str) -> list[Finding]:
    """Share one bearing's cage rhythm between ball and cage: a damaged ball shows too as the cage carries it round."""
    here = [one for one in findings if f" of {place} at " in one.summary]
    cage = next((one for one in here if one.fault == "bearing_cage"), None)
    if cage is None:
        return here
    others = [one for one in here if one.fault not in ("bearing_cage", "bearing_ball")]
    ball = next((one for one in here if one.fault == "bearing_ball"), None)
    direct = 0.0 if ball is None else ball.probability
    shared = cage.probability * (1 - direct)
    note = " A damaged ball and a damaged cage both make this rhythm."
    shown = cage if ball is None or cage.probability > direct else ball
    as_ball = replace(
        shown,
        fault="bearing_ball",
        probability=direct + 0.5 * shared,
        summary=shown.summary + (note if shown is cage else ""),
        rivals=("bearing_cage",),
        check=_CHECKS["bearing_ball"],
    )
    as_cage = replace(cage, probability=0.5 * shared, summary=cage.summary + note, rivals=("bearing_ball",))
    return [*others, as_ball, as_cage]
