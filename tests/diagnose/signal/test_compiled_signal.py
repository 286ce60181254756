"""The compiled parts of the signal processing on a computer that has no place to keep them."""

from __future__ import annotations

from collections.abc import Callable

import pytest

_SIGNALS = """
import numpy as np
from rotorwise.diagnose.signal.order_map import order_map
from rotorwise.diagnose.signal.speed_track import track_speed
from rotorwise.diagnose.signal.vold_kalman import order_waveforms
angle = np.cumsum(np.linspace(15.0, 25.0, 8000)) / 2000.0
x = sum(np.cos(2 * np.pi * order * angle) for order in (1, 2, 3))
print(track_speed(x, rate_hz=2000.0, lowest_hz=10.0, highest_hz=40.0).speed_hz.sum())
print(np.abs(order_map(x, rate_hz=2000.0, phase_turns=angle, highest_order=4.0).amplitude).sum())
one = order_waveforms(x, rate_hz=2000.0, phase_turns=angle, orders=[1.0, 2.0], bandwidth_hz=1.0)
print(np.abs(one.envelope).sum())
"""


def _numbers(text: str) -> list[float]:
    return [float(line) for line in text.split()]


@pytest.mark.slow
def test_signals_are_looked_at_where_nothing_can_be_kept(
    printed_usually: Callable[[str], str], printed_with_nothing_kept: Callable[[str], str]
) -> None:
    usual = _numbers(printed_usually(_SIGNALS))
    assert _numbers(printed_with_nothing_kept(_SIGNALS)) == usual
    assert all(value > 0 for value in usual)
