"""Quantisation: noise of step / sqrt(12), 6.02 dB a bit (Bennett 1948)."""

import numpy as np
import pytest
from rotorwise.simulators.effects.quantisation import Quantisation

from .sensor_records import record, run, seconds

TIME = seconds(8)
#: Not commensurable with the rate, so that the error is spread over all phases.
SINE = np.sin(2 * np.pi * 97.31 * TIME)


@pytest.mark.parametrize("bits", [8, 10.5, 12, 14])
def test_signal_to_noise_ratio_of_a_full_sine(bits, figure):
    # The law holds for many steps: below 8 bits the sine stays long in its outermost step, where errors are smaller.
    error = run(Quantisation(bits=bits), record(SINE)).signals[0] - SINE
    ratio = 10 * np.log10(np.mean(SINE**2) / np.mean(error**2))
    assert ratio == pytest.approx(6.02 * bits + 1.76, abs=0.15)
    figure("Signal over noise against 6.02 dB a bit and 1.76 dB", ratio, 6.02 * bits + 1.76, off="dB")


def test_number_of_levels():
    values = np.unique(run(Quantisation(bits=5), record(SINE)).signals[0])
    # Rounding to whole steps uses both ends of the range: 2^bits steps, one level more.
    assert values.size == 33
    assert np.diff(values) == pytest.approx(2 / 32, rel=1e-3)


def test_error_is_at_most_half_a_step():
    error = run(Quantisation(bits=7), record(SINE)).signals[0] - SINE
    assert np.abs(error).max() <= 0.5 * 2 / 2**7 * (1 + 1e-3)


def test_silent_channel_stays_silent():
    assert not run(Quantisation(bits=4), record(np.zeros(64))).signals.any()
