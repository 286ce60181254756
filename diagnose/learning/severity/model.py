"""Severity estimators of one machine: training from a dataset, estimates for a recording, refusals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....datasets.recording import Recording
from ....datasets.store import Store
from ....simulators.errors import InvalidValueError
from ....simulators.machine import Machine, machine_from_toml
from ...result import Severity
from ...severity import assess
from .conformal import ConformalRegressor
from .feature_row import ShaftLines
from .nameplate import of_machine
from .predicted_zone import PredictedZone, disagreement, predicted_zone
from .reading import SeverityTable, features_of, probes_of, read_table, reference_machine
from .targets import TARGETS, target_named
from .unit_responses import UnitResponses

#: Key of the zone that all estimates lead to together.
TOGETHER = "together"
#: A speed may be so far outside the training range, relative: what is read from a tacho is no sharper.
_SPEED_MARGIN = 0.005
#: A record must have this share of the shortest training record's length and of its sampling rate.
_LENGTH_SHARE, _RATE_SHARE = 0.8, 0.999


@dataclass(frozen=True)
class Estimate:
    """One severity of a record.

    Attributes
    ----------
    target, unit : str
    value, low, high : float
        In ``unit``: the estimate and its interval.
    reaches_zero : bool
        Whether the record could come from a machine without this fault.
    beyond : bool
        Whether the interval reaches the largest severity of the training: the true one may be larger than ``high``.
    """

    target: str
    unit: str
    value: float
    low: float
    high: float
    reaches_zero: bool
    beyond: bool


@dataclass(frozen=True)
class SeverityAnswer:
    """What a model says of a recording.

    Attributes
    ----------
    estimates : tuple of Estimate
    speed_rpm : float
    predicted : mapping of str to PredictedZone
        Zones that the simulator predicts for the estimates: of all `TOGETHER`, or of each severity that makes shaft
        lines if the model takes faults one at a time.
    shown : Severity or None
        Worst zone that the record shows; ``refusal`` says why there is none.
    disagreement : str
        A finding: empty where a predicted zone agrees with the measured one.
    refusal : str
    remarks : tuple of str
    """

    estimates: tuple[Estimate, ...]
    speed_rpm: float
    predicted: dict[str, PredictedZone]
    shown: Severity | None
    disagreement: str
    refusal: str
    remarks: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class SeverityModel:
    """Estimators of a machine's severities.

    Attributes
    ----------
    regressors : mapping of str to ConformalRegressor
        By target.
    features : tuple of str
    card : dict
        JSON types only; see `train`.
    responses : UnitResponses
    remarks : tuple of str
    """

    regressors: dict[str, ConformalRegressor]
    features: tuple[str, ...]
    card: dict[str, Any]
    responses: UnitResponses
    remarks: tuple[str, ...] = ()

    def estimate(self, recording: Recording) -> SeverityAnswer:
        """Return severities with intervals, the zone they lead to and the zone that the record shows.

        Raises
        ------
        InvalidValueError
            For a record outside the training range: missing probes, other quantities, rate, length or speed.
        """
        card = self.card
        _check_record(recording, card)
        values, lines = features_of(recording, card["probes"], self.responses)
        _check_speed(lines.speed_rpm, card)
        missing = [name for name in self.features if name not in values]
        if missing:
            raise InvalidValueError(
                f"The recording gives no {missing[0]}, which the model needs ({len(missing)} of {len(self.features)} "
                "features missing). Give bearings (--bearing) and a sampling rate as in the training."
            )
        row = np.array([[values[name] for name in self.features]])
        found = {name: self._estimate(name, row) for name in self.regressors}
        shown, refusal = assess(of_machine(recording, self.responses.machine), speed_rpm=lines.speed_rpm)
        predicted = self.predict_zones(lines, {name: tuple(ends) for name, ends in found.items()})
        worst = shown[0] if shown else None
        doubts = [disagreement(one, worst) for one in predicted.values()] if worst else []
        return SeverityAnswer(
            tuple(_shown(name, ends, card["largest"][name]) for name, ends in found.items()),
            lines.speed_rpm,
            predicted,
            worst,
            doubts[0] if doubts and all(doubts) else "",
            refusal,
            (*self.remarks, *_unlike(values, card)),
        )

    def predict_zones(self, lines: ShaftLines, ends: Mapping[str, Sequence[float]]) -> dict[str, PredictedZone]:
        """Return the zones of (estimate, low, high) by target; empty where none of them makes shaft lines."""
        sources = {name: source for name in ends if (source := target_named(name).source) is not None}
        if not sources:
            return {}
        cases = {name: [name] for name in sources} if self.card["alone"] else {TOGETHER: list(sources)}
        found = {}
        for key, acting in cases.items():
            middle, low, high = (
                {source: ends[name][i] if name in acting else 0.0 for name, source in sources.items()} for i in range(3)
            )
            found[key] = predicted_zone(self.responses, lines, middle, low=low, high=high)
        return found

    def _estimate(self, name: str, row: np.ndarray) -> np.ndarray:
        regressor = self.regressors[name]
        return np.array([regressor.predict(row)[0], *regressor.predict_interval(row)[0]])


def train(
    store: Store,
    *,
    split: str | None = "train",
    coverage: float = 0.9,
    seed: int = 0,
    alone: bool = False,
    table: SeverityTable | None = None,
) -> SeverityModel:
    """Return the estimators of the machine of a dataset.

    Parameters
    ----------
    store : Store
    split : str or None
        Of the dataset; None for all of it.
    coverage : float
        Of the intervals, over machines.
    seed : int
    alone : bool
        Each estimator takes its fault for the only one: it learns from records of this fault and healthy ones. For
        faults that one record cannot tell apart, such as unbalance and misalignment that both make 1X only.
    table : SeverityTable, optional
        Of this dataset, if it has been read already.

    Raises
    ------
    InvalidValueError
        For a dataset without such severities, several kinds of machine, or too few machines for the coverage.
    """
    machine, probes = reference_machine(store.recipe), probes_of(store.recipe)
    responses = UnitResponses(machine, probes)
    table = read_table(store, responses=responses) if table is None else table
    used = np.ones(len(table), bool) if split is None else table.splits == split
    if not used.any():
        raise InvalidValueError(
            f"{store.folder.name} has no rows of split {split!r}; allowed: {', '.join(sorted(set(table.splits)))}. "
            "Correct it."
        )
    return fit_model(table.part(used), responses, store=store, split=split, coverage=coverage, seed=seed, alone=alone)


def fit_model(
    part: SeverityTable,
    responses: UnitResponses,
    *,
    store: Store,
    split: str | None,
    coverage: float,
    seed: int,
    alone: bool = False,
) -> SeverityModel:
    """Return the estimators fitted to a table; parameters as in `train`."""
    machines = np.unique(part.groups).size
    fewest = int(np.ceil(coverage / (1 - coverage) - 1e-9))
    if machines < fewest:
        raise InvalidValueError(
            f"{machines} machines for intervals of {100 * coverage:g} %; allowed: {fewest} or more. Build more of the "
            "dataset, or ask for a lower coverage (--coverage)."
        )
    regressors = {}
    for name, labels in part.labels.items():
        if not (labels > 0).any():
            continue
        regressor = ConformalRegressor(
            coverage=coverage, floor=2 * float(labels[labels > 0].min()), least=0.0, seed=seed
        )
        here = rows_for(part, name, alone=alone)
        regressors[name] = regressor.fit(part.values[here], labels[here], part.groups[here], labels[here] > 0)
    card = {**_card(part, responses, store, split, coverage, seed), "alone": alone}
    return SeverityModel(regressors, part.names, card, responses)


def rows_for(table: SeverityTable, name: str, *, alone: bool) -> np.ndarray:
    """Return which rows an estimator is for: all, or those without any other severity."""
    others = [labels > 0 for other, labels in table.labels.items() if other != name]
    return ~np.any(others, axis=0) if alone and others else np.ones(len(table), bool)


def calibrate(model: SeverityModel, table: SeverityTable) -> None:
    """Take the intervals from other machines, such as machines further from the preset; the values stay."""
    for name, regressor in model.regressors.items():
        part = table.part(rows_for(table, name, alone=model.card["alone"]))
        regressor.calibrate(part.values, part.labels[name], part.groups, part.labels[name] > 0)
    model.card["calibration"] = f"{np.unique(table.groups).size} machines: {', '.join(sorted(set(table.kinds)))}"


def _card(
    part: SeverityTable, responses: UnitResponses, store: Store, split: str | None, coverage: float, seed: int
) -> dict[str, Any]:
    from .model_file import model_versions

    recipe = store.recipe
    speeds = [lines.speed_rpm for lines in part.lines]
    misfit = part.values[:, part.names.index("offset+angle+unbalance.misfit")]
    quantity = {one: _quantity(responses.machine, one) for one in responses.probes}
    return {
        "recipe": recipe.name,
        "fingerprint": recipe.fingerprint,
        "recipe_seed": recipe.seed,
        "split": split,
        "machines": int(np.unique(part.groups).size),
        "records": len(part),
        "cases": sorted({str(case) for case in part.cases}),
        "limits": list(recipe.limits),
        "machine": responses.machine.to_toml(),
        "probes": list(responses.probes),
        "quantities": quantity,
        "speed_rpm": [float(min(speeds)), float(max(speeds))],
        "rate_hz": float(part.rates_hz.min()),
        "duration_s": float(part.durations_s.min()),
        "largest_misfit": float(misfit.max()),
        "largest": {name: float(labels.max()) for name, labels in part.labels.items()},
        "smallest": {name: float(labels[labels > 0].min()) for name, labels in part.labels.items() if labels.any()},
        "coverage": coverage,
        "calibration": "folds of the training machines",
        "seed": seed,
        "versions": model_versions(),
    }


def _quantity(machine: Machine, probe: str) -> str:
    unit = next(one.unit for one in machine.assembly(speed_rpm=1000.0).probes if one.name == probe)
    return {"m": "displacement", "m/s": "velocity", "m/s2": "acceleration"}[unit]


def responses_of(card: dict[str, Any]) -> UnitResponses:
    """Return the responses of a card's machine."""
    return UnitResponses(machine_from_toml(card["machine"]), card["probes"])


def _check_record(recording: Recording, card: dict[str, Any]) -> None:
    there = {channel.name: channel.quantity for channel in recording.channels}
    missing = [name for name in card["probes"] if name not in there]
    if missing:
        raise InvalidValueError(
            f"No channel {missing[0]!r} in the recording, which has {', '.join(there)}; the model needs "
            f"{', '.join(card['probes'])}. Name the channels so (--channel-name), or use a model of this machine."
        )
    wrong = [name for name in card["probes"] if there[name] != card["quantities"][name]]
    if wrong:
        raise InvalidValueError(
            f"Channel {wrong[0]} measures {there[wrong[0]] or 'something of unknown unit'}; the model needs "
            f"{card['quantities'][wrong[0]]}. Pass --unit or --sensitivity, or use another model."
        )
    for name in card["probes"]:
        lost = int((~np.isfinite(recording.signals[list(there).index(name)])).sum())
        if lost:
            raise InvalidValueError(
                f"Channel {name} lacks {lost} of {recording.samples} samples; the model needs all. Cut the gap out, or "
                "record again."
            )
    for what, value, needed, unit in (
        ("Sampling rate", recording.rate_hz, _RATE_SHARE * card["rate_hz"], "Hz"),
        ("Length", recording.duration_s, _LENGTH_SHARE * card["duration_s"], "s"),
    ):
        if value < needed:
            raise InvalidValueError(
                f"{what} {value:g} {unit}; the model needs {needed:.4g} {unit} or more, as in training. Record again."
            )


def _check_speed(speed_rpm: float, card: dict[str, Any]) -> None:
    low, high = card["speed_rpm"]
    if not low * (1 - _SPEED_MARGIN) <= speed_rpm <= high * (1 + _SPEED_MARGIN):
        raise InvalidValueError(
            f"Speed {speed_rpm:.4g} rpm; the model was trained from {low:.4g} to {high:.4g} rpm. Record "
            "within that range, or train a model for this speed."
        )


def _unlike(values: dict[str, float], card: dict[str, Any]) -> tuple[str, ...]:
    if values["offset+angle+unbalance.misfit"] <= card["largest_misfit"]:
        return ()
    return (
        "No unbalance and misalignment of the simulated machine makes lines like these: the estimates are doubtful. "
        "Compare with rotorwise gap.",
    )


def _shown(name: str, ends: Sequence[float] | np.ndarray, largest: float) -> Estimate:
    target = target_named(name)
    value, low, high = (target.per_si * float(one) for one in ends)
    zero = low <= 1e-9 * target.per_si * largest
    return Estimate(name, target.unit, value, low, high, bool(zero), bool(ends[2] >= largest))


__all__ = [
    "TARGETS",
    "TOGETHER",
    "Estimate",
    "SeverityAnswer",
    "SeverityModel",
    "calibrate",
    "fit_model",
    "responses_of",
    "rows_for",
    "train",
]
