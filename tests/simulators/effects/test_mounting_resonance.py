"""Mounting resonance: transfer function of a mass on a spring."""

import numpy as np
import pytest
from rotorwise.simulators.effects.mounting_resonance import MountingResonance
from rotorwise.simulators.machine import find_machine

from .sensor_records import amplitude, record, run, seconds


@pytest.mark.parametrize("frequency_hz", [10, 400, 900, 1000, 1100, 1500])
def test_line_passes_with_the_closed_form(frequency_hz, figure):
    made = MountingResonance(resonance_period_s=1e-3, damping_ratio=0.05)
    given = record(np.cos(2 * np.pi * frequency_hz * seconds()))
    r = frequency_hz / 1000
    expected = 1 / (1 - r**2 + 0.1j * r)
    # The ends of the record are continued, not known: their error dies with the resonance's 3 ms.
    assert amplitude(run(made, given).signals[0], frequency_hz) == pytest.approx(expected, rel=1e-2)
    found = amplitude(run(made, given).signals[0], frequency_hz)
    figure("Line through the mount against a mass on a spring", found, expected)


def test_peak_at_resonance_is_half_the_inverse_damping_ratio():
    given = record(np.sin(2 * np.pi * 500 * seconds(4)))
    made = run(MountingResonance(resonance_period_s=2e-3, damping_ratio=0.1), given)
    assert abs(amplitude(made.signals[0], 500)) == pytest.approx(5.0, rel=2e-3)
    assert np.angle(amplitude(made.signals[0], 500) / amplitude(given.signals[0], 500)) == pytest.approx(
        -np.pi / 2, abs=5e-3
    )


def test_mean_passes():
    given = record(np.full(500, 3.0))
    assert run(MountingResonance(), given).signals[0] == pytest.approx(3.0)


def test_acts_on_accelerometers_only():
    machine = find_machine("gearbox").with_effects(MountingResonance(resonance_period_s=1e-3))
    plain = find_machine("gearbox")
    options = {"speed_rpm": 1800, "duration_s": 0.1, "rate_hz": 4096.0, "settle_s": 0.1}
    one, two = machine.simulate(**options), plain.simulate(**options)
    for probe, a, b in zip(one.probes, one.signals, two.signals, strict=True):
        assert np.array_equal(a, b) == (probe.quantity != "acceleration")
