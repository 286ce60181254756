"""What a search for the cause costs, against conditions, probes and size of the catalogue; draws docs/gap_cost.svg.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/gap_speed.py [PICTURE.svg] [--machines NAME ...]

Process CPU time of `explain_gap` (search, held-out check, gain; not the reading of files) for an unbalance hidden in
recordings of 2 s at 30 dB or better, after one search that is not counted. One of the three is varied at a time, from 6
conditions, 3 probes and the whole catalogue.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from rotorwise.datasets.recording import Campaign, Recording
from rotorwise.datasets.simulated import record_machine
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.hypotheses import candidates
from rotorwise.diagnose.gap.trials.draws import perturbed
from rotorwise.diagnose.gap.trials.ranges import find_range
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import Machine, find_machine
from rotorwise.simulators.sensor_chain import SensorChain

PICTURE = Path(__file__).parents[2] / "docs" / "gap_cost.svg"
CHAIN = SensorChain(pulses_per_revolution=1, noise={"m": 2e-8, "m/s2": 2e-3, "rad/s": 1e-4, "rad": 2e-7})
USUAL = (6, 3)
CONDITIONS, PROBES, CATALOGUE = (3, 6, 12), (1, 2, 3, 4), (5, 10, 20)
MOMENT_KG_M = {"amb_rotor": 2e-4, "rigid_coupling": 0.02, "test_rig": 3e-4, "gearbox": 1e-4}


def recordings(machine: Machine, speeds: Sequence[float], seed: int) -> tuple[Recording, ...]:
    """Return recordings of a machine at each speed."""
    how = find_range(machine.name)
    return tuple(
        record_machine(
            machine, speed_rpm=rpm, duration_s=2.0, rate_hz=how.rate_hz, step_s=how.step_s, chain=CHAIN, seed=seed + i
        ).recording
        for i, rpm in enumerate(speeds)
    )


def seconds(campaign: Campaign, machine: Machine, probes: int, conditions: int, only: frozenset[str] | None) -> float:
    """Return the CPU seconds of one search with some of the probes and conditions."""
    names = [one.name for one in machine.bare_assembly().probes]
    rows = [i for i, one in enumerate(campaign.recordings[0].channels) if one.name in names][:probes]
    rows += [i for i, one in enumerate(campaign.recordings[0].channels) if one.quantity == "tacho"]
    every = np.linspace(0, len(campaign.recordings) - 1, conditions).round().astype(int)
    part = replace(
        campaign,
        recordings=tuple(campaign.recordings[i].select(rows) for i in every),
        baseline=tuple(campaign.baseline[i].select(rows) for i in every),
    )
    begun = time.process_time()
    explain_gap(part, machine, only=only)
    return time.process_time() - begun


def measured(name: str) -> dict[str, list[tuple[int, float]]]:
    """Return the CPU seconds of one machine's searches, by what is varied."""
    machine, how = find_machine(name), find_range(name)
    real = perturbed(machine, np.random.default_rng(5))
    most = max(CONDITIONS) if name != "gearbox" else USUAL[0]
    speeds = how.draw_speeds(most, np.random.default_rng(6))
    hidden = Unbalance(moment_kg_m=MOMENT_KG_M[name], angle_rad=0.7)
    campaign = Campaign(recordings(real.with_effects(hidden), speeds, 100), recordings(real, speeds, 1))
    able = sorted({one.name for one in candidates(machine)})
    rest = [one for one in able if one != "unbalance"]
    few = {
        count: frozenset(("unbalance", *rest[:: max(len(rest) // (count - 1), 1)][: count - 1])) for count in CATALOGUE
    }
    usual = (USUAL[1], USUAL[0])
    seconds(campaign, machine, 1, 3, frozenset(("unbalance",)))
    whole = seconds(campaign, machine, *usual, None)
    found = {
        "conditions": [
            (n, whole if n == USUAL[0] else seconds(campaign, machine, USUAL[1], n, None))
            for n in CONDITIONS
            if n <= most
        ],
        "probes": [(n, whole if n == USUAL[1] else seconds(campaign, machine, n, USUAL[0], None)) for n in PROBES],
        "effects": [*((n, seconds(campaign, machine, *usual, own)) for n, own in few.items()), (len(able), whole)],
    }
    if name == "gearbox":
        found.pop("probes")
        found.pop("conditions")
    return found


def picture(every: dict[str, dict[str, list[tuple[int, float]]]]) -> str:
    """Return the curves as SVG: a panel for what is varied, a line for each machine, seconds on a logarithmic axis."""
    width, height, panel, top = 840, 300, 240, 40
    colours = dict(zip(every, ("#1f5fa8", "#b3261e", "#2b7a3d", "#8a5a00"), strict=False))
    low, high = 1.0, 1000.0
    parts = []

    def across(value: float, largest: float, left: float) -> float:
        return left + panel * value / largest

    def down(value: float) -> float:
        return top + (height - top - 40) * (1 - np.log(max(value, low) / low) / np.log(high / low))

    for column, what in enumerate(("conditions", "probes", "effects")):
        left = 50 + column * (panel + 30)
        largest = 1.05 * max((n for own in every.values() for n, _ in own.get(what, [])), default=1)
        parts.append(f'<text x="{left + panel / 2}" y="{height - 6}" text-anchor="middle">{what}</text>')
        for tick in (1, 10, 60, 600):
            y = down(tick)
            parts.append(f'<line x1="{left}" x2="{left + panel}" y1="{y:.0f}" y2="{y:.0f}" stroke="#ddd"/>')
            parts.append(f'<text x="{left - 4}" y="{y + 4:.0f}" text-anchor="end">{tick}</text>' if not column else "")
        for name, own in every.items():
            points = [(across(n, largest, left), down(s)) for n, s in own.get(what, [])]
            line = " ".join(f"{x:.0f},{y:.0f}" for x, y in points)
            parts.append(f'<polyline points="{line}" fill="none" stroke="{colours[name]}" stroke-width="2"/>')
            for (x, y), (n, _) in zip(points, own.get(what, []), strict=True):
                parts.append(f'<circle cx="{x:.0f}" cy="{y:.0f}" r="3" fill="{colours[name]}"/>')
                parts.append(f'<text x="{x:.0f}" y="{height - 24}" text-anchor="middle" fill="#666">{n}</text>')
    for i, name in enumerate(every):
        parts.append(f'<text x="{50 + 150 * i}" y="18" fill="{colours[name]}">{name}</text>')
    parts.append(f'<text x="{width - 10}" y="18" text-anchor="end">CPU s of a search</text>')
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif"'
    return f'{head} font-size="12"><rect width="100%" height="100%" fill="#fff"/>{"".join(parts)}</svg>\n'


def main() -> None:
    """Print the table and write the picture."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("picture", nargs="?", type=Path, default=PICTURE)
    arguments.add_argument("--machines", nargs="+", default=["amb_rotor", "rigid_coupling", "test_rig", "gearbox"])
    given = arguments.parse_args()
    every = {}
    print("| machine | varied | CPU s |\n|---|---|---|")
    for name in given.machines:
        every[name] = measured(name)
        for what, own in every[name].items():
            print(
                f"| {name} | {what} {', '.join(str(n) for n, _ in own)} | {', '.join(f'{s:.0f}' for _, s in own)} |",
                flush=True,
            )
    given.picture.write_text(picture(every), encoding="utf-8")


if __name__ == "__main__":
    main()
