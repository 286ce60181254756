"""Speed wander: sidebands by Bessel functions, smear by the deviation, the same wander at any duration."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects.speed_wander import SpeedWander
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.speed_profile import modulated, ramp, steady

HUNTING = SpeedWander(hunting=0.01, hunting_hz=2.0, hunting_rad=-math.pi / 2, deviation=0.0)


def profile(effect, *, duration_s, speed_rpm=1800):
    return modulated(steady(speed_rpm=speed_rpm), [effect.speed_change(duration_s=duration_s)])


@pytest.mark.parametrize("order", [1, 2, 5])
def test_sidebands_are_bessel_functions(order, figure):
    from scipy.special import jv

    time = np.arange(8 * 4096) / 4096
    wave = np.cos(order * profile(HUNTING, duration_s=8.0).phase_rad(time))
    index = order * 0.01 * 30 / 2.0
    heights = []
    for k in (0, 1, 2):
        for side in (k, -k):
            line = 2 * np.mean(wave * np.exp(-2j * np.pi * (30 * order + 2 * side) * time))
            # The speed is piecewise linear: its first harmonic is 1 - pi^2 / (3 x 24^2) of the sine's.
            assert abs(line) == pytest.approx(abs(jv(k, index)), abs=0.006 * index + 1e-4)
            heights.append((abs(line), abs(jv(k, index))))
    figure("Carrier and sidebands against Bessel functions", *np.transpose(heights))


def test_sidebands_of_unbalance_on_a_rotor():
    from scipy.special import jv

    machine = find_machine("amb_rotor").with_effects(HUNTING)
    run = machine.simulate(speed_rpm=1800, duration_s=4.0, rate_hz=1000.0)
    lines = [abs(np.mean(run.signals[0] * np.exp(-2j * np.pi * f * run.time_s))) for f in (28, 30, 32)]
    # Far from a resonance the rotor follows slowly enough; force and stiffness change with speed by some percent.
    assert (lines[0] + lines[2]) / 2 / lines[1] == pytest.approx(jv(1, 0.15) / jv(0, 0.15), rel=0.1)


@pytest.mark.parametrize("deviation", [0.002, 0.02])
def test_standard_deviation_and_band(deviation):
    effect = SpeedWander(hunting=0.0, deviation=deviation, highest_hz=2.0, seed=4)
    times, change = effect.speed_change(duration_s=200.0)
    assert change.std() == pytest.approx(deviation, rel=0.05)
    assert abs(change.mean()) < 0.1 * deviation
    power = np.abs(np.fft.rfft(change * np.hanning(change.size))) ** 2
    frequency = np.fft.rfftfreq(change.size, times[1])
    assert power[frequency > 2.1].sum() < 1e-3 * power.sum()


def test_longer_run_begins_as_the_shorter_one():
    effect = SpeedWander(seed=7)
    time = np.linspace(0, 3, 500)
    one, two = (profile(effect, duration_s=d).speed_rad_s(time) for d in (3.0, 5.0))
    # Knots differ: within the error of piecewise linear speed.
    assert one == pytest.approx(two, rel=5e-5)


def test_another_seed_is_another_wander():
    first, second = (SpeedWander(seed=seed).speed_change(duration_s=5.0)[1] for seed in (1, 2))
    assert not np.allclose(first, second)


def test_acts_on_a_run_up():
    run_up = ramp(start_rpm=600, stop_rpm=1200, duration_s=4.0)
    changed = modulated(run_up, [HUNTING.speed_change(duration_s=4.0)])
    time = np.linspace(0, 4, 200)
    ratio = changed.speed_rad_s(time) / run_up.speed_rad_s(time)
    assert ratio == pytest.approx(1 + 0.01 * np.sin(2 * np.pi * 2 * time), abs=2e-4)


def test_absent_changes_nothing():
    assert SpeedWander(hunting=0.0, deviation=0.0).speed_change(duration_s=3.0) is None
    assert modulated(steady(speed_rpm=600), []) == steady(speed_rpm=600)


def test_refuses_a_fractional_seed_and_an_endless_run():
    with pytest.raises(InvalidValueError, match="whole number"):
        SpeedWander(seed=0.5)
    with pytest.raises(InvalidValueError, match="knots"):
        SpeedWander(hunting_hz=50.0).speed_change(duration_s=1e5)
