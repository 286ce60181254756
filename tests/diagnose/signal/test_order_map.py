"""Order maps and waterfalls on a run-up whose orders are known exactly; tacho repairs that are told."""

from __future__ import annotations

import numpy as np
import pytest
from rotorwise.diagnose.signal.checks import check_tacho
from rotorwise.diagnose.signal.order_map import order_map, waterfall
from rotorwise.diagnose.signal.order_tracking import angular_resample
from rotorwise.diagnose.signal.speed import speed_from_tacho
from rotorwise.simulators.errors import InvalidValueError

RATE = 10_000.0
TIME = np.arange(60_000) / RATE
#: 10 to 50 Hz in 6 s; the angle does not begin at zero.
ANGLE = 0.3 + 10 * TIME + 0.5 * (40 / 6) * TIME**2
LINES = ((1.0, 1.0, 0.1), (3.5, 0.5, 0.4), (20.0, 0.2, 0.7))


def machine() -> np.ndarray:
    return np.sum([a * np.cos(2 * np.pi * (order * ANGLE + p)) for order, a, p in LINES], axis=0)


def made_map(signals, **options):
    return order_map(signals, rate_hz=RATE, phase_turns=ANGLE, highest_order=20.0, **options)


@pytest.mark.parametrize(("order", "amplitude", "turn"), LINES)
def test_amplitude_and_phase_of_every_frame_of_a_run_up(order, amplitude, turn):
    found = made_map(machine())
    row = found.amplitude[0, :, int(np.flatnonzero(found.orders == order)[0])]
    # 1e-3 of the amplitude is 0.01 dB; 0.2 dB is asked.
    assert np.abs(row / (amplitude * np.exp(2j * np.pi * turn)) - 1).max() < 1e-3


def test_speed_and_time_of_the_frames():
    found = made_map(machine())
    assert found.speed_hz == pytest.approx(10 + 40 / 6 * found.time_s, rel=1e-5)
    assert found.turns == pytest.approx(0.3 + 10 * found.time_s + 0.5 * (40 / 6) * found.time_s**2, abs=1e-4)


@pytest.mark.parametrize("order", [30.0, 33.7, 47.0, 80.0, 150.0])
def test_orders_above_the_map_do_not_fold_into_it(order):
    """At 50 samples a turn order 33.7 would stand at 16.3; it passes half the sampling rate's order on the way."""
    found = made_map(np.cos(2 * np.pi * order * ANGLE), turns_a_frame=8)
    assert np.abs(found.amplitude[0, 1:-1]).max() < 2e-4


def test_the_filter_follows_the_speed():
    """Order 20 is kept at every speed though the samples a turn fall from 1000 to 200."""
    found = made_map(np.cos(2 * np.pi * 20 * ANGLE))
    assert np.abs(found.amplitude[0, :, -1]) == pytest.approx(1.0, abs=1e-3)


def test_lines_at_fixed_frequency_keep_their_power_outside_the_orders():
    signal = machine() + np.cos(2 * np.pi * 100 * TIME)
    found = made_map(signal)
    row = np.abs(found.amplitude[0, :, int(np.flatnonzero(found.orders == 1.0)[0])])
    assert row == pytest.approx(1.0, abs=0.01)


def test_every_channel_is_tracked_alone():
    both = made_map(np.stack([machine(), 3.0 * machine()]))
    assert both.amplitude[1] == pytest.approx(3.0 * both.amplitude[0])
    assert both.amplitude[0] == pytest.approx(made_map(machine()).amplitude[0])


@pytest.mark.parametrize("samples", [40, 1000])
def test_resampling_one_turn_or_a_short_record_stays_finite(samples):
    angle = 0.9 + np.arange(samples) * (1.15 / samples)
    got = angular_resample(np.ones(samples), phase_turns=angle, samples_per_turn=16)
    assert got == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("change", [{"turns_a_frame": 0}, {"turns_a_step": 0}, {"turns_a_frame": 5000}])
def test_frames_that_do_not_fit_are_refused(change):
    with pytest.raises(InvalidValueError, match="allowed"):
        made_map(machine(), **change)


def test_waterfall_shows_a_fixed_line_and_the_speed():
    signal = 0.7 * np.cos(2 * np.pi * 400 * TIME + 0.3)
    found = waterfall(signal, rate_hz=RATE, phase_turns=ANGLE, highest_hz=1000, resolution_hz=10.0, frames=50)
    assert found.speed_hz == pytest.approx(10 + 40 / 6 * found.time_s, rel=1e-3)
    # Between two bins a Hann line is at most 1.4 dB lower.
    assert found.amplitude[0].max(axis=1) == pytest.approx(0.7, rel=0.15)
    assert np.abs(found.frequency_hz[found.amplitude[0].argmax(axis=1)] - 400).max() < 10
    assert np.isnan(waterfall(signal, rate_hz=RATE, highest_hz=1000, resolution_hz=10.0).speed_hz).all()


def test_waterfall_without_a_resolution_is_refused():
    with pytest.raises(InvalidValueError, match="allowed"):
        waterfall(machine(), rate_hz=RATE, highest_hz=1000, resolution_hz=0.0)


def pulses(*, without: tuple[int, ...] = (), doubled: tuple[int, ...] = ()) -> np.ndarray:
    turns = np.ceil(ANGLE[0]) + np.arange(int(ANGLE[-1]) - 1)
    at = np.interp(turns, ANGLE, np.arange(ANGLE.size)).astype(int)
    signal = np.zeros(ANGLE.size)
    for number, start in enumerate(at):
        if number not in without:
            signal[start : start + 20] = 5.0
        if number in doubled:
            signal[start + 60 : start + 75] = 5.0
    return signal


def test_repaired_pulses_are_reported_on_a_run_up():
    (check,) = check_tacho(pulses(without=(30, 90), doubled=(10, 50, 120)), rate_hz=RATE, name="tacho")
    assert "2 were missing" in check.message
    assert "3 false" in check.message


def test_a_tacho_that_starts_late_or_stops_early_is_reported():
    """Outside its pulses the angle only runs on: what is read there is a guess."""
    signal = pulses(without=(*range(20), *range(120, 1000)))
    late, early = check_tacho(signal, rate_hz=RATE, name="tacho")
    assert "before the first" in late.message
    assert "after the last" in early.message


def test_a_sound_tacho_is_not_mentioned():
    assert check_tacho(pulses(), rate_hz=RATE, name="tacho") == []


def test_a_run_up_to_five_times_the_speed_is_a_regular_train():
    """Most periods are then far from their median, but close to their neighbours."""
    estimate, times = speed_from_tacho(pulses(), rate_hz=RATE)
    assert estimate.confidence > 0.98
    turns = np.interp(times * RATE, np.arange(ANGLE.size), ANGLE)
    # Pulses begin at whole samples, edges lie half a sample before: 1.5 samples at 50 Hz are 7.5e-3 of a turn.
    assert turns == pytest.approx(np.rint(turns), abs=7.5e-3)


@pytest.mark.parametrize("turns", [1, 7, 11, 13, 14, 15, 16])
def test_frames_of_any_number_of_turns(turns):
    """No number of samples a turn takes a factor 7, 11 or 13 out of a frame's length: none is waited for."""
    phase = 20.0 * np.arange(40_000) / 10_000
    found = order_map(
        np.cos(2 * np.pi * 3 * phase)[None],
        rate_hz=10_000.0,
        phase_turns=phase,
        highest_order=8.0,
        turns_a_frame=turns,
    )
    if turns > 2:
        # A Hann window's lobe is two lines wide.
        assert np.abs(found.amplitude[0, :, 3 * turns]) == pytest.approx(1.0, abs=0.01)
    assert found.orders[-1] == pytest.approx(8.0)
