"""What the model-gap engine says of MaFaulDa's table of lines: python tests/measured/mafaulda_table.py [ROW ...].

One row of the source is one run: 1X with its phase against the tacho, 2X and 3X by size, of two triaxial sensors. The
rig is `test_rig plausible`, whose geometry is that of this bench. Every fourth run of a class by speed is to be
explained, every other normal run is the baseline; the null takes the normal runs between. Volts are taken for g (the
sensitivity was never applied), which with the unknown radius of the weights leaves one common factor of all masses.

How well a line repeats is told by the normal runs themselves: by how far each lies beside the mean of its neighbours
in speed. Lines are read without a window on a grid of 0.2 Hz, so that sizes scatter by 13 % alike at all channels.

Beside the engine's answer stands the mass that the classical trial weight gives, without any model: 1X less that of the
normal runs, against that of the 10 g runs at the same speeds. ``--first-order`` leaves 2X and 3X out; ``--plot`` draws
how probable "nothing" is against the mass.
"""

from __future__ import annotations

import argparse
import csv
import math
import re
import sys
import time
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from rotorwise.diagnose.gap.explain_lines import explain_lines
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.result import GapResult
from rotorwise.simulators.machine import Machine, find_machine

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import DATA

TABLE = DATA / "02_mafaulda_order_table" / "data.csv"
#: Columns of the sensor between motor and rotor, and the probes that stand for them. Its axial channel and the other
#: sensor are left out: of the one the rig makes little, of the other the radial channel shows hardly anything.
PROBES = {"rad1": "housing_a_y", "tg1": "housing_a_x"}
ORDERS = {1.0: LineKind(), 2.0: LineKind(phase=False), 3.0: LineKind(phase=False)}
RATE_HZ, DURATION_S = 50_000.0, 5.0
M_S2_A_VOLT = 9.80665
#: Runs of a class are thinned to these numbers of speeds.
EVERY_FAULT, EVERY_HEALTHY = 4, 2
#: From how a Rayleigh variable's median and a second difference's variance (1 + 2/4) stand to one standard deviation.
RAYLEIGH_MEDIAN, NORMAL_MEDIAN, SECOND_DIFFERENCE = 1.1774, 0.6745, math.sqrt(1.5)
#: The runs with this weight say what a gram does; runs within about this speed count for each other.
TRIAL_G, NEAR_HZ = 10.0, 0.8
MASSES_G = (6, 10, 15, 20, 25, 30, 35)
#: The picture begins at this mass.
LIGHTEST_G = 0.03
#: Fractions of what the lightest weight changes of 1X, put on the normal runs.
FRACTIONS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
MISALIGNED = {
    "horizontal-misalignment": (0.5, 1.0, 1.5, 2.0),
    "vertical-misalignment": (0.51, 0.63, 1.27, 1.4, 1.78, 1.9),
}
FEW = frozenset(("unbalance", "shaft_bow", "coupling_misalignment", "looseness", "rotating_coupling_force"))


def bench() -> Machine:
    """Return the model of the bench."""
    return find_machine("test_rig")


@cache
def runs(name: str, severity: float | None) -> tuple[dict[str, str], ...]:
    """Return the runs of a class by speed."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["condicao"] == name]
    chosen = [row for row in rows if severity is None or float(row["severidade"]) == severity]
    return tuple(sorted(chosen, key=lambda row: float(row["rotacao_calc"])))


def amplitudes(rows: tuple[dict[str, str], ...]) -> np.ndarray:
    """Return the lines, shape (runs, channels, orders), m/s2."""
    size = np.array([[[float(row[f"{name}_{order:.0f}h"]) for order in ORDERS] for name in PROBES] for row in rows])
    phase = np.array([[float(row[f"{name}_phase"]) for name in PROBES] for row in rows])
    lines = M_S2_A_VOLT * size.astype(complex)
    lines[:, :, 0] *= np.exp(1j * phase)
    return lines


@cache
def repeatability() -> np.ndarray:
    """Return by which share a line of a run lies beside its neighbours, shape (channels, orders)."""
    lines = amplitudes(runs("normal", None))
    beside = np.abs(lines[1:-1] - (lines[:-2] + lines[2:]) / 2) / np.abs(lines[1:-1])
    return np.median(beside, axis=0) / SECOND_DIFFERENCE / np.array([RAYLEIGH_MEDIAN, NORMAL_MEDIAN, NORMAL_MEDIAN])


def as_lines(rows: tuple[dict[str, str], ...], values: np.ndarray | None = None) -> OrderLines:
    """Return runs as lines; ``values`` replace what the table has."""
    found = amplitudes(rows) if values is None else values
    conditions = tuple(Condition(60 * float(row["rotacao_calc"])) for row in rows)
    deviations = repeatability() * np.abs(found)
    return OrderLines(
        conditions, tuple(PROBES.values()), tuple(ORDERS), found, deviations, tuple(ORDERS.values()), (0, 0, 0)
    )


def case(name: str) -> tuple[OrderLines, OrderLines]:
    """Return lines to explain and healthy ones: "normal", "15 g", "0.2 of 6 g", "horizontal-misalignment 2.0"."""
    normal = runs("normal", None)
    healthy = as_lines(normal[::EVERY_HEALTHY])
    if name == "normal":
        return as_lines(normal[1 :: 2 * EVERY_HEALTHY]), healthy
    if " of " in name:
        share, rows = float(name.split()[0]), normal[1 :: 2 * EVERY_HEALTHY]
        speeds, lightest = change(float(MASSES_G[0]))
        mixed = amplitudes(rows)
        mixed[:, :, 0] += share * np.array([near(speeds, lightest, float(row["rotacao_calc"])) for row in rows])
        return as_lines(rows, mixed), healthy
    if name.endswith(" g"):
        return as_lines(runs("imbalance", float(name[:-2]))[::EVERY_FAULT]), healthy
    kind, severity = name.split()
    return as_lines(runs(kind, float(severity))[::EVERY_FAULT]), healthy


def names() -> list[str]:
    """Return all rows of the table."""
    return [
        "normal",
        *(f"{share:g} of {MASSES_G[0]} g" for share in FRACTIONS),
        *(f"{mass} g" for mass in MASSES_G),
        *(f"{kind} {severity}" for kind, severities in MISALIGNED.items() for severity in severities),
    ]


def by_trial_weight(name: str) -> str:
    """Return the mass that the runs with the trial weight let expect, in words; empty for other rows."""
    if not name.endswith(" g") or " of " in name:
        return ""
    trial_speeds, trial = change(TRIAL_G)
    speeds, own = change(float(name[:-2]))
    for_a_gram = np.array([near(trial_speeds, trial, speed) for speed in speeds]) / TRIAL_G
    mass = (for_a_gram.conj() * own).sum() / (np.abs(for_a_gram) ** 2).sum()
    return (
        f"{abs(mass):.1f} g ({100 * (abs(mass) / float(name[:-2]) - 1):+.0f} %), {np.degrees(np.angle(mass)):.0f} deg"
    )


def change(mass_g: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the speeds, Hz, of the runs with a weight, and 1X less that of the normal runs, (runs, channels)."""
    normal, rows = runs("normal", None), runs("imbalance", mass_g)
    speeds = [np.array([float(row["rotacao_calc"]) for row in own]) for own in (normal, rows)]
    before = amplitudes(normal)[:, :, 0]
    return speeds[1], amplitudes(rows)[:, :, 0] - np.array([near(speeds[0], before, one) for one in speeds[1]])


def near(speeds_hz: np.ndarray, values: np.ndarray, speed_hz: float) -> np.ndarray:
    """Return the mean of values (runs, ...) of runs near a speed."""
    weights = np.exp(-0.5 * ((speeds_hz - speed_hz) / NEAR_HZ) ** 2)
    return np.tensordot(weights, values, 1) / weights.sum()


def row(name: str, answer: GapResult, seconds: float) -> str:
    """Return a row of the table."""
    likely = ", ".join(f"{'+'.join(own) or 'nothing'} {p:.2f}" for own, p in list(answer.probabilities.items())[:3])
    nearest = re.search(r"Of the known effects (.*?) comes closest: it explains (\d+%)", " ".join(answer.remarks))
    closest = f"{nearest[1]}, {nearest[2]}" if nearest else ""
    return f"| {name} | {answer.kind} | {likely} | {closest} | {by_trial_weight(name)} | {seconds:.0f} |"


def first_order(lines: OrderLines) -> OrderLines:
    """Return 1X alone."""
    return replace(
        lines,
        orders=lines.orders[:1],
        amplitudes=lines.amplitudes[..., :1],
        deviations=lines.deviations[..., :1],
        kinds=lines.kinds[:1],
        reference=lines.reference[:1],
    )


def picture(nothing: dict[str, float]) -> str:
    """Return the probability of "nothing" against the mass, SVG; fractions of the lightest weight are open circles."""
    width, height, left, top = 560, 300, 60, 30
    across, down = width - left - 20, height - top - 60
    parts = [f'<text x="{left}" y="18">Probability of "nothing wrong" against the mass on the disc</text>']
    for share in (0.0, 0.5, 1.0):
        y = top + down * (1 - share)
        parts.append(f'<line x1="{left}" x2="{left + across}" y1="{y}" y2="{y}" stroke="#ddd"/>')
        parts.append(f'<text x="{left - 8}" y="{y + 4}" text-anchor="end">{share:g}</text>')
    for mass in (0.1, 1, 10):
        x = left + across * _place(mass)
        parts.append(f'<text x="{x:.0f}" y="{top + down + 20}" text-anchor="middle">{mass:g} g</text>')
    for name, share in nothing.items():
        mass = float(name.split()[0]) * (MASSES_G[0] if " of " in name else 1)
        x, y = left + across * _place(mass), top + down * (1 - share)
        parts.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" stroke="#036" fill="{"#fff" if " of " in name else "#036"}"/>'
        )
    words = "filled: measured; open: fractions of what 6 g change, on normal runs"
    parts.append(f'<text x="{left}" y="{height - 12}">{words}</text>')
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif"'
    return f'{head} font-size="12"><rect width="100%" height="100%" fill="#fff"/>{"".join(parts)}</svg>\n'


def _place(mass_g: float) -> float:
    return math.log(mass_g / LIGHTEST_G) / math.log(50 / LIGHTEST_G)


def main() -> None:
    """Print the table, a row as soon as it is known."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("rows", nargs="*", default=names())
    asked.add_argument("--first-order", action="store_true", help="1X only")
    asked.add_argument("--plot", type=Path, help="draw the limit of detection, an SVG")
    given = asked.parse_args()
    print("| recorded | verdict | hypotheses | closest | trial weight | CPU s |\n|---|---|---|---|---|---|", flush=True)
    nothing = {}
    for name in given.rows:
        start = time.process_time()
        measured, healthy = case(name)
        if given.first_order:
            measured, healthy = first_order(measured), first_order(healthy)
        answer = explain_lines(measured, bench(), healthy=healthy, rate_hz=RATE_HZ, duration_s=DURATION_S, only=FEW)
        print(row(name, answer, time.process_time() - start), flush=True)
        if name.endswith(" g"):
            nothing[name] = answer.probabilities.get((), 0.0)
    if given.plot:
        given.plot.write_text(picture(nothing), encoding="utf-8")


if __name__ == "__main__":
    main()
