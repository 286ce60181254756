"""Clock error: lines move by parts per million; jitter leaves -20 log10(2 pi f s) dB of noise."""

import numpy as np
import pytest
from rotorwise.simulators.effects.clock_error import ClockError, at_instants
from rotorwise.simulators.machine import find_machine

from .sensor_records import record, run, seconds


@pytest.mark.parametrize("ppm", [-5000.0, 200.0, 10000.0])
@pytest.mark.parametrize("frequency_hz", [50.0, 700.0])
def test_frequency_shift(ppm, frequency_hz, figure):
    time = seconds(4)
    given = record(np.cos(2 * np.pi * frequency_hz * time))
    made = run(ClockError(rate_error_ppm=ppm, jitter_s=0.0), given).signals[0]
    inside = slice(400, int(time.size * 0.98))
    turned = np.unwrap(np.angle(analytic(made)[inside]))
    slope = np.polyfit(time[inside], turned, 1)[0] / (2 * np.pi)
    assert (slope / frequency_hz - 1) * 1e6 == pytest.approx(ppm, abs=3.0)
    figure("Shift of a line against the error of the clock", (slope / frequency_hz - 1) * 1e6, ppm, off="ppm")


def analytic(signal):
    from scipy.signal import hilbert

    return hilbert(signal)


@pytest.mark.parametrize(("frequency_hz", "jitter_s"), [(100.0, 1e-5), (1000.0, 1e-5), (1000.0, 2e-6)])
def test_noise_of_jitter(frequency_hz, jitter_s):
    time = seconds(4)
    given = record(np.sin(2 * np.pi * frequency_hz * time))
    error = run(ClockError(rate_error_ppm=0.0, jitter_s=jitter_s), given).signals[0] - given.signals[0]
    ratio = 10 * np.log10(0.5 / np.mean(error[500:-500] ** 2))
    assert ratio == pytest.approx(-20 * np.log10(2 * np.pi * frequency_hz * jitter_s), abs=0.25)


@pytest.mark.parametrize("share", [0.05, 0.25, 0.4])
def test_interpolation_is_that_of_a_band_limited_signal(share):
    count = 2000
    wave = lambda k: np.cos(2 * np.pi * share * k + 0.3)  # noqa: E731
    instants = np.random.default_rng(0).uniform(300, count - 300, 500)
    assert at_instants(wave(np.arange(count)), instants) == pytest.approx(wave(instants), abs=3e-3 * share)


def test_trend_is_kept():
    assert at_instants(np.arange(50.0), np.array([3.25, 40.5])) == pytest.approx([3.25, 40.5])


def test_shaft_angle_shares_the_clock():
    made = run(ClockError(rate_error_ppm=1000.0, jitter_s=0.0), record(np.zeros(4000)))
    given = record(np.zeros(4000))
    assert made.phase_rad[3000] == pytest.approx(given.phase_rad[3000] * 1.001)


def test_record_is_long_enough_for_a_slow_clock():
    machine = find_machine("amb_rotor")
    slow = machine.with_effects(ClockError(rate_error_ppm=20000.0, jitter_s=0.0))
    options = {"speed_rpm": 3000, "duration_s": 0.5, "rate_hz": 1000.0}
    plain, made = machine.simulate(**options), slow.simulate(**options)
    assert made.signals.shape == plain.signals.shape
    # The last sample is of an instant after the nominal end, not a copy of the last one recorded.
    assert made.phase_rad[-1] == pytest.approx(plain.phase_rad[-1] * 1.02, rel=1e-9)
