"""The severities that can be estimated: label in datasets, unit to show, and the source of shaft lines behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Target:
    """A severity.

    Attributes
    ----------
    name : str
    label : str
        Column of a dataset, in SI units.
    unit : str
        Shown to people.
    per_si : float
        Shown value for one SI unit.
    source : str or None
        Which source of `unit_responses.SOURCES` it is; None for one that makes no shaft lines.
    """

    name: str
    label: str
    unit: str
    per_si: float
    source: str | None


TARGETS = (
    Target("parallel offset", "severity.misalignment_offset_m", "mm", 1e3, "offset"),
    Target("angular misalignment", "severity.misalignment_angle_rad", "deg", 180.0 / math.pi, "angle"),
    Target("unbalance", "severity.unbalance_kg_m", "g.mm", 1e6, "unbalance"),
    Target("pit length", "severity.pit_m", "mm", 1e3, None),
)


def target_named(name: str) -> Target:
    """Return a severity by name."""
    return next(target for target in TARGETS if target.name == name)
