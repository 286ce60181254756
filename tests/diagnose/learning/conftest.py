"""A table of features as a simulation might give it: what is in it is known."""

from __future__ import annotations

import numpy as np
import pytest
from rotorwise.diagnose.learning.changes import level_names
from rotorwise.diagnose.learning.feature_table import FeatureTable
from rotorwise.diagnose.learning.relative_features import relative_feature_names

FAULTS = ("healthy", "bearing_outer_race", "unbalance")


def made_table(*, draws: int = 12, seed: int = 0, size: float = 1.0) -> FeatureTable:
    """Return rows of three states: each fault moves features of its own by ``size``, machines move all."""
    stream = np.random.default_rng(seed)
    names = (*relative_feature_names(), *level_names(), "rules.bearing_outer_race")
    place = {name: index for index, name in enumerate(names)}
    values, labels, columns = [], [], {key: [] for key in ("group", "speed_rpm", "severity.spall_m")}
    for draw in range(draws):
        machine = stream.normal(0.0, 0.3, len(names))
        for speed in (1000.0, 2000.0):
            for fault in FAULTS:
                for _ in range(4):
                    row = machine + stream.normal(0.0, 0.05, len(names))
                    share = stream.uniform(0.5, 1.5)
                    # Now and then the rules see what is not there.
                    row[place["rules.bearing_outer_race"]] = 0.3 if stream.uniform() < 0.1 else 0.05
                    if fault == "bearing_outer_race":
                        row[place["outer_race_depth"]] += 2.0 * size * share
                        row[place["outer_race_contrast"]] += 2.0 * size * share
                        row[place["rules.bearing_outer_race"]] = min(0.9 * size, 0.9)
                    if fault == "unbalance":
                        row[place["1x_level"]] += 3.0 * size * share
                    values.append(row)
                    labels.append(fault)
                    columns["group"].append(f"m-{draw}")
                    columns["speed_rpm"].append(speed)
                    columns["severity.spall_m"].append(share if fault == "bearing_outer_race" else 0.0)
    count = len(labels)
    split = np.where(np.array([int(one[2:]) for one in columns["group"]]) < 0.7 * draws, "train", "test")
    return FeatureTable(
        np.array(values),
        names,
        np.array(labels),
        {
            **{key: np.array(column) for key, column in columns.items()},
            "machine": np.repeat("m", count),
            "case": np.array(labels),
            "split": split,
            "load": np.full(count, 1.0),
            "signal": np.arange(count),
        },
    )


@pytest.fixture(scope="session")
def table() -> FeatureTable:
    return made_table()
