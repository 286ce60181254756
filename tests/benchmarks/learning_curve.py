"""Accuracy on measured recordings against amount and realism of the simulated training data; table and picture.

    rotorwise dataset build widely_drawn_benches -o set --limit 1890
    rotorwise dataset build tests/benchmarks/learning_fixed_bench.toml -o fixed --limit 252
    python tests/benchmarks/learning_curve.py set fixed -o FOLDER [--whole features.parquet]

The table that `rotorwise train set -o m.skops --features features.parquet` keeps may be given as ``--whole``.
Tables of features are kept in FOLDER; a second run takes them from there. No measured recording is learned from.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rotorwise.datasets.store import open_store
from rotorwise.diagnose.learning.fault_classifier import FaultClassifier
from rotorwise.diagnose.learning.feature_file import read_features, write_features
from rotorwise.diagnose.learning.feature_table import FeatureTable, feature_table
from rotorwise.diagnose.learning.learning_set import learnable, learning_set
from rotorwise.diagnose.learning.machine_noise import MachineNoise
from rotorwise.diagnose.learning.sources import HINT_ERROR

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "measured"))
from learning_table import Seen, seen

SEED = 1
#: Name, store (0 widely drawn, 1 fixed), noise and hint error: each level has all of those before it.
LEVELS: tuple[tuple[str, int, MachineNoise | None, float], ...] = (
    ("one bench, faults only", 1, None, 0.0),
    ("+ machines, paths, couplings, sensors", 0, None, 0.0),
    ("+ speed error", 0, None, HINT_ERROR),
    ("+ coloured noise", 0, MachineNoise(SEED, modulated=False, lines=False), HINT_ERROR),
    ("+ its modulation", 0, MachineNoise(SEED, lines=False), HINT_ERROR),
    ("+ lines of sound machines", 0, MachineNoise(SEED), HINT_ERROR),
)


def level_table(place: Path, store: str, noise: MachineNoise | None, hint_error: float, pieces: int) -> FeatureTable:
    """Return a level's features, from the folder or computed now."""
    if place.is_file():
        return read_features(place)[0]
    table = feature_table(
        open_store(store), kinds=("relative", "levels"), limit=pieces, hint_error=hint_error, tacho=False, noise=noise
    )
    write_features(table, place, {"store": Path(store).name, "noise": repr(noise), "hint_error": hint_error})
    return table


def score(table: FeatureTable, recordings: list[Seen], model: str) -> dict[str, Any]:
    """Return how a model that learned all rows of a table answers the measured recordings."""
    rows = learnable(learning_set(table, seed=0))
    fitted = FaultClassifier(model=model).fit(rows.values, rows.labels, groups=rows.groups)
    values = np.array([one.values for one in recordings])
    answers = fitted.predict(values)
    known = fitted.novelty_p_value(values) >= 0.02
    truth, visible = np.array([one.truth for one in recordings]), np.array([one.visible for one in recordings])
    bearing = visible & np.char.startswith(truth, "bearing")
    sound = (truth == "healthy") | ~visible
    return {
        "rows": len(table),
        "machines": int(np.unique(rows.groups).size),
        "bearing_right": int((answers == truth)[bearing].sum()),
        "bearing": int(bearing.sum()),
        "false_alarms": int(((answers != "healthy") & (answers != truth))[sound].sum()),
        "sound": int(sound.sum()),
        "known": int(known.sum()),
        "recordings": len(recordings),
    }


def amounts(table: FeatureTable, recordings: list[Seen], model: str) -> list[dict[str, Any]]:
    """Return the score for growing numbers of machine draws, and its spread over which draws."""
    draws = np.array([int(group.rsplit("-", 1)[1]) for group in table.groups])
    found = []
    for count in range(1, draws.max() + 2):
        parts = []
        for first in range(draws.max() + 1):
            chosen = np.isin(draws, (first + np.arange(count)) % (draws.max() + 1))
            parts.append(score(table.where(chosen), recordings, model))
        found.append(
            {
                "draws": count,
                "rows": int(np.mean([one["rows"] for one in parts])),
                "bearing_right": [one["bearing_right"] for one in parts],
                "false_alarms": [one["false_alarms"] for one in parts],
            }
        )
    return found


def picture(levels: list[dict[str, Any]], found: list[dict[str, Any]], model: str) -> str:
    """Return both curves as SVG: bars over realism, lines over amount."""
    width, height, left, bar = 760, 420, 260, 22
    parts = [f'<text x="10" y="18" font-weight="bold">Measured recordings, {model} model alone</text>']
    for place, (x, text) in enumerate(((left, "bearing faults right first"), (left + 250, "sound, called faulty"))):
        parts.append(f'<text x="{x}" y="40">{text}</text>')
        for row, one in enumerate(levels):
            share = (one["bearing_right"] / one["bearing"], one["false_alarms"] / one["sound"])[place]
            count = (f"{one['bearing_right']}/{one['bearing']}", f"{one['false_alarms']}/{one['sound']}")[place]
            y = 48 + bar * row
            colour = ("#2b7a3d", "#b3261e")[place]
            parts.append(f'<rect x="{x}" y="{y}" width="{180 * share:.0f}" height="{bar - 6}" fill="{colour}"/>')
            parts.append(f'<text x="{x + 180 * share + 5:.0f}" y="{y + 13}">{count}</text>')
            if place == 0:
                parts.append(f'<text x="{left - 8}" y="{y + 13}" text-anchor="end">{one["level"]}</text>')
    top, low = 240, 380
    for key, colour, whole in (
        ("bearing_right", "#2b7a3d", levels[0]["bearing"]),
        ("false_alarms", "#b3261e", levels[0]["sound"]),
    ):
        points = []
        for number, one in enumerate(found):
            x = left + 450 * number / max(len(found) - 1, 1)
            values = np.array(one[key]) / whole
            ends = [low - (low - top) * value for value in (values.min(), values.mean(), values.max())]
            line = f'x1="{x:.0f}" x2="{x:.0f}" y1="{ends[0]:.0f}" y2="{ends[2]:.0f}"'
            parts.append(f'<line {line} stroke="{colour}" stroke-width="2"/>')
            points.append(f"{x:.0f},{ends[1]:.0f}")
        parts.append(f'<polyline points="{" ".join(points)}" fill="none" stroke="{colour}" stroke-width="2"/>')
    parts.append(f'<text x="{left - 8}" y="{top + 8}" text-anchor="end">all</text>')
    parts.append(f'<text x="{left - 8}" y="{low}" text-anchor="end">none</text>')
    for number, one in enumerate(found):
        x = left + 450 * number / max(len(found) - 1, 1)
        parts.append(f'<text x="{x:.0f}" y="{low + 18}" text-anchor="middle">{one["draws"]}</text>')
    parts.append(f'<text x="{left + 225}" y="{low + 36}" text-anchor="middle">machine draws of each kind</text>')
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif"'
    return f'{head} font-size="12"><rect width="100%" height="100%" fill="#fff"/>{"".join(parts)}</svg>\n'


def main() -> None:
    """Compute, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stores", nargs=2)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--pieces", type=int, default=20, help="row groups of the widely drawn dataset for each level")
    parser.add_argument("--model", default="linear")
    parser.add_argument("--whole", type=Path, help="features of the whole dataset, as rotorwise train --features wrote")
    given = parser.parse_args()
    given.output.mkdir(exist_ok=True)
    recordings, levels, table = seen(), [], None
    for number, (name, store, noise, hint_error) in enumerate(LEVELS):
        begun = time.process_time()
        place = given.output / f"level-{number}.parquet"
        table = level_table(place, given.stores[store], noise, hint_error, given.pieces)
        levels.append({"level": name, **score(table, recordings, given.model)})
        print(levels[-1], f"{time.process_time() - begun:.0f} s", flush=True)
    if given.whole is not None:
        table = read_features(given.whole)[0]
    assert table is not None
    found = amounts(replace(table, left_out=()), recordings, given.model)
    for one in found:
        print(one, flush=True)
    (given.output / "curve.json").write_text(json.dumps({"levels": levels, "amounts": found}, indent=1))
    (given.output / "learning_curve.svg").write_text(picture(levels, found, given.model))


if __name__ == "__main__":
    main()
