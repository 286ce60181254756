"""What a classifier learns from: features, what is taught, what is true, and what is known of each row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .changes import learning_rows
from .fault_names import HEALTHY
from .feature_table import FeatureTable
from .not_evident import evident

#: A fault that fewer machine draws show is not taught.
LEAST_MACHINES = 3


@dataclass(frozen=True, eq=False)
class LearningSet:
    """Rows as a classifier takes them: each recording alone, and once more against a healthy one of its machine.

    Attributes
    ----------
    values : array (rows, features)
    labels : array (rows,)
        What is taught: "healthy" where the fault does not show.
    truth : array (rows,)
        What was simulated; "not evident" where it does not show.
    with_baseline : array (rows,)
    index : array (rows,)
        Row of the table.
    columns : dict of array (rows,)
        Labels of the table.
    """

    values: np.ndarray
    labels: np.ndarray
    truth: np.ndarray
    with_baseline: np.ndarray
    index: np.ndarray
    columns: Mapping[str, np.ndarray]

    def where(self, mask: np.ndarray) -> LearningSet:
        """Return the rows that a mask chooses."""
        columns = {name: column[mask] for name, column in self.columns.items()}
        return LearningSet(
            self.values[mask],
            self.labels[mask],
            self.truth[mask],
            self.with_baseline[mask],
            self.index[mask],
            columns,
        )

    @property
    def groups(self) -> np.ndarray:
        """Machine draw of each row, over all kinds of machines."""
        return np.char.add(np.char.add(self.columns["machine"].astype(str), "/"), self.columns["group"].astype(str))


def learning_set(table: FeatureTable, *, seed: int) -> LearningSet:
    """Return what a classifier learns from, and what it is judged on."""
    values, index = learning_rows(table, seed=seed)
    shown = evident(table)
    labels = np.where(shown, table.labels, HEALTHY)[index]
    truth = np.where(shown, table.labels, "not evident")[index]
    second = np.arange(len(index)) >= len(table)
    columns = {name: column[index] for name, column in table.columns.items()}
    return LearningSet(values, labels, truth, second, index, columns)


def learnable(rows: LearningSet) -> LearningSet:
    """Return the rows whose class shows on `LEAST_MACHINES` machines or more; nothing general is learned from fewer."""
    counts = {one: np.unique(rows.groups[rows.labels == one]).size for one in np.unique(rows.labels)}
    return rows.where(np.array([counts[one] >= LEAST_MACHINES for one in rows.labels], dtype=bool))
