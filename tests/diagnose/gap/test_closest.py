"""An unknown cause comes with the known effect that comes closest, its values, and what stands at a bound."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.closest import closest_words
from rotorwise.diagnose.gap.hypotheses import Candidate, candidates
from rotorwise.diagnose.gap.refine import Fit
from rotorwise.simulators.machine import find_machine

REALS = 40


@pytest.fixture(scope="module")
def crack() -> Candidate:
    return next(one for one in candidates(find_machine("gearbox")) if one.name == "tooth_crack")


def _fit(*chosen: Candidate, position: np.ndarray, sigmas: float) -> Fit:
    count, lines = position.size, np.zeros((1, 1, 1), dtype=complex)
    slopes = np.zeros((count, 1, 1, 1), dtype=complex)
    return Fit(chosen, position, np.eye(count), lines, slopes, 0.0, sigmas * np.ones(REALS), np.zeros((0, REALS)))


NONE = _fit(position=np.zeros(0), sigmas=10.0)


def _crack_of(crack: Candidate, depth: float, *, sigmas: float = 3.0) -> Fit:
    position = np.zeros(len(crack.coordinates))
    (strength,) = crack.strengths
    position[strength] = crack.coordinates[strength].coordinate(depth)
    return _fit(crack, position=position, sigmas=sigmas)


def test_the_closest_effect_comes_with_its_share_and_its_values(crack: Candidate) -> None:
    (said,) = closest_words([_crack_of(crack, 0.2)], NONE)
    assert "tooth crack at pinion comes closest: it explains 91% of what differs, not the rest." in said
    assert "depth 0.2" in said
    assert "At the end" not in said


def test_a_value_at_its_bound_is_told(crack: Candidate) -> None:
    (strength,) = crack.strengths
    deepest = crack.coordinates[strength].parameter.bounds[1]
    position = np.zeros(len(crack.coordinates))
    position[strength] = 50.0
    (said,) = closest_words([_fit(crack, position=position, sigmas=3.0)], NONE)
    assert f"At the end of what the effect allows: depth {deepest:g}" in said


def test_what_explains_less_than_half_is_not_told(crack: Candidate) -> None:
    assert closest_words([_crack_of(crack, 0.2, sigmas=8.0)], NONE) == ()
    assert closest_words([], NONE) == ()
