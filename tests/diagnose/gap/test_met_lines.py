"""Orders that meet a line at a fixed frequency: hum keeps its size, its phase against the shaft is any."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.met_lines import with_met_lines

HUM = 0.4
#: 3X lies at 50.05 Hz in the third condition; the records are 8 s long, a main lobe is a quarter of a Hz wide.
SPEEDS_RPM = (600.0, 800.0, 1001.0, 1400.0)
KINDS = (LineKind(), LineKind(), LineKind(phase=False, frequency_hz=50.0))


def _lines(sizes=(HUM, HUM, 0.0, HUM)) -> OrderLines:
    amplitudes = np.full((4, 2, 3), 1.0 + 0j)
    amplitudes[:, 0, 2] = sizes
    amplitudes[:, 1, 2] = 0.0
    deviations = np.full(amplitudes.shape, 0.01)
    deviations[2, :, 2] = np.inf
    conditions = tuple(Condition(speed) for speed in SPEEDS_RPM)
    return OrderLines(conditions, ("one", "two"), (1.0, 3.0, 0.0), amplitudes, deviations, KINDS)


def test_the_order_that_meets_hum_is_as_uncertain_as_the_hum_is_large():
    lines = _lines()
    found = with_met_lines(lines, (8.0,) * 4).deviations
    changed = found != lines.deviations
    # 3X of the third condition, at the probe that shows hum, and nothing else.
    assert np.argwhere(changed).tolist() == [[2, 0, 1]]
    assert found[2, 0, 1] == pytest.approx(np.hypot(0.01, HUM))


def test_a_record_long_enough_tells_the_two_apart():
    lines = _lines()
    assert (with_met_lines(lines, (80.0,) * 4).deviations == lines.deviations).all()


def test_a_line_that_few_records_show_is_no_hum():
    lines = _lines((HUM, 0.0, 0.0, 0.0))
    assert (with_met_lines(lines, (8.0,) * 4).deviations == lines.deviations).all()


def test_one_record_alone_says_nothing_of_its_hum():
    lines = _lines().select([2])
    assert (with_met_lines(lines, (8.0,)).deviations == lines.deviations).all()


def test_a_line_beside_an_order_that_meets_hum_is_as_uncertain():
    # 2X + 16.68 Hz lies at 50.05 Hz in the third condition.
    kinds = (LineKind(), LineKind(phase=False, frequency_hz=16.68), LineKind(phase=False, frequency_hz=50.0))
    lines = replace(_lines(), orders=(1.0, 2.0, 0.0), kinds=kinds)
    found = with_met_lines(lines, (8.0,) * 4).deviations
    assert np.argwhere(found != lines.deviations).tolist() == [[2, 0, 1]]
    assert found[2, 0, 1] == pytest.approx(np.hypot(0.01, HUM))
