"""Mains hum: its lines, their size and phase, and that nothing else changes."""

import numpy as np
import pytest
from rotorwise.simulators.effects.mains_hum import MainsHum
from rotorwise.simulators.machine import find_machine

from .sensor_records import amplitude, record, run, seconds

NOISE = np.random.default_rng(0).normal(size=seconds().size)


@pytest.mark.parametrize("supply_hz", [50.0, 60.0])
def test_lines(supply_hz, figure):
    made = MainsHum(amplitude=0.1, supply_hz=supply_hz, second=0.5, third=0.25, angle_rad=0.4)
    given = record(NOISE, 3 * NOISE)
    added = run(made, given).signals - given.signals
    for i in (0, 1):
        for n, share in ((1, 1.0), (2, 0.5), (3, 0.25)):
            expected = 0.1 * share * given.full_scale[i] * np.exp(0.4j * n)
            assert amplitude(added[i], n * supply_hz) == pytest.approx(expected, rel=1e-9)
            figure("Lines at the supply's 1st to 3rd harmonic", amplitude(added[i], n * supply_hz), expected)
        others = np.delete(np.abs(np.fft.rfft(added[i])), [int(n * supply_hz) for n in (1, 2, 3)])
        assert others.max() < 1e-9 * given.full_scale[i] * added.shape[1]


def test_it_does_not_follow_the_speed():
    machine = find_machine("amb_rotor").with_effects(MainsHum(amplitude=0.5))
    lines = machine.effects[0].signature(machine)
    assert {line.frequency_hz for line in lines} == {50.0, 100.0, 150.0}
    for speed_rpm in (1200, 2400):
        run_ = machine.simulate(speed_rpm=speed_rpm, duration_s=1.0, rate_hz=1000.0)
        spectrum = np.abs(np.fft.rfft(run_.signals[0] - run_.signals[0].mean()))
        # 1X is strongest, hum next at its own place.
        spectrum[np.arange(spectrum.size) % (speed_rpm // 60) == 0] = 0
        spectrum[100] = 0
        assert np.argmax(spectrum) in (50, 150)
