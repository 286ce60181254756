"""Which two channels look at the shaft at right angles, so that their signals make an orbit."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..datasets.recording import Channel

_X_BEFORE_Y = (("horizontal", "vertical"), ("x", "y"))
_UNTOLD = (None, "radial")


def probe_pair(channels: Sequence[Channel]) -> tuple[int, int] | None:
    """Return the places of an x and a y probe among the channels; None where no two are known to be at right angles.

    Displacement only: what a housing does is no orbit of the shaft. Where directions are stated they decide, one
    horizontal and one vertical, or x and y, at one place; two channels of one place that are radial at most count as a
    pair in their order.
    """
    probes = [index for index, channel in enumerate(channels) if channel.quantity == "displacement"]
    for first, second in combinations(probes, 2):
        one, other = channels[first], channels[second]
        if one.location != other.location:
            continue
        ways = (one.direction, other.direction)
        if ways in _X_BEFORE_Y or (one.direction in _UNTOLD and other.direction in _UNTOLD):
            return first, second
        if ways[::-1] in _X_BEFORE_Y:
            return second, first
    return None
