"""Severity estimates on machines that the estimators have not seen: errors, coverage and zones, as tables.

    rotorwise dataset build severity_amb_rotor -o inside
    rotorwise dataset build severity_amb_rotor_outside -o outside
    python tests/benchmarks/severity_coverage.py inside outside     # --alone for the rig

Every machine of the first dataset is held out once (folds by machine). The machines of the second have parameters that
none of the first has; they are judged with the intervals of the first, and, in two halves, with intervals calibrated on
the other half. Run from a folder other than the repository's.
"""

import argparse
import time
from dataclasses import replace

import numpy as np
from rotorwise.datasets.store import open_store
from rotorwise.diagnose.learning.severity.evaluation import TargetScore, ZoneScore, _score, score_zones
from rotorwise.diagnose.learning.severity.model import SeverityModel, calibrate, fit_model, rows_for
from rotorwise.diagnose.learning.severity.reading import SeverityTable, probes_of, read_table, reference_machine
from rotorwise.diagnose.learning.severity.unit_responses import UnitResponses
from rotorwise.diagnose.learning.severity.words import score_lines


class Gathered:
    """Estimates of machines held out, fold after fold; each with the floor of its own model."""

    def __init__(self) -> None:
        self.found: dict[str, list[tuple[np.ndarray, ...]]] = {}
        self.zones: list[ZoneScore] = []

    def add(self, model: SeverityModel, table: SeverityTable, *, zones: int) -> None:
        for name, one in model.regressors.items():
            part = table.part(rows_for(table, name, alone=model.card["alone"]))
            value, ends = one.predict(part.values), one.predict_interval(part.values)
            floor = np.full(len(part), one.floor)
            self.found.setdefault(name, []).append(
                (part.labels[name], value, ends[:, 0], ends[:, 1], part.groups, part.cases, floor)
            )
        chosen = np.random.default_rng(0).permutation(len(table))[:zones]
        scored = score_zones(model, table.part(np.isin(np.arange(len(table)), chosen))) if zones else None
        if scored is not None:
            self.zones.append(scored)

    def lines(self, coverage: float) -> str:
        scores: list[TargetScore] = []
        for name, parts in self.found.items():
            truth, value, low, high, groups, cases, floor = (
                np.concatenate(column) for column in zip(*parts, strict=True)
            )
            chosen = {"all": truth >= 0, "with the fault": truth > 0, "weak": (truth > 0) & (truth < floor)}
            for case, here in {**chosen, **{one: cases == one for one in sorted(set(cases))}}.items():
                if here.any():
                    ends = np.column_stack([low, high])[here]
                    scores.append(_score(name, case, truth[here], value[here], ends, groups[here], float(floor.mean())))
        return "\n".join(score_lines(scores, self._zones(), coverage=coverage))

    def _zones(self) -> ZoneScore | None:
        if not self.zones:
            return None
        names = ("records", "away", "right", "off_by_two", "findings")
        sums = {name: sum(getattr(one, name) for one in self.zones) for name in names}
        counts = np.sum([one.counts for one in self.zones], axis=0)
        return replace(self.zones[0], **sums, counts=tuple(tuple(int(n) for n in row) for row in counts))


def parts_by_machine(groups: np.ndarray, folds: int, seed: int) -> np.ndarray:
    """Return the fold of each row."""
    names, place = np.unique(groups, return_inverse=True)
    return (np.random.default_rng(seed).permutation(names.size) % folds)[place]


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("inside")
    asked.add_argument("outside")
    asked.add_argument("--folds", type=int, default=4)
    asked.add_argument("--coverage", type=float, default=0.9)
    asked.add_argument("--seed", type=int, default=0)
    asked.add_argument("--zones", type=int, default=600, help="records whose zones are compared, of each dataset")
    asked.add_argument("--alone", action="store_true", help="each estimator takes its fault for the only one")
    given = asked.parse_args()
    began = time.process_time()
    store = open_store(given.inside)
    responses = UnitResponses(reference_machine(store.recipe), probes_of(store.recipe))
    table = read_table(store, responses=responses)
    beyond = read_table(open_store(given.outside), responses=responses)
    for name, one in (("inside", table), ("outside", beyond)):
        print(f"{name}: {len(one)} records, {len(one.refused)} left out {one.refused[:1]}", flush=True)
    options = {"store": store, "split": None, "coverage": given.coverage, "seed": given.seed, "alone": given.alone}
    within, fold = Gathered(), parts_by_machine(table.groups, given.folds, given.seed)
    for number in range(given.folds):
        model = fit_model(table.part(fold != number), responses, **options)
        within.add(model, table.part(fold == number), zones=given.zones // given.folds)
    print(
        f"\n## Within the training draw, {given.folds} folds by machine\n\n{within.lines(given.coverage)}", flush=True
    )
    model = fit_model(table, responses, **options)
    plain, widened, halves = Gathered(), Gathered(), parts_by_machine(beyond.groups, 2, given.seed)
    plain.add(model, beyond, zones=given.zones)
    print(f"\n## Outside, intervals of the training machines\n\n{plain.lines(given.coverage)}", flush=True)
    for number in range(2):
        calibrate(model, beyond.part(halves != number))
        widened.add(model, beyond.part(halves == number), zones=0)
    print(f"\n## Outside, intervals calibrated on other machines outside\n\n{widened.lines(given.coverage)}")
    print(f"\n{time.process_time() - began:.0f} s of processor")


if __name__ == "__main__":
    main()
