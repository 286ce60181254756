"""Pole pass: place and height of the sidebands, torque at twice the slip frequency."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects.pole_pass import PolePass
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import find_machine

RIG = find_machine("test_rig")


@pytest.mark.parametrize("poles", [2.0, 4.0, 6.0])
def test_pole_pass_is_twice_slip_times_supply(poles):
    # Supply 50 Hz: field at 100 / poles Hz, shaft at (1 - s) of it, pole pass at 2 s 50 Hz.
    slip = 0.03
    shaft_hz = 100 / poles * (1 - slip)
    effect = PolePass(slip=slip, poles=poles)
    assert effect.pole_pass_order * shaft_hz == pytest.approx(2 * slip * 50)


def pull(effect, turns):
    system = RIG.with_effects(effect).system(speed_rpm=1440)
    phase = 2 * np.pi * turns[:, None]
    steady = np.full_like(phase, 150.0)
    timeline = Timeline(phase / 150, phase, steady, 0 * steady)
    total = np.zeros((2, turns.size))
    for force in system.forces:
        if "pole pass" in force.name and "torque" not in force.name:
            total += force.law.signals(timeline, np.array(force.parameters)[:, None])[:, :, 0]
    return total[0] + 1j * total[1]


def test_pull_turns_with_the_shaft_and_swings_from_nothing_to_twice():
    effect = PolePass(force_n=7.0, slip=0.04, poles=4.0, angle_rad=0.5)
    turns = np.linspace(0, 12, 4001)
    expected = 7 * (1 + np.cos(effect.pole_pass_order * 2 * np.pi * turns)) * np.exp(1j * (2 * np.pi * turns + 0.5))
    assert pull(effect, turns) == pytest.approx(expected, abs=1e-9)
    assert np.abs(pull(effect, turns)).max() == pytest.approx(14.0, rel=1e-4)


def test_sidebands_have_half_the_height_of_their_carrier(figure):
    # In forces; the record shows it as far as the machine's response is even over 0.1 order.
    effect = PolePass(force_n=1.0, slip=0.2, poles=2.0)
    turns = np.arange(4096) / 256
    spectrum = np.fft.fft(pull(effect, turns)) / turns.size
    orders = np.fft.fftfreq(turns.size, turns[1])
    heights = [abs(spectrum[np.argmin(abs(orders - o))]) for o in (1.0, 1.5, 0.5)]
    assert effect.pole_pass_order == pytest.approx(0.5)
    assert heights == pytest.approx([1.0, 0.5, 0.5], rel=1e-9)
    figure("1X and sidebands of half its height, in forces", heights, [1.0, 0.5, 0.5])
    assert [line.order for line in effect.signature(RIG)][:3] == pytest.approx([1.0, 1.5, 0.5])


def test_torque_moves_the_motor_at_the_pole_pass_frequency():
    effect = PolePass(force_n=0.0, torque_n_m=0.5, slip=0.1, poles=2.0)
    options = {"speed_rpm": 1800, "duration_s": 3.0, "rate_hz": 2000.0, "settle_s": 1.0}
    run = RIG.with_effects(effect).simulate(**options)
    speed = run.probe("motor_speed")
    spectrum = np.abs(np.fft.rfft((speed - speed.mean()) * np.hanning(speed.size)))
    found = np.argmax(spectrum) / 3.0
    assert found == pytest.approx(30 * effect.pole_pass_order, abs=0.4)


def test_odd_number_of_poles_is_refused():
    with pytest.raises(InvalidValueError, match="poles = 3"):
        PolePass(poles=3.0)
    assert math.isclose(PolePass(poles=8.0).poles, 8.0)
