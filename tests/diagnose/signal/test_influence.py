"""Influence coefficients: the law that made the responses comes back."""

import numpy as np
import pytest
from rotorwise.diagnose.signal.influence import influence_coefficient
from rotorwise.simulators.errors import InvalidValueError


def test_two_runs_give_the_coefficient_and_the_correction_exactly() -> None:
    slope, before = 900.0 * np.exp(-1.3j), 40e-6 * np.exp(0.4j)
    trial = np.array([0.0, 2e-5 * np.exp(0.7j)])
    found = influence_coefficient(trial, before + slope * trial)
    assert found.coefficient == pytest.approx(slope)
    assert found.before == pytest.approx(before)
    assert before + found.coefficient * found.correction_kg_m == pytest.approx(0, abs=1e-15)
    assert np.isnan(found.deviation)


def test_its_deviation_is_that_of_repeated_draws() -> None:
    stream = np.random.default_rng(0)
    trial = np.repeat([0.0, 1e-5, 2e-5 * 1j], 4)
    noise = 1e-6 * stream.normal(size=(2000, trial.size, 2)) @ [1, 1j]
    found = [influence_coefficient(trial, 500.0 * trial + own) for own in noise]
    errors = np.array([one.coefficient for one in found]) - 500.0
    assert np.sqrt((np.abs(errors) ** 2).mean()) == pytest.approx(
        np.sqrt(np.mean([one.deviation**2 for one in found])), rel=0.05
    )


@pytest.mark.parametrize(
    ("trial", "seen", "words"),
    [([1e-5, 1e-5], [1.0, 2.0], "same unbalance"), ([0.0], [1.0], "same unbalance"), ([0, 1], [1.0], "one finite")],
)
def test_what_tells_nothing_is_refused(trial, seen, words) -> None:
    with pytest.raises(InvalidValueError, match=words):
        influence_coefficient(np.array(trial), np.array(seen))
