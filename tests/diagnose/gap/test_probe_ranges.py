"""Ranges of probes: at least what was recorded, and in the proportion of the hum that they show."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.probe_ranges import in_proportion

LARGEST = np.array([1.0, 2.0, 4.0])
HUM = LineKind(phase=False, frequency_hz=50.0)


def _lines(sizes, *, kind=HUM) -> OrderLines:
    amplitudes = np.zeros((2, 3, 2), dtype=complex)
    amplitudes[..., 0] = 1.0
    amplitudes[:, :, 1] = sizes
    conditions = (Condition(600.0), Condition(900.0))
    kinds = (LineKind(), kind)
    return OrderLines(conditions, ("a", "b", "c"), (1.0, 0.0), amplitudes, np.full((2, 3, 2), 0.01), kinds)


def test_one_share_of_the_range_tells_the_hum_of_all_probes():
    sizes = np.array([0.3, 0.3, 0.5])
    found = in_proportion(LARGEST, _lines(sizes))
    assert sizes / found == pytest.approx(np.full(3, sizes[2] / LARGEST[2]))
    assert (found >= LARGEST).all()


def test_a_probe_without_hum_makes_little_of_it():
    found = in_proportion(LARGEST, _lines((0.3, 0.001, 0.5)))
    assert found[1] == pytest.approx(0.001 / (0.5 / 4.0))


def test_without_hum_ranges_are_what_was_recorded():
    assert (in_proportion(LARGEST, _lines((0.01, 0.0, 0.02))) == LARGEST).all()
    beside_order = LineKind(phase=False, envelope=True, frequency_hz=50.0)
    assert (in_proportion(LARGEST, _lines((0.5, 0.5, 0.5), kind=beside_order)) == LARGEST).all()
