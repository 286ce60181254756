"""What changed against a healthy record of the same machine, as features; NaN where there is none."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from .fault_names import HEALTHY
from .relative_features import level_names, relative_feature_names

if TYPE_CHECKING:
    from .feature_table import FeatureTable

#: Standard deviation of a level between records of one healthy assembly, dB: as the rules have it (`compare.py`).
REPEATABILITY_DB = 4.0
_COMPARED = (
    "crest_factor",
    "kurtosis",
    "outer_race_depth",
    "inner_race_depth",
    "ball_depth",
    "cage_depth",
    "envelope_shaft_depth",
)
_SAME = ("machine", "group", "speed_rpm", "load")


def change_names() -> tuple[str, ...]:
    """Return the names of the changes, in order."""
    return tuple(f"change.{name}" for name in (*level_names(), *_COMPARED))


def model_feature_names() -> tuple[str, ...]:
    """Return what a classifier of faults looks at: relative features, then changes."""
    return (*relative_feature_names(), *change_names())


def model_features(now: Mapping[str, float], baseline: Mapping[str, float] | None) -> np.ndarray:
    """Return the vector of a recording, shape (features,).

    Parameters
    ----------
    now, baseline : mapping of str to float
        Relative features and levels; None without a healthy record of the machine.
    """
    own = [now[name] for name in relative_feature_names()]
    compared = (*level_names(), *_COMPARED)
    if baseline is None:
        return np.array([*own, *([float("nan")] * len(compared))])
    return np.array([*own, *(now[name] - baseline[name] for name in compared)])


def twins(table: FeatureTable) -> list[np.ndarray]:
    """Return, for each row, the other healthy rows of the same machine at the same speed and load."""
    keys = list(zip(*(table.columns[name] for name in _SAME), strict=True))
    healthy: dict[tuple, list[int]] = {}
    for row in np.flatnonzero(table.labels == HEALTHY):
        healthy.setdefault(keys[row], []).append(int(row))
    return [np.array([one for one in healthy.get(key, []) if one != row], int) for row, key in enumerate(keys)]


def learning_rows(table: FeatureTable, *, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return what a classifier learns from: each row alone, and once more with a healthy record as its baseline.

    Simulated repeats are alike to the last digit where machines are not: a normal error of `REPEATABILITY_DB` goes on
    every level's change.

    Parameters
    ----------
    table : FeatureTable
        With relative features and levels.
    seed : int

    Returns
    -------
    values : array (learning rows, features), as `model_feature_names`
    index : array (learning rows,)
        The table's row of each.
    """
    stream = np.random.default_rng(seed)
    compared = (*level_names(), *_COMPARED)
    own, levels = table.only(relative_feature_names()).values, table.only(compared).values
    alone = np.hstack([own, np.full((len(table), len(compared)), np.nan)])
    pairs = [(row, int(stream.choice(found))) for row, found in enumerate(twins(table)) if found.size]
    if not pairs:
        return alone, np.arange(len(table))
    now, before = np.array(pairs).T
    change = levels[now] - levels[before]
    count = len(level_names())
    change[:, :count] += stream.normal(0.0, REPEATABILITY_DB / 20, (len(now), count))
    return np.vstack([alone, np.hstack([own[now], change])]), np.r_[np.arange(len(table)), now]
