"""Aliasing: f shows at |f - k rate|, with the share that leaks."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.simulators.effects.aliasing import Aliasing
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.sensor_record import sampled

from .sensor_records import amplitude, record, run

HIGH, LOW = 16384.0, 2048.0


def folded(frequency_hz, leak):
    time = np.arange(int(4 * HIGH)) / HIGH
    given = record(np.cos(2 * np.pi * frequency_hz * time), rate_hz=HIGH, output_rate_hz=LOW)
    return sampled(run(Aliasing(leak=leak), given)).signals[0]


@pytest.mark.parametrize("frequency_hz", [1500, 2000, 2100, 3000, 5000, 7777])
def test_line_folds_back(frequency_hz, figure):
    place = abs(frequency_hz - LOW * round(frequency_hz / LOW))
    made = folded(frequency_hz, 0.4)
    assert abs(amplitude(made, place, LOW)) == pytest.approx(0.4, rel=1e-3)
    figure("Folded line against the share that leaks", abs(amplitude(made, place, LOW)), 0.4)
    others = np.abs(np.fft.rfft(made)) * 2 / made.size
    others[int(place * 4)] = 0
    assert others.max() < 0.01


@pytest.mark.parametrize("frequency_hz", [100, 500, 800])
def test_what_lies_below_passes_once(frequency_hz):
    assert amplitude(folded(frequency_hz, 0.7), frequency_hz, LOW) == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize("frequency_hz", [1300, 2000, 5000])
def test_good_filter_lets_nothing_through(frequency_hz):
    assert np.abs(folded(frequency_hz, 0.0)[200:-200]).max() < 1e-3


def test_two_leaks_are_never_more_than_all():
    given = record(np.zeros(8), rate_hz=HIGH, output_rate_hz=LOW)
    twice = run(Aliasing(leak=0.5), run(Aliasing(leak=0.5), given))
    assert twice.leak[0] == pytest.approx(0.75)
    assert run(Aliasing(leak=1.0), replace(given, leak=np.array([0.3]))).leak[0] == pytest.approx(1.0)


@pytest.mark.slow
def test_mesh_line_of_a_gearbox_folds_to_its_place():
    gearbox = find_machine("gearbox")
    rate, speed_rpm = 512.0, 1800.0
    mesh = 23 * speed_rpm / 60
    options = {"speed_rpm": speed_rpm, "duration_s": 2.0, "rate_hz": rate, "settle_s": 0.3}
    place = abs(mesh - rate)
    plain = gearbox.simulate(**options)
    leaking = gearbox.with_effects(Aliasing(leak=1.0, highest_hz=1500.0)).simulate(**options)
    names = [p.name for p in plain.probes]
    i = names.index("pinion y")
    before, after = (abs(amplitude(run.signals[i] - run.signals[i].mean(), place, rate)) for run in (plain, leaking))
    high = gearbox.simulate(**{**options, "rate_hz": 4096.0})
    own = abs(amplitude(high.signals[i] - high.signals[i].mean(), mesh, 4096.0))
    assert after == pytest.approx(own, rel=0.1)
    assert before < 0.05 * own
