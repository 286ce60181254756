"""Faults that the simulated record itself does not show: they are taught as "healthy", that is, nothing evident.

A record shows its fault when one of the fault's own features lies further above the healthy records of the same
machine, speed and load than 99 % of healthy records lie above each other (shared among the fault's features).
Nobody could name what is less than that, and a classifier that is taught to would name noise.
"""

from __future__ import annotations

import numpy as np

from .changes import twins
from .fault_names import HEALTHY
from .feature_table import FeatureTable

#: Share of healthy records that would pass for faulty.
FALSE_EVIDENCE = 0.01
_SHAFT = ("1x_level", "2x_level", "3x_level", "1x_contrast", "2x_contrast", "3x_contrast")
_LOOSE = (*_SHAFT, "third_x_level", "half_x_level", "1.5x_level", "2.5x_level", "half_x_contrast", "1.5x_contrast")
_GEAR = ("gear_fm4", "gear_na4", "mesh_modulation_index")
#: Features in which a fault shows itself.
OWN_FEATURES = {
    "unbalance": ("1x_level", "1x_contrast"),
    "misalignment": _SHAFT,
    "bent_shaft": _SHAFT,
    "looseness": _LOOSE,
    "rub": _LOOSE,
    "oil_whirl": (*_LOOSE, "sub_synchronous_share"),
    "bearing_outer_race": ("outer_race_depth", "outer_race_contrast"),
    "bearing_inner_race": ("inner_race_depth", "inner_race_contrast"),
    "bearing_ball": ("ball_depth", "ball_contrast", "cage_depth", "cage_contrast"),
    "bearing_cage": ("cage_depth", "cage_contrast"),
    "gear_wear": _GEAR,
    "gear_tooth_fault": _GEAR,
    "gear_eccentricity": _GEAR,
}


def evident(table: FeatureTable) -> np.ndarray:
    """Return whether each row shows its fault, shape (rows,); healthy rows and rows without a healthy twin count as so.

    Parameters
    ----------
    table : FeatureTable
        With relative features and levels.
    """
    pairs = twins(table)
    excess = np.full(table.values.shape, np.nan)
    for row, found in enumerate(pairs):
        if found.size:
            excess[row] = table.values[row] - np.max(table.values[found], axis=0)
    shown = np.ones(len(table), bool)
    for fault in np.unique(table.labels):
        own = [table.names.index(name) for name in OWN_FEATURES.get(str(fault), ()) if name in table.names]
        if fault == HEALTHY or not own:
            continue
        limits = [_limit(excess[table.labels == HEALTHY, feature], len(own)) for feature in own]
        rows = np.flatnonzero(table.labels == fault)
        shown[rows] = np.nan_to_num(excess[rows][:, own] - limits, nan=-1.0).max(axis=1) > 0
        shown[rows] |= np.array([pairs[row].size == 0 for row in rows])
    return shown


def _limit(healthy: np.ndarray, features: int) -> float:
    known = healthy[np.isfinite(healthy)]
    return float(np.quantile(known, 1 - FALSE_EVIDENCE / features)) if known.size else np.inf


def taught(table: FeatureTable) -> np.ndarray:
    """Return the labels to learn: those of the table, "healthy" where the fault does not show."""
    return np.where(evident(table), table.labels, HEALTHY)
