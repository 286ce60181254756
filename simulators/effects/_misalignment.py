"""What is declared of every misalignment of a coupling: its offset, its tilt and where they point."""

from __future__ import annotations

import math
from typing import Any

from ..parameter import LogNormal, Uniform, parameter

ALIGNMENT = "What did the last laser alignment show, cold and hot? Were feet, shims or pipes changed since?"


def offset(meaning: str) -> Any:
    """Declare a parallel misalignment, m."""
    return parameter(
        unit="m",
        bounds=(0.0, 2e-3),
        zero=0.0,
        prior=LogNormal(1e-4, 3.0),
        meaning=meaning,
        source="Prueftechnik tolerances: 0.03-0.09 mm at 1500-3000 rpm; factor 3 for careful or careless work",
    )


def tilt() -> Any:
    """Declare an angular misalignment, rad."""
    return parameter(
        unit="rad",
        bounds=(0.0, 0.07),
        zero=0.0,
        prior=LogNormal(1e-3, 3.0),
        meaning="angular misalignment, the angle between the two axes; 0 for a purely parallel one",
        source="Prueftechnik tolerances: 0.4-1.2 mrad at 1500-3000 rpm; bound 4 degrees, where flexible couplings end",
    )


def direction(meaning: str) -> Any:
    """Declare where an offset or the axis of a tilt points, rad."""
    return parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning=meaning,
        source="any angle is equally likely",
    )
