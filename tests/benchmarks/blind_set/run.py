"""Measure rotorwise on the blind set: ``python tests/benchmarks/blind_set/run.py --cases 400 --seed 7``."""

from __future__ import annotations

import argparse
import json
import platform
import sys
import time
import warnings
from dataclasses import asdict
from pathlib import Path

import numpy as np
from blind_cases import BENIGN, FAULTS, OUTSIDE, build_case
from rotorwise.datasets.recording import Recording
from rotorwise.diagnose import analyse_recording
from score import Row, report

SHARES = {"healthy": 6.0, "at_rest": 1.0, **dict.fromkeys(OUTSIDE, 0.6), **dict.fromkeys(FAULTS, 1.0)}


def labels_of(cases: int, seed: int) -> list[str]:
    """Labels of a set: healthy machines get six times a fault's share; shuffled."""
    names, weights = list(SHARES), np.array(list(SHARES.values()))
    upto = np.round(np.cumsum(weights) / weights.sum() * cases).astype(int)
    out = [name for name, count in zip(names, np.diff(upto, prepend=0), strict=True) for _ in range(count)]
    np.random.default_rng([seed, 10**6]).shuffle(out)
    return out


def measure(seed: int, index: int, label: str) -> list[Row]:
    """Analyse one case without and with its baseline."""
    case = build_case(seed, index, label)
    return [
        _row(index, case.label, case.variant, case.size, case.velocity, case.recording, one, case.remounted)
        for one in (None, case.baseline)
    ]


def _row(
    index: int,
    label: str,
    variant: str,
    size: float,
    velocity: np.ndarray,
    recording: Recording,
    baseline: Recording | None,
    remounted: bool,
) -> Row:
    started = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        answer = analyse_recording(recording, baseline=baseline)
    seconds = time.perf_counter() - started
    names = [channel.name for channel in recording.channels]
    levels = [
        (float(velocity[names.index(one.channel)]) * 1e3, one.value, one.zone, list(one.boundaries))
        for one in answer.severity
        if one.unit == "mm/s" and one.channel in names
    ]
    return Row(
        index=index,
        label=label,
        variant=variant,
        size=size,
        baseline=baseline is not None,
        remounted=remounted,
        seconds=seconds,
        record_seconds=recording.duration_s,
        rate_hz=recording.rate_hz,
        channels=len(names),
        unit=str(recording.channels[0].stored_unit),
        bearings_known=bool(recording.nameplate.bearings),
        hint_hz=(recording.condition.speed_rpm or 0.0) / 60,
        speed_hz=answer.speed.speed_hz if answer.speed else 0.0,
        findings=[(one.fault, one.probability, one.summary, list(one.rivals)) for one in answer.findings],
        levels=levels,
        warned=[str(one.message) for one in caught],
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=300)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--only", help="one label")
    parser.add_argument("--output", type=Path, help="Markdown file; a .json with every answer goes beside it")
    options = parser.parse_args()
    rows: list[Row] = []
    for index, label in enumerate(labels_of(options.cases, options.seed)):
        if options.only in (None, label):
            rows += measure(options.seed, index, label)
            print(f"\r{index + 1}/{options.cases}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    heading = f"{options.cases} cases, seed {options.seed}; Python {platform.python_version()}, numpy {np.__version__}"
    text = report(rows, heading, FAULTS, OUTSIDE, BENIGN)
    print(text)
    if options.output:
        options.output.write_text(text, encoding="utf-8")
        answers = json.dumps([asdict(row) for row in rows], default=float)
        options.output.with_suffix(".json").write_text(answers, encoding="utf-8")


if __name__ == "__main__":
    main()
