"""The grid of a first look: fine along a strength that bends, coarse in many dimensions, few where each is a run."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.coordinates import coordinates_of
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.screen import _spread
from rotorwise.simulators.effects.soft_foot import SoftFoot

FOOT = Candidate(SoftFoot(), coordinates_of(SoftFoot().parameters()))
LOSS = [one.parameter.name for one in FOOT.coordinates].index("loss")
CENTRE = np.zeros(2)


def test_along_one_bent_strength_no_level_is_far_from_any_value():
    levels = np.array([place[LOSS] for place in _spread(FOOT, CENTRE, [], [LOSS], most=128)])
    values = np.sort([FOOT.coordinates[LOSS].value(level) for level in levels])
    # A loss of stiffness moves a resonance by half of itself: 3 % between levels are 1.5 % of its frequency at most.
    assert np.diff(values).max() < 0.03
    assert values[0] < 0.13
    assert values[-1] > 0.67


@pytest.mark.parametrize(("bent", "most", "count"), [((0, 1), 128, 25), ((1,), 4, 4), ((), 128, 1)])
def test_in_more_dimensions_and_where_each_is_a_run_levels_are_few(bent, most, count):
    assert len(_spread(FOOT, CENTRE, [], bent, most=most)) == count
