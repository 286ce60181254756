"""A dataset as a table to learn severities from: features, labels, machines, and what is needed to judge zones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....datasets.recipe import MachineRecipe, Recipe
from ....datasets.recipe_values import Choice
from ....datasets.recording import Recording
from ....datasets.simulated import TACHO
from ....datasets.store import Store
from ....simulators.errors import InvalidValueError, RotorwiseError
from ....simulators.machine import Machine
from ...result import Severity
from ...severity import assess
from ..store_rows import channels_of, recording_of, row_groups, rows
from .feature_row import ShaftLines, feature_row, shaft_lines
from .targets import TARGETS
from .unit_responses import UnitResponses, source_features

#: A row, its features, shaft lines, worst zone and labels.
_ReadRow = tuple[Mapping[str, Any], dict[str, float], ShaftLines, Severity | None, dict[str, float]]


@dataclass(frozen=True, eq=False)
class SeverityTable:
    """Rows of a dataset.

    Attributes
    ----------
    names : tuple of str
        Of the features.
    values : ndarray (rows, features)
    labels : mapping of str to ndarray (rows,)
        By target, SI units.
    groups, splits, cases, kinds : ndarray (rows,) of str
        Machine draw, its split, case and kind of machine.
    lines : tuple of ShaftLines
    zones : tuple of Severity or None
        The worst zone that the record shows.
    rates_hz, durations_s : ndarray (rows,)
    refused : tuple of str
        Why rows were left out: too few turns, for example.
    """

    names: tuple[str, ...]
    values: np.ndarray
    labels: dict[str, np.ndarray]
    groups: np.ndarray
    splits: np.ndarray
    cases: np.ndarray
    kinds: np.ndarray
    lines: tuple[ShaftLines, ...]
    zones: tuple[Severity | None, ...]
    rates_hz: np.ndarray
    durations_s: np.ndarray
    refused: tuple[str, ...] = ()

    def __len__(self) -> int:
        return self.values.shape[0]

    def part(self, chosen: np.ndarray) -> SeverityTable:
        """Return some rows, chosen by an array of bool."""
        places = np.flatnonzero(chosen)
        return replace(
            self,
            values=self.values[places],
            labels={name: values[places] for name, values in self.labels.items()},
            groups=self.groups[places],
            splits=self.splits[places],
            cases=self.cases[places],
            kinds=self.kinds[places],
            lines=tuple(self.lines[place] for place in places),
            zones=tuple(self.zones[place] for place in places),
            rates_hz=self.rates_hz[places],
            durations_s=self.durations_s[places],
        )


def reference_machine(recipe: Recipe) -> Machine:
    """Return the machine in the middle of what a recipe draws: every drawn parameter and the load at its middle.

    Raises
    ------
    InvalidValueError
        When the recipe has machines of several kinds or presets.
    """
    kinds = {(one.machine.name, one.machine.preset_name) for one in recipe.machines}
    if len(kinds) > 1:
        raise InvalidValueError(
            f"Recipe {recipe.name} has {', '.join(sorted(name for name, _ in kinds))}; allowed: one kind of machine. "
            "Build a dataset of one kind."
        )
    first = recipe.machines[0]
    found = {name: _middle([one.parameters[name] for one in recipe.machines]) for name in _shared(recipe.machines)}
    load = first.machine.definition.load_parameter
    if load and first.load is not None:
        found[load] = _middle([one.load for one in recipe.machines if one.load is not None])
    return first.machine.with_parameters(**found)


def _shared(machines: Sequence[MachineRecipe]) -> set[str]:
    return set.intersection(*(set(one.parameters) for one in machines))


def _middle(choices: Sequence[Choice]) -> float:
    ends = [end for choice in choices for end in choice.ends()]
    if all(choice.logarithmic for choice in choices):
        return float(np.exp(np.mean(np.log(ends))))
    return float(np.mean(ends))


def probes_of(recipe: Recipe) -> tuple[str, ...]:
    """Return the names of the vibration channels of a dataset."""
    return tuple(name for name in channels_of(recipe) if name != TACHO)


def features_of(
    recording: Recording, probes: Sequence[str], responses: UnitResponses
) -> tuple[dict[str, float], ShaftLines]:
    """Return features and shaft lines of a recording.

    Raises
    ------
    InvalidValueError
        See `shaft_lines`.
    """
    lines = shaft_lines(recording, probes=probes)
    values = feature_row(recording, lines)
    values |= source_features(responses, lines)
    return values, lines


def _read(
    store: Store, names: Sequence[str], responses: UnitResponses, tell: Callable[[int], None]
) -> tuple[list[_ReadRow], list[str]]:
    """Return what is read of each row, and why others are refused."""
    channels, found, refused = channels_of(store.recipe), [], []
    for piece in row_groups(store):
        for row in rows(store, piece):
            recording = recording_of(row, channels)
            try:
                values, lines = features_of(recording, responses.probes, responses)
            except RotorwiseError as problem:
                refused.append(str(problem))
                continue
            shown, _ = assess(recording, speed_rpm=lines.speed_rpm)
            labels = {target.name: row[target.label] or 0.0 for target in TARGETS if target.name in names}
            found.append((row, values, lines, shown[0] if shown else None, labels))
            tell(len(found))
    return found, refused


def read_table(
    store: Store,
    *,
    responses: UnitResponses | None = None,
    tell: Callable[[int], None] = lambda _done: None,
) -> SeverityTable:
    """Return all rows of a dataset; signals are read one row group at a time.

    Parameters
    ----------
    store : Store
    responses : UnitResponses, optional
        Of a model, to apply it to this dataset; those of the recipe's own middle machine when left out.
    tell : callable
        Called with the number of rows done.

    Raises
    ------
    InvalidValueError
        When the dataset holds no severity that can be estimated, or no rows.
    """
    names = [target.name for target in TARGETS if target.label.removeprefix("severity.") in store.recipe.severity]
    if not names:
        raise InvalidValueError(
            f"{store.folder.name} has no label of {', '.join(target.label for target in TARGETS)}. Use a dataset of "
            "a recipe with such a [severity], for example severity_amb_rotor."
        )
    responses = responses or UnitResponses(reference_machine(store.recipe), probes_of(store.recipe))
    found, refused = _read(store, names, responses, tell)
    if not found and refused:
        raise InvalidValueError(
            f"None of the {len(refused)} signals of {store.folder.name} can be used; the first: {refused[0]} Give a "
            "dataset of one machine with severities."
        )
    if not found:
        raise InvalidValueError(
            f"{store.folder.name} holds no signals yet. Go on building it (rotorwise dataset build)."
        )
    columns = tuple(found[0][1])
    return SeverityTable(
        names=columns,
        values=np.array([[values[name] for name in columns] for _, values, *_ in found]),
        labels={name: np.array([labels[name] for *_, labels in found]) for name in names},
        groups=np.array([row["group"] for row, *_ in found]),
        splits=np.array([row["split"] for row, *_ in found]),
        cases=np.array([row["case"] for row, *_ in found]),
        kinds=np.array([row["machine"] for row, *_ in found]),
        lines=tuple(lines for _, _, lines, *_ in found),
        zones=tuple(zone for *_, zone, _ in found),
        rates_hz=np.array([row["rate_hz"] for row, *_ in found]),
        durations_s=np.array([row["samples"] / row["rate_hz"] for row, *_ in found]),
        refused=tuple(refused),
    )
