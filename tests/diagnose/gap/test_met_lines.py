"""Orders that meet a line at a fixed frequency, and lines there that are no more than an order that passes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, Recording
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.met_lines import with_made_lines, with_met_lines, with_own_lines

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


def test_what_the_machine_makes_at_a_frequency_is_doubted_and_its_orders_are_not():
    lines = _lines()
    made = np.full(lines.amplitudes.shape, 0.3)
    found = with_made_lines(lines, made, 0.0 * made).deviations
    assert found[0, :, 2] == pytest.approx(math.hypot(0.01, 0.3))
    assert (found[:, :, :2] == lines.deviations[:, :, :2]).all()


def test_a_line_that_the_healthy_machine_makes_at_that_frequency_is_not_doubted():
    lines = _lines()
    made = np.full(lines.amplitudes.shape, 0.3)
    assert (with_made_lines(lines, made, made[:3]).deviations == lines.deviations).all()


def _recorded(speed_rpm: float, *, lines: dict[float, float], fixed: dict[float, float]) -> Recording:
    """One channel of 8 s in noise: lines by order, and by frequency in Hz."""
    rate_hz = 1000.0
    time = np.arange(8000) / rate_hz
    signal = 0.002 * np.random.default_rng(int(speed_rpm)).normal(size=time.size)
    places = {order * speed_rpm / 60: size for order, size in lines.items()} | fixed
    for frequency_hz, size in places.items():
        signal = signal + size * np.cos(2 * np.pi * frequency_hz * time + 1.0)
    tacho = np.where((time * speed_rpm / 60) % 1.0 < 0.1, 5.0, 0.0)
    channels = (Channel("one", "acceleration"), Channel("tacho", "tacho"))
    return Recording(np.stack([signal, tacho]), rate_hz, channels, pulses_per_revolution=1)


@pytest.mark.parametrize(("own", "hum", "doubt"), [(0.2, 0.0, 0.2), (0.0, 0.0, 0.0), (0.0, 0.2, 0.0)])
def test_a_line_at_a_frequency_is_doubted_by_the_healthy_line_at_that_order_only(own, hum, doubt):
    # 50 Hz is order 3.75 at 800 rpm; 43.75 Hz when healthy at 700 rpm.
    amplitudes, deviations = np.full((1, 1, 2), 0.3 + 0j), np.full((1, 1, 2), 0.01)
    kinds = (LineKind(), LineKind(phase=False, frequency_hz=50.0))
    lines = OrderLines((Condition(800.0),), ("one",), (1.0, 0.0), amplitudes, deviations, kinds)
    healthy = _recorded(700.0, lines={1.0: 1.0, 3.75: own}, fixed={50.0: hum})
    before = replace(lines, conditions=(Condition(700.0),))
    found = with_own_lines(lines, [healthy], before, {"one": "one"}).deviations
    assert found[0, 0, 1] == pytest.approx(math.hypot(0.01, doubt), rel=0.02)
    assert found[0, 0, 0] == 0.01


def test_a_healthy_record_at_the_same_speed_says_nothing_of_the_order():
    amplitudes, deviations = np.full((1, 1, 1), 0.3 + 0j), np.full((1, 1, 1), 0.01)
    lines = OrderLines(
        (Condition(800.0),), ("one",), (0.0,), amplitudes, deviations, (LineKind(phase=False, frequency_hz=50.0),)
    )
    healthy = _recorded(800.0, lines={1.0: 1.0}, fixed={50.0: 0.2})
    assert with_own_lines(lines, [healthy], lines, {"one": "one"}).deviations == lines.deviations
