"""The simulated null against chi-squared where that holds, and against fits of drawn data."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.gap.evidence import Widened, comparison
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.null_distribution import DRAWS, chance_of_residual, null_of
from rotorwise.diagnose.gap.refine import Fit, nothing
from scipy.stats import chi2, kstest

from .test_gap_evidence import _baseline


@pytest.fixture(scope="module")
def none() -> Fit:
    generator = np.random.default_rng(3)
    shape = (4, 2, 2)
    amplitudes = generator.normal(size=shape) + 1j * generator.normal(size=shape)
    lines = OrderLines(
        tuple(Condition(s) for s in (600.0, 800.0, 1000.0, 1300.0)), ("a", "b"), (1.0, 2.0), amplitudes, np.ones(shape)
    )
    baseline = _baseline(4, np.array([0.5]), np.zeros(1))
    return nothing(comparison(lines, baseline, None, None, np.full((2, 2), 0.3)))


def test_without_effect_the_null_is_chi_squared(none: Fit) -> None:
    left = null_of(none, seed=1)
    assert left.shape == (DRAWS,)
    assert kstest(left, chi2(none.residual.size).cdf).pvalue > 1e-3


@pytest.mark.parametrize("chance", [0.5, 0.1, 1e-3, 1e-6])
def test_chances_follow_chi_squared_far_into_the_tail(none: Fit, chance: float) -> None:
    size = none.residual.size
    residual = np.full(size, np.sqrt(chi2.isf(chance, size) / size))
    found = chance_of_residual(replace(none, residual=residual))
    assert np.log10(found) == pytest.approx(np.log10(chance), abs=0.15 + 0.1 * abs(np.log10(chance)))


def test_the_tolerance_of_a_law_is_in_the_null(none: Fit) -> None:
    generator = np.random.default_rng(5)
    law = 3.0 * generator.normal(size=(4, none.residual.size))
    with_law = replace(none, law=law)
    drawn = generator.normal(size=none.residual.size) + generator.normal(size=4) @ law
    left = null_of(with_law, seed=2)
    assert kstest(left, chi2(none.residual.size).cdf).pvalue > 1e-3
    power = float(drawn @ Widened(law).solve(drawn))
    found = chance_of_residual(replace(with_law, residual=drawn))
    assert found == pytest.approx(float(chi2.sf(power, none.residual.size)), abs=0.05)
