"""DC drift: the mean and its exponential."""

import numpy as np
import pytest
from rotorwise.simulators.effects.dc_drift import DcDrift

from .sensor_records import record, run, seconds

SINE = 2 * np.sin(2 * np.pi * 40 * seconds(4))


def test_offset_is_a_share_of_the_range():
    made = run(DcDrift(offset=0.3, drift=0.0), record(SINE))
    assert made.signals[0] - SINE == pytest.approx(0.6, rel=1e-3)


def test_drift_falls_by_e_in_a_time_constant(figure):
    added = run(DcDrift(offset=0.0, drift=-1.0, time_constant_s=0.5), record(SINE)).signals[0] - SINE
    assert added[0] == pytest.approx(-2.0, rel=1e-3)
    slope = np.polyfit(seconds(4)[:8000], np.log(-added[:8000]), 1)[0]
    assert slope == pytest.approx(-2.0, rel=1e-6)
    figure("Decay rate of the drift against 1 / time constant", slope, -2.0)
