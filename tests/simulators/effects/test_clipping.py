"""Clipping: harmonics of a cut sine in closed form; the cut follows the chain's range."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects.clipping import Clipping

from .sensor_records import amplitude, record, run, seconds

SINE = np.sin(2 * np.pi * 32 * seconds())


@pytest.mark.parametrize("lost", [0.1, 0.5, 0.9])
def test_harmonics_of_a_cut_sine(lost, figure):
    # With c = sin(b): b1 = (2/pi)(b + sin b cos b), b3 = (4/pi)[sin^3 b cos b / 3 ... ] from the Fourier integral.
    cut = run(Clipping(lost_range=lost), record(SINE)).signals[0]
    c = 1 - lost
    b = math.asin(c)
    first = 2 / math.pi * (b + math.sin(b) * math.cos(b))
    # b3 = (4/pi) [int_0^b sin t sin 3t dt + c int_b^(pi/2) sin 3t dt]
    third = 4 / math.pi * (math.sin(2 * b) / 4 - math.sin(4 * b) / 8 + c * math.cos(3 * b) / 3)
    # The converter samples 128 times a period: what folds back is of the order 1 / 128^2.
    assert abs(amplitude(cut, 32)) == pytest.approx(first, rel=2e-3)
    found = [abs(amplitude(cut, 32)), abs(amplitude(cut, 96))]
    figure("1st and 3rd harmonic of a cut sine against closed form", found, [first, abs(third)])
    assert abs(amplitude(cut, 96)) == pytest.approx(abs(third), abs=1e-3)
    assert abs(amplitude(cut, 64)) < 1e-12


def test_highest_value_is_the_limit_about_the_middle():
    cut = run(Clipping(lost_range=0.3), record(SINE + 5.0)).signals[0]
    assert cut.max() - 5.0 == pytest.approx(0.7, rel=1e-3)
    assert cut.min() - 5.0 == pytest.approx(-0.7, rel=1e-3)


def test_a_signal_within_the_range_is_untouched():
    small = record(SINE, SINE)
    small.full_scale[:] = 10.0
    assert np.array_equal(run(Clipping(lost_range=0.5), small).signals, small.signals)
