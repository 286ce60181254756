"""What is learned from: twins of the same machine only, faults that show, machines never on both sides."""

from __future__ import annotations

import numpy as np
from rotorwise.diagnose.learning.changes import (
    REPEATABILITY_DB,
    learning_rows,
    level_names,
    model_feature_names,
    model_features,
    twins,
)
from rotorwise.diagnose.learning.fault_names import FAULT_OF_EFFECT, IMPERFECTIONS, fault_of
from rotorwise.diagnose.learning.learning_set import LEAST_MACHINES, learnable, learning_set
from rotorwise.diagnose.learning.not_evident import FALSE_EVIDENCE, evident, taught
from rotorwise.diagnose.learning.relative_features import relative_feature_names
from rotorwise.diagnose.result import FAULTS
from rotorwise.simulators.effect import effect_catalogue

from .conftest import made_table


def test_twins_are_other_healthy_records_of_the_same_machine_speed_and_load(table) -> None:
    for row, found in enumerate(twins(table)):
        assert row not in found
        assert found.size == (3 if table.labels[row] == "healthy" else 4)
        for name in ("group", "speed_rpm", "load"):
            assert np.all(table.columns[name][found] == table.columns[name][row])
        assert np.all(table.labels[found] == "healthy")


def test_changes_are_those_of_the_fault_and_scatter_as_stated(table) -> None:
    values, index = learning_rows(table, seed=1)
    count = len(table)
    assert np.array_equal(index[:count], np.arange(count))
    change = values[:, model_feature_names().index("change.1x_level")]
    assert np.isnan(change[:count]).all()
    labels = table.labels[index]
    second = np.arange(len(index)) >= count
    for fault, mean in (("healthy", 0.0), ("bearing_outer_race", 0.0), ("unbalance", 3.0)):
        rows = change[second & (labels == fault)]
        spread = np.hypot(REPEATABILITY_DB / 20, np.sqrt(2) * 0.05)
        spread = np.hypot(spread, 3.0 / np.sqrt(12) if fault == "unbalance" else 0.0)
        assert abs(rows.mean() - mean) < 4 * spread / np.sqrt(rows.size)
        assert abs(rows.std() / spread - 1) < 4 / np.sqrt(2 * rows.size)


def test_a_fault_without_any_effect_is_taught_as_healthy_and_a_clear_one_is_not(table) -> None:
    shown = evident(table)
    assert shown[table.labels != "unbalance"].all()
    assert shown[table.labels == "unbalance"].all()
    nothing = made_table(size=0.0, draws=30)
    rows = nothing.labels != "healthy"
    share = evident(nothing)[rows].mean()
    # The same as healthy ones: what passes is the stated share, counted within four standard deviations.
    assert share < FALSE_EVIDENCE + 4 * np.sqrt(FALSE_EVIDENCE / rows.sum()) + 0.01
    assert np.mean(taught(nothing)[rows] == "healthy") == 1 - share


def test_a_fault_of_too_few_machines_is_not_taught() -> None:
    table = made_table(draws=LEAST_MACHINES + 1)
    rows = learning_set(table, seed=0)
    assert set(learnable(rows).labels) == {"healthy", "bearing_outer_race", "unbalance"}
    few = rows.where((rows.labels != "unbalance") | np.isin(rows.columns["group"], ["m-0", "m-1"]))
    assert "unbalance" not in learnable(few).labels


def test_vectors_of_a_recording_have_the_order_of_the_table(table) -> None:
    now = dict(zip(table.names, table.values[0], strict=True))
    before = dict(zip(table.names, table.values[1], strict=True))
    alone, both = model_features(now, None), model_features(now, before)
    assert alone.shape == both.shape == (len(model_feature_names()),)
    assert np.array_equal(alone[: len(relative_feature_names())], table.values[0, : len(relative_feature_names())])
    place = model_feature_names().index(f"change.{level_names()[3]}")
    assert np.isnan(alone[place])
    assert both[place] == now[level_names()[3]] - before[level_names()[3]]


def test_every_effect_with_a_name_exists_and_every_name_is_a_fault() -> None:
    known = effect_catalogue()
    assert set(FAULT_OF_EFFECT) | set(IMPERFECTIONS) <= set(known)
    assert set(FAULT_OF_EFFECT.values()) <= set(FAULTS)
    assert not set(FAULT_OF_EFFECT) & set(IMPERFECTIONS)
    assert fault_of(["unbalance", "outer_race_defect", "gravity"]) == "bearing_outer_race + unbalance"
