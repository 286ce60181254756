"""What an extended model is worth to a classifier: python tests/measured/extension_gain.py --features FOLDER [--write].

Three classifiers learn the same recipe with the same seeds from three machines: the Analog Devices bench as given, as
calibrated by the model-gap engine on the healthy recordings at 1200 and 2400 rpm, and as extended by it from those and
the heaviest imbalance class at the same speeds. They are judged on recordings that the engine did not see: the other
imbalance classes, every class at 1800 rpm, and the benches of CWRU and MFPT. No classifier learns from a measured
recording; the label of the campaign (unbalance) is the one label used. Splits go by recording.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from rotorwise.diagnose.learning.fault_classifier import FaultClassifier, out_of_group
from rotorwise.diagnose.learning.feature_file import read_features, write_features
from rotorwise.diagnose.learning.feature_table import FeatureTable
from rotorwise.diagnose.learning.learning_set import learnable, learning_set
from rotorwise.diagnose.learning.training import UNKNOWN_BELOW

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import DATA
from extension_machines import SEEN_CLASS, SEEN_SPEEDS, machines
from extension_rows import table_of_machine, with_forces
from learning_table import Seen, seen
from rig_calibration import bench

README = Path(__file__).resolve().parents[2] / "diagnose" / "learning" / "README.md"
MARKS = ("<!-- extension table -->", "<!-- end of extension table -->")
WAYS = ("given", "calibrated", "extended")
#: Recordings and draws of the machine are resampled so often.
RESAMPLED = 2000


@dataclass(frozen=True, eq=False)
class Answers:
    """A classifier's answers to the judged recordings.

    Attributes
    ----------
    right : array of bool (recordings,)
        The truth is the likeliest; for a sound machine and a fault that does not show: nothing or the truth is named.
    stated : array (recordings,)
        Probability given to the truth ("healthy" where a fault does not show).
    known : array of bool (recordings,)
        Like the training.
    """

    right: np.ndarray
    stated: np.ndarray
    known: np.ndarray


def was_seen(one: Seen) -> bool:
    """Return whether the engine saw a recording."""
    healthy = [f"ADI {speed} healthy" for speed in SEEN_SPEEDS]
    return one.case.name in (*healthy, *(f"ADI {speed} imbalance {SEEN_CLASS}" for speed in SEEN_SPEEDS))


def kinds(recordings: Sequence[Seen]) -> dict[str, np.ndarray]:
    """Return which recordings belong to each row of the table."""
    truth, visible = np.array([one.truth for one in recordings]), np.array([one.visible for one in recordings])
    bench = np.array([one.case.name.startswith("ADI") for one in recordings])
    fast = np.array(["1800" in one.case.name for one in recordings])
    bearing = visible & np.char.startswith(truth, "bearing")
    sound = (truth == "healthy") | ~visible
    return {
        "unbalance at 1800 rpm": (truth == "unbalance") & fast,
        "unbalance, lighter classes at 1200 and 2400 rpm": (truth == "unbalance") & ~fast,
        "bearing faults that show, this bench": bearing & bench,
        "bearing faults that show, other benches": bearing & ~bench,
        "sound or not visible, nothing wrong named": sound,
    }


def fitted(table: FeatureTable, model: str) -> FaultClassifier:
    """Return a classifier that learned all rows of a table, each alone and against a sound record."""
    rows = learnable(learning_set(table, seed=0))
    return FaultClassifier(model=model).fit(rows.values, rows.labels, groups=rows.groups)


def answered(classifier: FaultClassifier, recordings: Sequence[Seen]) -> Answers:
    """Return a classifier's answers."""
    values = np.array([one.values for one in recordings])
    probability, names = classifier.predict_proba(values), classifier.classes_.tolist()
    answer = classifier.predict(values)
    truth = np.array([one.truth for one in recordings])
    sound = np.array([one.truth == "healthy" or not one.visible for one in recordings])
    wanted = np.where(sound, "healthy", truth)
    stated = [row[names.index(name)] if name in names else 0.0 for row, name in zip(probability, wanted, strict=True)]
    return Answers(
        (answer == truth) | (sound & (answer == "healthy")),
        np.array(stated),
        classifier.novelty_p_value(values) >= UNKNOWN_BELOW,
    )


def wilson(right: int, count: int, *, z: float = 1.96) -> tuple[float, float]:
    """Return the 95 % interval of a share (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209-212).

    Examples
    --------
    >>> tuple(round(end, 3) for end in wilson(8, 10))
    (0.49, 0.943)
    """
    middle = (right + z * z / 2) / (count + z * z)
    half = z / (count + z * z) * math.sqrt(right * (count - right) / count + z * z / 4)
    # Rounding may pass the ends by a last digit.
    return max(middle - half, 0.0), min(middle + half, 1.0)


def gained(before: np.ndarray, after: np.ndarray, *, seed: int = 0) -> tuple[float, float, float]:
    """Return the mean of after - before over recordings and its 95 % interval, recordings resampled in pairs."""
    change = after.astype(float) - before.astype(float)
    stream = np.random.default_rng(seed)
    means = change[stream.integers(change.size, size=(RESAMPLED, change.size))].mean(axis=1)
    low, high = np.quantile(means, (0.025, 0.975))
    return float(change.mean()), float(low), float(high)


def halves(table: FeatureTable, recordings: Sequence[Seen], model: str, *, times: int, seed: int) -> list[Answers]:
    """Return answers of classifiers that learned half of the machine draws, which half drawn anew."""
    draws = np.unique(table.groups)
    found = []
    for number in range(times):
        chosen = np.random.default_rng([seed, number]).permutation(draws)[: draws.size // 2]
        found.append(answered(fitted(table.where(np.isin(table.groups, chosen)), model), recordings))
    return found


def tables(folder: Path, *, draws: int, seed: int) -> dict[str, FeatureTable]:
    """Return what is learned from each machine, from the folder or computed now.

    Where the engine added nothing, the last two are the same.
    """
    options = {"draws": draws, "seed": seed}
    given, calibrated, extended = places = [folder / f"{way}-{draws}-{seed}.parquet" for way in WAYS]
    if not given.is_file():
        _keep(table_of_machine(bench(), **options), given)
    if not (calibrated.is_file() and extended.is_file()):
        found = machines(lambda what: print(what, file=sys.stderr, flush=True))
        added = found.extended.effects[len(found.calibrated.effects) :]
        print(f"engine: {found.answer.kind}", *added, *found.answer.remarks, sep="\n- ", flush=True)
        if not calibrated.is_file():
            _keep(table_of_machine(found.calibrated, **options), calibrated)
        table = read_features(calibrated)[0]
        _keep(with_forces(table, found.calibrated, added, **options) if added else table, extended)
    return {way: read_features(place)[0] for way, place in zip(WAYS, places, strict=True)}


def _keep(table: FeatureTable, place: Path) -> None:
    write_features(table, place, {"made_by": Path(__file__).name, "file": place.name}, force=True)


def on_simulation(table: FeatureTable, model: str) -> dict[str, tuple[int, int]]:
    """Return right and all of each fault that shows, against a sound record, on draws that were not learned."""
    rows = learnable(learning_set(table, seed=0))
    names = np.unique(rows.labels)
    probability, _ = out_of_group(FaultClassifier(model=model), rows.values, rows.labels, rows.groups)
    right = names[probability.argmax(axis=1)] == rows.labels
    chosen = {name: rows.with_baseline & (rows.truth == name) for name in names}
    return {str(name): (int(right[own].sum()), int(own.sum())) for name, own in chosen.items()}


def markdown(whole: dict[str, Answers], parts: dict[str, list[Answers]], recordings: Sequence[Seen]) -> str:
    """Return two tables: right answers with Wilson intervals and the range over halves of the draws; probabilities."""
    lines = ["| right, judged on | given | calibrated | extended |", "|---|---|---|---|"]
    for name, chosen in kinds(recordings).items():
        cells = []
        for way in WAYS:
            right, count = int(whole[way].right[chosen].sum()), int(chosen.sum())
            low, high = wilson(right, count)
            spread = [int(one.right[chosen].sum()) for one in parts[way]]
            cells.append(f"{right} of {count} ({low:.0%} to {high:.0%}); halves {min(spread)} to {max(spread)}")
        lines.append(f"| {name} | {' | '.join(cells)} |")
    ways = "given | calibrated | extended | calibrated - given | extended - calibrated"
    lines += ["", f"| mean probability of the truth | {ways} |", "|---|---|---|---|---|---|"]
    for name, chosen in {**kinds(recordings), "all": np.ones(len(recordings), bool)}.items():
        stated = {way: whole[way].stated[chosen] for way in WAYS}
        lines.append(f"| {name} | {' | '.join([*(f'{one.mean():.2f}' for one in stated.values()), *_gains(stated)])} |")
    known = {way: whole[way].known for way in WAYS}
    lines.append(
        f"| all: like the training | {' | '.join([*(f'{k.mean():.2f}' for k in known.values()), *_gains(known)])} |"
    )
    return "\n".join(lines)


def _gains(values: dict[str, np.ndarray]) -> list[str]:
    found = (gained(values[one], values[other]) for one, other in pairwise(WAYS))
    return [f"{mean:+.2f} ({low:+.2f} to {high:+.2f})" for mean, low, high in found]


def main() -> None:
    """Compute, print, and with ``--write`` put the table into the README."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--draws", type=int, default=24, help="draws of the machine's parameters")
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--model", default="linear", help="linear or boosting")
    asked.add_argument("--halves", type=int, default=10, help="classifiers on half of the draws, for the spread")
    asked.add_argument("--json", type=Path, help="write every answer here")
    asked.add_argument("--write", action="store_true")
    asked.add_argument("--features", type=Path, required=True, help="folder that keeps the features for the next run")
    given = asked.parse_args()
    if not DATA.is_dir():
        sys.exit(f"{DATA} is not there: the measured recordings are needed to make the table.")
    begun = time.process_time()
    given.features.mkdir(exist_ok=True)
    learned = tables(given.features, draws=given.draws, seed=given.seed)
    recordings = [one for one in seen() if not was_seen(one)]
    whole = {way: answered(fitted(learned[way], given.model), recordings) for way in WAYS}
    parts = {way: halves(learned[way], recordings, given.model, times=given.halves, seed=given.seed) for way in WAYS}
    made = markdown(whole, parts, recordings)
    print(f"{len(learned['given'])} records each, {len(recordings)} recordings, {given.model} model")
    print(made)
    for way in WAYS:
        print(f"simulated, not learned, {way}:", on_simulation(learned[way], given.model))
    print(f"{time.process_time() - begun:.0f} s of processor")
    if given.json:
        given.json.write_text(json.dumps(_each(whole, recordings), indent=1))
    if given.write:
        text = README.read_text(encoding="utf-8")
        before, after = text[: text.index(MARKS[0])], text[text.index(MARKS[1]) :]
        README.write_text(f"{before}{MARKS[0]}\n{made}\n{after}", encoding="utf-8")


def _each(whole: dict[str, Answers], recordings: Sequence[Seen]) -> list[dict[str, Any]]:
    return [
        {"recording": one.case.name, "truth": one.truth, "visible": one.visible}
        | {way: [bool(whole[way].right[i]), round(float(whole[way].stated[i]), 3)] for way in WAYS}
        for i, one in enumerate(recordings)
    ]


if __name__ == "__main__":
    main()
