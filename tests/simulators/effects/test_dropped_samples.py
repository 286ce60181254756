"""Dropped samples: the share that is lost, what is held, the noise that comes of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators.effects.dropped_samples import DroppedSamples

from .sensor_records import record, run

COUNTING = np.arange(8192.0)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("gap_s", [0.001, 0.01])
def test_share_of_time_lost(share, gap_s, figure):
    held = run(DroppedSamples(share=share, gap_s=gap_s), record(COUNTING)).signals[0]
    # The last stretch may be cut short by the end of the record.
    stretch = gap_s / share * 4096 / COUNTING.size
    assert np.mean(held != COUNTING) == pytest.approx(share, abs=share * stretch + 1e-3)
    figure("Share of time lost against the share asked for", np.mean(held != COUNTING), share)


@settings(max_examples=25, deadline=None)
@given(share=st.floats(1e-3, 0.5), gap_s=st.floats(1e-5, 0.3), seed=st.integers(0, 1000))
def test_only_earlier_values_are_held(share, gap_s, seed):
    held = run(DroppedSamples(share=share, gap_s=gap_s), record(COUNTING, 2 * COUNTING), seed).signals
    assert np.all(held[0] <= COUNTING)
    assert np.all(np.diff(held[0]) >= 0)
    assert np.array_equal(held[1], 2 * held[0])
    length = max(1, round(gap_s * 4096))
    # A gap may follow the one before it without a good sample between.
    assert (COUNTING - held[0]).max() <= 2 * length


def test_gap_of_one_length():
    held = run(DroppedSamples(share=0.05, gap_s=0.01), record(COUNTING)).signals[0]
    depth = COUNTING - held
    # Depth counts up through a gap: its largest values are the lengths.
    ends = depth[:-1][(depth[:-1] > 0) & (depth[1:] == 0)]
    assert set(ends.tolist()) <= {41.0, 82.0}
