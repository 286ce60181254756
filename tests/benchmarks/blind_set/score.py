"""Tables of a run of the blind set."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np


@dataclass(frozen=True)
class Row:
    """One analysis: the truth and what was answered. ``findings``: fault, probability, summary, rivals."""

    index: int
    label: str
    variant: str
    size: float
    baseline: bool
    remounted: bool
    seconds: float
    record_seconds: float
    rate_hz: float
    channels: int
    unit: str
    bearings_known: bool
    hint_hz: float
    speed_hz: float
    findings: list[tuple[str, float, str, list[str]]]
    levels: list[tuple[float, float, str, list[float]]]
    warned: list[str]

    @property
    def top(self) -> str:
        return self.findings[0][0] if self.findings else "nothing"

    @property
    def named(self) -> bool:
        return any(one[0] == self.label for one in self.findings)

    @property
    def named_or_rival(self) -> bool:
        return self.named or any(self.label in one[3] for one in self.findings)

    @property
    def sure_and_right(self) -> bool:
        return any(one[0] == self.label and one[1] >= 0.5 for one in self.findings)

    @property
    def sure_and_wrong(self) -> bool:
        return any(one[0] != self.label and one[1] >= 0.5 for one in self.findings)


def report(rows: list[Row], heading: str, faults: Sequence[str], outside: Sequence[str], benign: Sequence[str]) -> str:
    """Return the whole result as Markdown."""
    parts = [f"# Blind set\n\n{heading}\n"]
    for known in (False, True):
        chosen = [row for row in rows if row.baseline == known]
        parts.append(f"\n## {'With' if known else 'Without'} a healthy baseline\n")
        parts.append(_labels(chosen, faults))
        parts.append(_false_alarms(chosen, (*benign, *outside)))
        parts.append(_reliability(chosen))
    parts.append("\n## Baseline with sensors where they were, and re-mounted\n" + _remounting(rows, faults))
    parts.append("\n## Severity and time\n" + _levels(rows))
    return "\n".join(parts) + "\n"


def _share(rows: Sequence[Row], test: Callable[[Row], bool]) -> str:
    return f"{100 * sum(map(test, rows)) / len(rows):.0f} %" if rows else "-"


def _labels(rows: list[Row], faults: Sequence[str]) -> str:
    out = [
        "| state | cases | first | first and >= 50 % | among findings | found or a rival of a finding "
        "| wrong at >= 50 % | first named |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for label in (*faults, "all faults"):
        chosen = [row for row in rows if row.label == label or (label == "all faults" and row.label in faults)]
        tops = ", ".join(f"{name} {count}" for name, count in Counter(row.top for row in chosen).most_common(4))
        out.append(
            f"| {label} | {len(chosen)} | {_share(chosen, lambda r: r.top == r.label)} "
            f"| {_share(chosen, lambda r: r.top == r.label and r.sure_and_right)} "
            f"| {_share(chosen, lambda r: r.named)} | {_share(chosen, lambda r: r.named_or_rival)} "
            f"| {_share(chosen, lambda r: r.sure_and_wrong)} | {tops} |"
        )
    return "\n".join(out)


def _false_alarms(rows: list[Row], states: Sequence[str]) -> str:
    out = [
        "\nStates with nothing to name: any finding is wrong.\n",
        "| state | cases | any finding >= 50 % | any finding | which at >= 50 % |",
        "|---|---|---|---|---|",
    ]
    for state in states:
        chosen = [row for row in rows if row.label == state]
        named = Counter(one[0] for row in chosen for one in row.findings if one[1] >= 0.5)
        which = ", ".join(f"{name} {count}" for name, count in named.most_common(5))
        out.append(
            f"| {state} | {len(chosen)} | {_share(chosen, lambda r: r.sure_and_wrong)} "
            f"| {_share(chosen, lambda r: bool(r.findings))} | {which} |"
        )
    return "\n".join(out)


def _reliability(rows: list[Row]) -> str:
    out = [
        "\nStated probability against truth, all findings.\n",
        "| stated | findings | mean stated | true |",
        "|---|---|---|---|",
    ]
    edges = (0.0, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.01)
    for low, high in pairwise(edges):
        inside = [(one[1], one[0] == row.label) for row in rows for one in row.findings if low <= one[1] < high]
        if inside:
            stated, true = np.mean(np.array(inside, dtype=float), axis=0)
            out.append(f"| {low:.2f}-{min(high, 1.0):.2f} | {len(inside)} | {stated:.2f} | {true:.2f} |")
    return "\n".join(out)


def _remounting(rows: list[Row], faults: Sequence[str]) -> str:
    out = [
        "| baseline | fault cases | first | wrong at >= 50 % | healthy cases | false alarms |",
        "|---|---|---|---|---|---|",
    ]
    for moved in (False, True):
        chosen = [row for row in rows if row.baseline and row.remounted == moved]
        ill = [row for row in chosen if row.label in faults]
        sound = [row for row in chosen if row.label == "healthy"]
        place = "re-mounted" if moved else "as before"
        alarms = _share(sound, lambda r: r.sure_and_wrong)
        out.append(
            f"| {place} | {len(ill)} | {_share(ill, lambda r: r.top == r.label)} "
            f"| {_share(ill, lambda r: r.sure_and_wrong)} | {len(sound)} | {alarms} |"
        )
    return "\n".join(out)


def _levels(rows: list[Row]) -> str:
    """Broadband velocity and zone against the truth; the machine's speed against the nominal's 5 %."""
    levels = [
        one for row in rows if not row.baseline and row.label not in ("sensor_fault", "at_rest") for one in row.levels
    ]
    out = []
    if levels:
        ratio = np.array([stated / max(true, 1e-9) for true, stated, *_ in levels])
        zones = np.mean([zone == "ABCD"[int(np.searchsorted(edges, true))] for true, _, zone, edges in levels])
        spread = ", ".join(f"{value:.3f}" for value in np.percentile(ratio, [1, 10, 50, 90, 99]))
        out.append(f"- Velocity stated over true, 1/10/50/90/99 %: {spread} ({len(levels)} channels).")
        out.append(f"- Zone that the true velocity has: {zones:.1%}.")
    seconds = np.array([row.seconds for row in rows])
    recorded = sum(row.record_seconds * row.channels for row in rows)
    out.append(
        f"- Seconds an analysis: median {np.median(seconds):.2f}, 95 % {np.percentile(seconds, 95):.2f}; "
        f"{recorded / seconds.sum():.0f} channel-seconds of record a second."
    )
    out.append(f"- Python warnings raised: {dict(Counter(text for row in rows for text in row.warned).most_common(5))}")
    return "\n".join(out)
