"""What only sizes tell has an interval of a factor, whatever the slopes of a simulation say."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import Baseline
from rotorwise.diagnose.gap.coordinates import coordinates_of
from rotorwise.diagnose.gap.evidence import STRENGTH_TOLERANCE_OF_SIZES, comparison
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.least_known import told_to_a_factor
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.refine import Fit
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effects.mains_hum import MainsHum
from rotorwise.simulators.effects.outer_race_defect import OuterRaceDefect
from rotorwise.simulators.effects.rub import Rub
from rotorwise.simulators.effects.unbalance import Unbalance

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


def _interval(effect, name, deviation):
    """The 90 % interval of a value at the prior's middle, told to a standard deviation of its coordinate."""
    candidate = Candidate(effect, coordinates_of(effect.parameters()))
    names = [one.parameter.name for one in candidate.coordinates]
    still = np.zeros((len(names), *SHAPE), complex)
    covariance = deviation**2 * np.eye(len(names))
    none = np.zeros((0, 1))
    fit = Fit((candidate,), np.zeros(len(names)), covariance, still[0], still, 0.0, none[:, 0], none)
    return fit.interval(names.index(name))


def test_values_of_an_idealised_law_are_told_no_better_than_a_law():
    # A stiffness told to a hundredth by the data: to 12 % each way, of a contact; a crack's or a bow's place likewise.
    low, high = _interval(Rub(), "stiffness_n_m", 1e-4)
    middle = Rub().stiffness_n_m
    assert (low / middle, high / middle) == pytest.approx((1 - 0.11, 1 + 0.124), abs=0.005)
    # What the data leave open is not lost beside it.
    wide = _interval(Rub(), "stiffness_n_m", 0.5)
    assert wide[0] / middle == pytest.approx(3 ** (-1.645 * np.hypot(0.5, 0.0707 / np.log(3))), rel=1e-3)
    # Others are told as well as the data do.
    low, high = _interval(Unbalance(), "moment_kg_m", 1e-4)
    assert high / low == pytest.approx(1.0, abs=1e-3)
