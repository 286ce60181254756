"""Write the table of tests/README.md: python tests/measured/table.py."""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

from rotorwise.diagnose import Analysis, analyse

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import ADI_SPEEDS, DATA, HERE, IMBALANCE, Case, adi, cases

README = HERE.parent / "README.md"
BEGIN, END = "<!-- measured table -->", "<!-- end of measured table -->"


def run(case: Case) -> Analysis:
    """Analyse one case as the command does."""
    return analyse(
        case.path,
        metadata=case.metadata,
        sidecar=HERE / f"{case.sidecar}.toml",
        baseline=[] if case.baseline is None else [DATA / case.baseline],
    )


def row(case: Case, analysis: Analysis) -> str:
    """Return one row of the table."""
    found = ", ".join(f"{one.fault} {one.probability:.2f}" for one in analysis.findings[:3]) or "nothing evident"
    if not any(one.probability >= 0.1 for one in analysis.findings) and "not turning" in analysis.verdict:
        found = "not turning"
    speed = "-" if analysis.speed is None else f"{analysis.speed.speed_rpm:.0f}"
    passed = case.check(analysis)
    top = analysis.findings[0].probability if analysis.findings else 0.0
    missed = not passed or (case.explanation and top <= 0.5)
    remark = case.explanation if missed else ""
    return f"| {case.name} | {case.expected} | {speed} | {found} | {'yes' if passed else '**no**'} | {remark} |"


def rising() -> list[str]:
    """Return the estimated 1X over the imbalance classes, a line a speed."""
    lines = []
    for speed in ADI_SPEEDS:
        values = []
        for load in ("BaLo", *IMBALANCE):
            case = next(one for one in cases() if one.file == adi(speed, load=load))
            values.append(1e3 * run(case).features["1x_amplitude"])
        strictly = all(low < high for low, high in pairwise(values))
        text = " / ".join(f"{value:.2f}" for value in values)
        lines.append(f"| {speed} | {text} | {'yes' if strictly else '**no**'} |")
    return lines


def main() -> None:
    """Rewrite the part of the README between the markers."""
    if not DATA.is_dir():
        sys.exit(f"{DATA} is not there: the measured recordings are needed to make the table.")
    rows = [row(case, run(case)) for case in cases()]
    table = [
        BEGIN,
        "| recording | expected | rpm found | answer | met | remark |",
        "|---|---|---|---|---|---|",
        *rows,
        "",
        "1X amplitude in mV over the imbalance classes (healthy, very light, light, heavy, very heavy):",
        "",
        "| rpm | 1X, mV | strictly rising |",
        "|---|---|---|",
        *rising(),
        END,
    ]
    text = README.read_text(encoding="utf-8")
    before, after = text[: text.index(BEGIN)], text[text.index(END) + len(END) :]
    README.write_text(before + "\n".join(table) + after, encoding="utf-8")
    print("\n".join(table))


if __name__ == "__main__":
    main()
