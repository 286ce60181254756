"""Output is low-pass filtered before it is decimated: no line appears by sampling."""

import numpy as np
import pytest
from rotorwise.simulators.solvers.decimation import Decimator

from .small_machines import duffing


@pytest.mark.parametrize("factor", [2, 3, 8])
def test_blocks_give_the_same_as_one_piece(factor):
    wave = np.random.default_rng(1).normal(size=(5000, 2))
    whole = Decimator(factor)(wave)
    by_blocks = Decimator(factor)
    parts = [by_blocks(part) for part in np.array_split(wave, [7, 100, 101, 2222])]
    assert np.array_equal(np.concatenate(parts), whole)
    assert np.array_equal(Decimator(factor)(wave[:, :1]), whole[:, :1])


def test_it_is_the_sum_of_taps_times_samples():
    wave = np.random.default_rng(2).normal(size=(500, 9))
    decimate = Decimator(3)
    width = decimate.taps.size
    expected = [decimate.taps @ wave[3 * k : 3 * k + width] for k in range((500 - width) // 3 + 1)]
    assert decimate(wave) == pytest.approx(np.array(expected), abs=1e-14)


@pytest.mark.parametrize("factor", [2, 5])
def test_pass_band_is_flat_and_in_time_and_the_stop_band_is_gone(factor):
    time = np.arange(20_000) / factor
    for frequency, passes in ((0.05, True), (0.39, True), (0.61, False), (0.95, False)):
        decimate = Decimator(factor)
        out = decimate(np.cos(2 * np.pi * frequency * time)[:, None])[:, 0]
        expected = np.cos(2 * np.pi * frequency * (np.arange(out.size) + decimate.half / factor))
        assert np.abs(out - expected * passes).max() < 3e-5


def test_a_line_above_half_the_rate_does_not_fold_back():
    # A weak drive at 7 Hz seen at 10 Hz output: sampling alone would show it at 3 Hz.
    machine = duffing(stiffness=4.0, damping=1.0, drive=1.0)
    run = machine.simulate(speed_rpm=7 * 60, duration_s=20.0, rate_hz=10.0, settle_s=30.0, step_s=1e-3)
    direct = machine.simulate(speed_rpm=7 * 60, duration_s=20.0, rate_hz=100.0, settle_s=30.0, step_s=1e-3)
    line = 2 * abs(np.mean(run.probe("a acceleration") * np.exp(-2j * np.pi * 3 * run.time_s)))
    true = 2 * abs(np.mean(direct.probe("a acceleration") * np.exp(-2j * np.pi * 7 * direct.time_s)))
    assert true == pytest.approx(1.0, rel=0.01)
    assert line < 1e-4 * true
