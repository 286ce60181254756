"""One answer from the blocks of a recording, and its verdict in words."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..datasets.recording import Recording
from .evidence import LEAST_PROBABILITY, LEAST_TURNS
from .learning.opinion import words_of
from .notes import NO_ROTATION
from .observe import TRUSTED_SPEED
from .result import Analysis, Finding, Opinion, Pictures, Severity, SpeedEstimate

_WORDS = {
    "unbalance": "unbalance",
    "misalignment": "misalignment",
    "bent_shaft": "a bent shaft",
    "looseness": "looseness",
    "rub": "a rub",
    "oil_whirl": "oil whirl",
    "bearing_outer_race": "an outer-race bearing defect",
    "bearing_inner_race": "an inner-race bearing defect",
    "bearing_ball": "a ball defect",
    "bearing_cage": "a cage defect",
    "gear_wear": "gear wear",
    "gear_tooth_fault": "a tooth fault",
    "gear_eccentricity": "gear eccentricity",
    "electrical": "an electrical cause",
    "resonance": "a resonance",
    "sensor_fault": "a sensor fault",
}
_LIKELY = 0.5
_SURE = 0.9
_PASSING = 0.8
_NOT_ACCEPTABLE = ("C", "D")  # ISO 20816-1: unsatisfactory for long-term continuous operation, and worse


@dataclass(frozen=True)
class BlockResult:
    """What one block of a recording gave; ``recording`` carries the description without the samples."""

    recording: Recording
    samples: int
    speed: SpeedEstimate | None
    state: str
    turns: float
    findings: tuple[Finding, ...]
    severity: tuple[Severity, ...]
    refusal: str
    features: dict[str, float]
    notes: tuple[str, ...]
    remarks: tuple[str, ...]
    unexplained: tuple[str, ...]
    lines_tested: int
    baseline_path: str | None
    opinion: Opinion | None = None

    @property
    def start_s(self) -> float:
        """Time in the file of the block's first sample."""
        return self.recording.provenance.start_sample / self.recording.rate_hz


def merge(path: str, blocks: Sequence[BlockResult], shown: Pictures) -> Analysis:
    """Return one analysis for all blocks of a file.

    Probabilities are averaged over the blocks, or over the last fifth of them where that is more: a fault that came and
    stayed is there now. The worst severity counts, warnings are told once. A block of a machine at rest says nothing of
    the faults, so only turning blocks are averaged where there are any.
    """
    first = blocks[0].recording
    turning = [block for block in blocks if block.state == "turning"] or list(blocks)
    findings = _findings(turning)
    severity = _severity(blocks)
    speed = _speed(turning)
    unexplained = _told_once([block.unexplained for block in turning])
    warnings = [*first.warnings, *_told_once([block.notes for block in blocks]), *unexplained]
    warnings += _passing(turning, findings)
    opinion = _opinion(turning)
    samples = sum(block.samples for block in blocks)
    turns = max(block.turns for block in turning)
    return Analysis(
        path=path,
        verdict=verdict(findings, severity, state=turning[0].state, speed=speed, turns=turns, unexplained=unexplained),
        findings=findings,
        severity=severity,
        severity_refusal="" if severity else blocks[0].refusal,
        speed=speed,
        warnings=tuple(dict.fromkeys(warnings)),
        channels=tuple(channel.name for channel in first.channels),
        rate_hz=first.rate_hz,
        duration_s=samples / first.rate_hz,
        features=_features(turning),
        label=first.label,
        reader=first.provenance.reader,
        baseline_path=blocks[0].baseline_path,
        tests=max(block.lines_tested for block in blocks),
        blocks=tuple(_row(block) for block in blocks) if len(blocks) > 1 else (),
        pictures=shown,
        remarks=(*blocks[0].remarks, *(() if opinion is None else (words_of(opinion),))),
        opinion=opinion,
    )


def _opinion(blocks: Sequence[BlockResult]) -> Opinion | None:
    """Return the mean of what the model says of the blocks; one that most blocks are unlike does not count."""
    found = [block.opinion for block in blocks if block.opinion is not None]
    if not found:
        return None
    names = found[0].probabilities
    return replace(
        found[0],
        probabilities={name: float(np.mean([one.probabilities[name] for one in found])) for name in names},
        p_value=float(np.median([one.p_value for one in found])),
        known=sum(one.known for one in found) * 2 >= len(found),
    )


def _findings(blocks: Sequence[BlockResult]) -> tuple[Finding, ...]:
    names = dict.fromkeys(finding.fault for block in blocks for finding in block.findings)
    merged = [_one_finding(fault, blocks) for fault in names]
    kept = [finding for finding in merged if finding.probability >= LEAST_PROBABILITY]
    return tuple(sorted(kept, key=lambda finding: -finding.probability))


def _one_finding(fault: str, blocks: Sequence[BlockResult]) -> Finding:
    found = [next((one for one in block.findings if one.fault == fault), None) for block in blocks]
    stated = [0.0 if one is None else one.probability for one in found]
    late = stated[-max(len(stated) // 5, min(3, len(stated))) :]
    strongest = max((one for one in found if one is not None), key=lambda one: one.probability)
    summary = strongest.summary
    if len(blocks) > 1:
        begin = next(block for block, one in zip(blocks, found, strict=True) if one is not None).start_s
        seen = sum(one is not None for one in found)
        summary += f" Seen in {seen} of {len(blocks)} blocks, first at {begin:.0f} s; the strongest is shown."
    probability = max(sum(stated) / len(stated), sum(late) / len(late))
    return replace(strongest, probability=probability, summary=summary)


def _passing(blocks: Sequence[BlockResult], findings: tuple[Finding, ...]) -> list[str]:
    """Tell of faults that one block shows clearly and the whole record does not."""
    shown = {finding.fault for finding in findings if finding.probability >= _LIKELY}
    found = {}
    for block in blocks:
        for finding in block.findings:
            if finding.probability >= _PASSING and finding.fault not in shown:
                found.setdefault(
                    finding.fault, f"For a while only, first at {block.start_s:.0f} s: {_WORDS[finding.fault]}."
                )
    return list(found.values())


def _severity(blocks: Sequence[BlockResult]) -> tuple[Severity, ...]:
    worst: dict[tuple[str, str], Severity] = {}
    for block in blocks:
        for one in block.severity:
            key = (one.channel, one.table)
            if key not in worst or (one.zone, one.value) > (worst[key].zone, worst[key].value):
                note = f"{one.note} Worst block at {block.start_s:.0f} s.".strip() if len(blocks) > 1 else one.note
                worst[key] = replace(one, note=note)
    return tuple(sorted(worst.values(), key=lambda one: (one.zone, one.value / one.boundaries[0]), reverse=True))


def _speed(blocks: Sequence[BlockResult]) -> SpeedEstimate | None:
    known = [block.speed for block in blocks if block.speed is not None]
    if not known:
        return None
    speeds = np.array([speed.speed_hz for speed in known])
    middle = known[int(np.argsort(speeds)[speeds.size // 2])]
    spread = float(np.ptp(speeds) / middle.speed_hz)
    return replace(
        middle,
        low_hz=min(speed.low_hz for speed in known),
        high_hz=max(speed.high_hz for speed in known),
        confidence=float(np.mean([speed.confidence for speed in known])),
        variation=max(spread, *(speed.variation for speed in known)),
    )


def _told_once(told: Sequence[tuple[str, ...]]) -> list[str]:
    """Return each warning once; in long files warnings that differ in their numbers only count as one."""
    if len(told) == 1:
        return list(told[0])
    count: dict[str, list[str]] = {}
    for notes in told:
        for note in notes:
            count.setdefault(re.sub(r"[-+\d.]+", "", note), []).append(note)
    return [
        same[0] if len(same) == 1 else f"{same[0]} (in {len(same)} of {len(told)} blocks)" for same in count.values()
    ]


def _features(blocks: Sequence[BlockResult]) -> dict[str, float]:
    names = blocks[0].features
    return {
        name: (_mean_angle if name.startswith("1x_phase") else _median)([block.features[name] for block in blocks])
        for name in names
    }


def _mean_angle(values: list[float]) -> float:
    """Return the mean direction of angles in degrees: -179 and 179 are 2 degrees apart, not opposite."""
    finite = np.array([value for value in values if np.isfinite(value)])
    return float(np.degrees(np.angle(np.exp(1j * np.radians(finite)).mean()))) if finite.size else float("nan")


def _median(values: list[float]) -> float:
    finite = [value for value in values if np.isfinite(value)]
    return float(np.median(finite)) if finite else float("nan")


def _row(block: BlockResult) -> dict:
    top = block.findings[0] if block.findings else None
    return {
        "time_s": block.start_s,
        "speed_rpm": None if block.speed is None else block.speed.speed_rpm,
        "rms": block.features["rms"],
        "kurtosis": block.features["kurtosis"],
        "1x_amplitude": block.features["1x_amplitude"],
        "zone": max((one.zone for one in block.severity), default=None),
        "top_finding": None if top is None else top.fault,
        "top_probability": 0.0 if top is None else top.probability,
    }


def verdict(
    findings: tuple[Finding, ...],
    severity: tuple[Severity, ...],
    *,
    state: str,
    speed: SpeedEstimate | None,
    turns: float,
    unexplained: Sequence[str] = (),
) -> str:
    """Return the answer in a few sentences."""
    if state != "turning":
        return f"{NO_ROTATION[state]} No diagnosis."
    if speed is None:
        return "The shaft speed is unknown, so no line can be named. Pass --speed."
    level, high = "", ""
    if severity and speed.confidence >= TRUSTED_SPEED:
        # The band of the severity tables depends on the speed.
        worst = severity[0]
        level = f" Severity: zone {worst.zone} ({worst.value:.3g} {worst.unit}, {worst.standard})."
        if worst.zone in _NOT_ACCEPTABLE:
            same = worst.alarm is not None and worst.value <= worst.alarm
            high = f" in zone {worst.zone}{', not significantly above the baseline' if same else ''}"
    if turns < LEAST_TURNS:
        return (
            f"The record is too short for a diagnosis: {turns:.1f} turns, at least {LEAST_TURNS:.0f} are needed.{level}"
        )
    likely = [one for one in findings if one.probability >= _LIKELY]
    if likely:
        words = " and ".join(f"{_WORDS[one.fault]} ({one.probability:.0%})" for one in likely[:3])
        certainty = "Clear signs of" if likely[0].probability >= _SURE else "Probably"
        return f"{certainty} {words}.{level}"
    if speed.method == "hint only":
        level = f" The given speed is not confirmed by the vibration.{level}"
    rest = f" Not explained: {unexplained[0][0].lower()}{unexplained[0][1:]}" if unexplained else ""
    if findings:
        best = findings[0]
        return f"Nothing certain. The strongest hint is {_WORDS[best.fault]} ({best.probability:.0%}).{rest}{level}"
    if high:
        return f"The level is{high}, and no known fault explains it.{rest}{level}"
    return f"No fault is evident from this measurement.{rest}{level}"
