"""From a file to an answer: read, check, find the speed, measure, judge, state the severity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..datasets.metadata import Metadata
from ..datasets.reading import read_blocks
from ..datasets.recording import Recording
from . import evidence
from .features import features
from .learning.opinion import opinion_of, with_opinion
from .merge import BlockResult, merge
from .notes import notes, remarks
from .observe import Observation, observe
from .pictures import pictures
from .result import Analysis, Pictures
from .severity import assess
from .unexplained import unexplained

#: Samples per channel analysed at a time: 20 s at 25.6 kHz.
BLOCK_SAMPLES = 1 << 19


@dataclass(frozen=True)
class Baseline:
    """A healthy record: what it shows, and the record itself."""

    path: str
    observation: Observation
    recording: Recording


def analyse(
    path: str | Path,
    *,
    metadata: Metadata | None = None,
    sidecar: str | Path | None = None,
    baseline: Sequence[str | Path] | Sequence[Baseline] = (),
    severity_table: str | None = None,
    progress: Callable[[int, int | None], None] | None = None,
) -> Analysis:
    """Analyse one file of any length, in bounded memory.

    Parameters
    ----------
    path : str or Path
    metadata : Metadata or None
        What the file lacks; see ``rotorwise.datasets.metadata``.
    sidecar : str or Path or None
        A sidecar file to use instead of the one beside the recording.
    baseline : sequence of paths or of Baseline
        Healthy records of the same machine; the one nearest in speed is used.
    severity_table : str or None
        Name of a zone table; None lets the nameplate decide.
    progress : callable or None
        Called with samples done and samples in all (None when unknown).

    Returns
    -------
    Analysis

    Raises
    ------
    RotorwiseError
        When the file cannot be read, or lacks what is never guessed.

    Examples
    --------
    >>> analyse("pump.wav", metadata=Metadata(speed_rpm=1480)).findings  # doctest: +SKIP
    """
    records = [
        one if isinstance(one, Baseline) else read_baseline(one, metadata=metadata, sidecar=sidecar) for one in baseline
    ]
    blocks: list[BlockResult] = []
    shown, strongest = Pictures(), -1.0
    for recording in _blocks(path, metadata, sidecar):
        block, observation, healthy = _analyse_block(recording, records, severity_table)
        score = max((finding.probability for finding in block.findings), default=0.0)
        if score > strongest:
            strongest = score
            shown = pictures(observation, healthy.observation if healthy else None, block.findings)
        blocks.append(block)
        if progress is not None:
            progress(recording.provenance.start_sample + block.samples, recording.provenance.total_samples)
    return merge(str(path), blocks, shown)


def read_baseline(path: str | Path, *, metadata: Metadata | None = None, sidecar: str | Path | None = None) -> Baseline:
    """Return the first block of a healthy record, measured."""
    recording = next(_blocks(path, metadata, sidecar))
    return Baseline(str(path), observe(recording), recording)


def analyse_recording(
    recording: Recording, *, baseline: Recording | None = None, severity_table: str | None = None
) -> Analysis:
    """Analyse a recording that is in memory already.

    Parameters
    ----------
    recording : Recording
    baseline : Recording or None
        The same machine when it was healthy.
    severity_table : str or None
    """
    records = [] if baseline is None else [Baseline("baseline", observe(baseline), baseline)]
    block, observation, healthy = _analyse_block(recording, records, severity_table)
    shown = pictures(observation, healthy.observation if healthy else None, block.findings)
    return merge(recording.provenance.path or "recording", [block], shown)


def _blocks(path: str | Path, metadata: Metadata | None, sidecar: str | Path | None) -> Iterator[Recording]:
    """Yield the file in blocks; a short rest at the end joins the block before it."""
    waiting: Recording | None = None
    for recording in read_blocks(path, metadata=metadata, sidecar=sidecar, block_samples=BLOCK_SAMPLES):
        if waiting is not None and recording.samples < BLOCK_SAMPLES // 2:
            yield replace(waiting, signals=np.concatenate([waiting.signals, recording.signals], axis=1))
            return
        if waiting is not None:
            yield waiting
        waiting = recording
    if waiting is not None:
        yield waiting


def _analyse_block(
    recording: Recording, records: list[Baseline], severity_table: str | None
) -> tuple[BlockResult, Observation, Baseline | None]:
    observation = observe(recording)
    others = [one for one in records if not _same_file(one.path, recording)]
    healthy = _nearest(observation, others)
    told = () if others or not records else ("The only baseline is the record itself; it is not used.",)
    before = None if healthy is None else healthy.observation
    with np.errstate(over="ignore", invalid="ignore"):  # absurd values are told by the checks
        severity, refusal = assess(
            recording,
            speed_rpm=None if observation.speed is None else observation.speed.speed_rpm,
            baseline=None if healthy is None else healthy.recording,
            table=severity_table,
        )
    observation = replace(observation, zone=max((one.zone for one in severity), default=None))
    measured = features(observation)
    opinion = opinion_of(observation, before, measured=measured)
    findings = with_opinion(evidence.judge(observation, before), opinion, least=evidence.LEAST_PROBABILITY)
    block = BlockResult(
        # An empty array of its own: an empty view would keep the block's samples alive.
        recording=replace(recording, signals=np.empty((len(recording.channels), 0))),
        samples=recording.samples,
        speed=observation.speed,
        state=observation.state,
        turns=observation.turns,
        findings=findings,
        severity=severity,
        refusal=refusal,
        features=measured,
        notes=(*told, *notes(observation, before)),
        unexplained=unexplained(observation, before, findings, severity),
        remarks=remarks(observation),
        lines_tested=observation.lines_tested,
        baseline_path=None if healthy is None else healthy.path,
        opinion=opinion,
    )
    return block, observation, healthy


def _same_file(path: str, recording: Recording) -> bool:
    """Return whether a baseline is the recording itself, which would explain every fault away."""
    mine = recording.provenance.path
    return mine is not None and Path(path).resolve() == Path(mine).resolve()


def _nearest(observation: Observation, records: list[Baseline]) -> Baseline | None:
    """Return the baseline nearest in speed; the first where the speed is unknown."""
    if not records:
        return None
    if observation.speed is None:
        return records[0]
    speed = observation.speed.speed_hz

    def distance(one: Baseline) -> float:
        return abs(one.observation.speed.speed_hz / speed - 1) if one.observation.speed else 10.0

    return min(records, key=distance)
