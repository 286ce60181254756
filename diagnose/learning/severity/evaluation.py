"""How good severity estimates are on machines that the estimators have not seen: errors, coverage, zones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .model import TOGETHER, SeverityModel, rows_for
from .predicted_zone import CLOSE, disagreement, margin
from .reading import SeverityTable

#: Severities below this many floors (the estimator's `floor`) are weak: their error is no ratio.
_STRONG = 3.0


@dataclass(frozen=True)
class TargetScore:
    """One severity over the records of one case, or of all cases.

    Attributes
    ----------
    target, case : str
        ``"all"`` for every case, ``"with the fault"`` for those where the severity is not zero.
    machines, records : int
    coverage, standard_error : float
        Share of intervals that hold the truth, machines weighing the same; its standard error over machines.
    reaches_zero : float
        Share of intervals that hold zero.
    error_factor, worst_factor : float
        Median and 90 % quantile of estimate over truth or its inverse, of records with three floors or more; NaN
        without one.
    width_factor : float
        Median of upper over lower end for these; a lower end below the floor counts as the floor.
    """

    target: str
    case: str
    machines: int
    records: int
    coverage: float
    standard_error: float
    reaches_zero: float
    error_factor: float
    worst_factor: float
    width_factor: float


@dataclass(frozen=True)
class ZoneScore:
    """Predicted against measured zones.

    Attributes
    ----------
    records, away : int
        All, and those whose measured level is `CLOSE` or more from every limit.
    right : int
        Of those away.
    off_by_two : int
        Of all.
    counts : tuple of tuple of int
        Measured (row) against predicted zone, all records.
    findings : int
        Records with a disagreement to report.
    """

    records: int
    away: int
    right: int
    off_by_two: int
    counts: tuple[tuple[int, ...], ...]
    findings: int


def score_targets(model: SeverityModel, table: SeverityTable) -> list[TargetScore]:
    """Return scores of every severity, for all cases and for each."""
    found = []
    for name, regressor in model.regressors.items():
        part = table.part(rows_for(table, name, alone=model.card["alone"]))
        truth, floor, cases = part.labels[name], float(regressor.floor or 0.0), part.cases
        value, ends = regressor.predict(part.values), regressor.predict_interval(part.values)
        parts = {"all": np.ones(len(part), bool), "with the fault": truth > 0}
        for case, here in {**parts, **{case: cases == case for case in sorted(set(cases))}}.items():
            if not here.any():
                continue
            found.append(_score(name, str(case), truth[here], value[here], ends[here], part.groups[here], floor))
    return found


def _score(
    name: str, case: str, truth: np.ndarray, value: np.ndarray, ends: np.ndarray, groups: np.ndarray, floor: float
) -> TargetScore:
    inside = (ends[:, 0] <= truth) & (truth <= ends[:, 1])
    shares = np.array([inside[groups == group].mean() for group in np.unique(groups)])
    error = float(shares.std(ddof=1) / np.sqrt(shares.size)) if shares.size > 1 else float("nan")
    strong = truth >= _STRONG * floor
    factors = (float("nan"),) * 3
    if strong.any():
        ratio = np.exp(np.abs(np.log(np.maximum(value[strong], 1e-3 * floor) / truth[strong])))
        width = ends[strong, 1] / np.maximum(ends[strong, 0], floor)
        factors = (float(np.median(ratio)), float(np.quantile(ratio, 0.9)), float(np.median(width)))
    zero = float((ends[:, 0] <= 1e-9 * floor).mean())
    return TargetScore(name, case, shares.size, truth.size, float(shares.mean()), error, zero, *factors)


def score_zones(
    model: SeverityModel, table: SeverityTable, *, tell: Callable[[int], None] = lambda _done: None
) -> ZoneScore | None:
    """Return how the predicted zones compare with the measured ones; None where no severity makes shaft lines.

    A model that takes faults one at a time is asked for the one that is there; healthy records count as each.
    """
    ends = {
        name: np.column_stack([one.predict(table.values), one.predict_interval(table.values)])
        for name, one in model.regressors.items()
    }
    counts, away, right, findings = np.zeros((4, 4), int), 0, 0, 0
    for place, (lines, shown) in enumerate(zip(table.lines, table.zones, strict=True)):
        tell(place + 1)
        if shown is None:
            continue
        predicted = model.predict_zones(lines, {name: tuple(values[place]) for name, values in ends.items()})
        if not predicted:
            return None
        for name, zone in predicted.items():
            if name != TOGETHER and not rows_for(table, name, alone=True)[place]:
                continue
            counts["ABCD".index(shown.zone), "ABCD".index(zone.zone)] += 1
            findings += bool(disagreement(zone, shown))
            if margin(shown) >= CLOSE:
                away += 1
                right += zone.zone == shown.zone
    apart = np.abs(np.subtract.outer(np.arange(4), np.arange(4)))
    rows = tuple(tuple(int(one) for one in row) for row in counts)
    return ZoneScore(int(counts.sum()), away, right, int(counts[apart > 1].sum()), rows, findings)
