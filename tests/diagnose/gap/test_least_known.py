"""What only sizes tell has an interval of a factor, whatever the slopes of a simulation say."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import Baseline
from rotorwise.diagnose.gap.coordinates import coordinates_of
from rotorwise.diagnose.gap.evidence import STRENGTH_TOLERANCE_OF_SIZES, comparison
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.least_known import told_to_a_factor
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effects.mains_hum import MainsHum
from rotorwise.simulators.effects.outer_race_defect import OuterRaceDefect

SHAPE = (2, 1, 2)
KINDS = (LineKind(), LineKind(phase=False))


@pytest.fixture
def compared():
    conditions = (Condition(900.0), Condition(1500.0))
    lines = OrderLines(conditions, ("a",), (1.0, 3.05), np.ones(SHAPE, complex), np.full(SHAPE, 0.1), KINDS)
    nothing, still = np.zeros(0), np.zeros((1, *SHAPE), complex)
    machine = Baseline(
        rigid_coupling,
        (),
        nothing,
        nothing,
        nothing.astype(bool),
        still[0],
        still,
        prior=np.ones(1),
        prior_mean=np.zeros(1),
        drift=np.zeros(1),
    )
    return comparison(lines, machine, None, None, np.zeros((1, 2)))


def _case(effect, response, compared):
    # A slip of nothing does nothing alone: it modifies the defect's size.
    candidate = Candidate(effect, coordinates_of(effect.parameters()), frozenset({"slip", "slip_wander"}))
    count = len(candidate.coordinates)
    narrow = 1e-8 * np.eye(count)
    found = told_to_a_factor(narrow, [candidate], np.zeros(count), [response], compared)
    return candidate, np.sqrt(np.diag(found)), np.sqrt(np.diag(narrow))


def test_a_strength_that_sizes_tell_is_known_to_a_factor(compared):
    response = np.zeros(SHAPE, complex)
    response[..., 1] = 1.0
    candidate, found, narrow = _case(OuterRaceDefect(), response, compared)
    (strength,) = candidate.strengths
    size = candidate.coordinates[strength]
    relative = (size.value(1e-3) - size.value(-1e-3)) / (2e-3 * size.value(0.0))
    assert found[strength] * relative == pytest.approx(STRENGTH_TOLERANCE_OF_SIZES, rel=1e-3)
    others = [i for i in range(found.size) if i != strength]
    assert found[others] == pytest.approx(narrow[others])


def test_lines_with_phase_and_the_measuring_chain_are_left_as_they_are(compared):
    locked, sizes = np.zeros(SHAPE, complex), np.zeros(SHAPE, complex)
    locked[..., 0], sizes[..., 1] = 1.0, 1.0
    for effect, response in ((OuterRaceDefect(), locked), (MainsHum(), sizes)):
        _, found, narrow = _case(effect, response, compared)
        assert found == pytest.approx(narrow)
