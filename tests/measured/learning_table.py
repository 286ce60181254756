"""What rules and model each say of the measured recordings, and both together: python tests/measured/learning_table.py.

No measured recording and no label was used to fit the model, its calibration, its threshold of "unknown" or the weights
of the combination.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rotorwise.datasets.reading import read_blocks
from rotorwise.diagnose.evidence import LEAST_PROBABILITY, judge
from rotorwise.diagnose.learning.changes import model_features
from rotorwise.diagnose.learning.default_model import default_model
from rotorwise.diagnose.learning.model_file import Model
from rotorwise.diagnose.learning.opinion import stated, with_opinion
from rotorwise.diagnose.learning.sources import described
from rotorwise.diagnose.observe import Observation, observe
from rotorwise.diagnose.result import Finding, Opinion

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import DATA, HERE, Case, cases

README = Path(__file__).resolve().parents[2] / "diagnose" / "learning" / "README.md"
BEGIN, END = "<!-- measured table -->", "<!-- end of measured table -->"
#: Part of a case's name, what is wrong, and whether its card says that this is visible.
TRUTH = (
    ("IR007", "bearing_inner_race", True),
    ("OR007", "bearing_outer_race", True),
    ("OR014", "bearing_outer_race", False),
    ("B007", "bearing_ball", False),
    ("CWRU normal", "healthy", True),
    ("MFPT Inner", "bearing_inner_race", True),
    ("MFPT Outer", "bearing_outer_race", True),
    ("imbalance", "unbalance", True),
    ("misaligned", "misalignment", False),
    ("bent shaft", "bent_shaft", False),
    ("HOR", "bearing_outer_race", True),
    ("HIR", "bearing_inner_race", True),
    ("LIR", "bearing_inner_race", True),
    ("HBF", "bearing_ball", False),
    ("healthy", "healthy", True),
)
WAYS = ("rules", "model", "both")


@dataclass(frozen=True, eq=False)
class Seen:
    """A recording as rules and model take it."""

    case: Case
    truth: str
    visible: bool
    now: Observation
    baseline: Observation | None
    values: np.ndarray
    findings: tuple[Finding, ...]


def seen() -> list[Seen]:
    """Return every bearing and shaft case, measured once."""
    known: dict[tuple[str, str], Observation] = {}

    def observed(case: Case, file: str) -> Observation:
        key = file, case.sidecar
        if key not in known:
            sidecar = HERE / f"{case.sidecar}.toml"
            blocks = read_blocks(DATA / file, metadata=case.metadata, sidecar=sidecar, block_samples=1 << 19)
            known[key] = observe(next(iter(blocks)))
        return known[key]

    found = []
    for case in cases():
        truth = next(((name, visible) for part, name, visible in TRUTH if part in case.name), None)
        if truth is None:
            continue
        now = observed(case, case.file)
        before = None if case.baseline is None else observed(case, case.baseline)
        values = model_features(described(now), None if before is None else described(before))
        found.append(Seen(case, *truth, now, before, values, judge(now, before)))
    return found


def answers(one: Seen, model: Model) -> dict[str, tuple[str, float]]:
    """Return each way's first name above even odds with its probability; "healthy" stands for nothing evident."""
    opinion = stated(model, one.values, combine=one.baseline is None)
    both = with_opinion(one.findings, opinion, least=LEAST_PROBABILITY)
    return {"rules": _top(one.findings), "model": _likeliest(opinion), "both": _top(both)}


def _top(findings: tuple[Finding, ...]) -> tuple[str, float]:
    if findings and findings[0].probability > 0.5:
        return findings[0].fault, findings[0].probability
    return "healthy", findings[0].probability if findings else 0.0


def _likeliest(opinion: Opinion) -> tuple[str, float]:
    name = max(opinion.probabilities, key=lambda one: opinion.probabilities[one])
    return name if opinion.known else "unknown", opinion.probabilities[name]


def totals(found: list[tuple[Seen, dict[str, tuple[str, float]]]]) -> dict[str, dict[str, tuple[int, int]]]:
    """Return for each way: right of all, by kind of recording."""

    def count(way: str, wanted, right) -> tuple[int, int]:
        rows = [(one, got[way][0]) for one, got in found if wanted(one)]
        return sum(right(one, name) for one, name in rows), len(rows)

    kinds = {
        "bearing faults that show, right first": (
            lambda one: one.visible and one.truth.startswith("bearing"),
            lambda one, name: name == one.truth,
        ),
        "unbalance against a baseline, right first": (
            lambda one: one.truth == "unbalance",
            lambda one, name: name == one.truth,
        ),
        "healthy, called faulty": (
            lambda one: one.truth == "healthy",
            lambda one, name: name not in ("healthy", "unknown"),
        ),
        "not visible by the card, called something else": (
            lambda one: not one.visible,
            lambda one, name: name not in ("healthy", "unknown", one.truth),
        ),
    }
    return {kind: {way: count(way, *which) for way in WAYS} for kind, which in kinds.items()}


def table(model: Model, recordings: list[Seen]) -> str:
    """Return the table in Markdown."""
    found = [(one, answers(one, model)) for one in recordings]
    lines = ["| | rules alone | model alone | both |", "|---|---|---|---|"]
    for kind, ways in totals(found).items():
        lines.append(f"| {kind} | " + " | ".join(f"{ways[way][0]} of {ways[way][1]}" for way in WAYS) + " |")
    lines += ["", "| recording | truth | rules | model | both |", "|---|---|---|---|---|"]
    for one, got in found:
        hidden = "" if one.visible else " (not visible)"
        cells = " | ".join(f"{got[way][0]} {got[way][1]:.2f}" for way in WAYS)
        lines.append(f"| {one.case.name} | {one.truth}{hidden} | {cells} |")
    return "\n".join(lines)


def main() -> None:
    """Rewrite the part of the README between the markers."""
    if not DATA.is_dir():
        sys.exit(f"{DATA} is not there: the measured recordings are needed to make the table.")
    made = table(default_model(), seen())
    text = README.read_text(encoding="utf-8")
    before, after = text[: text.index(BEGIN)], text[text.index(END) :]
    README.write_text(f"{before}{BEGIN}\n{made}\n{after}", encoding="utf-8")
    print(made)


if __name__ == "__main__":
    main()
