"""Severities of machines that the estimators have not seen: coverage, zones, and a fault too small to see.

A quick version, by harmonic balance; the sweep over simulated records is tests/benchmarks/severity_coverage.py.
"""

import numpy as np
import pytest
from rotorwise.diagnose.learning.severity.evaluation import score_targets, score_zones
from scipy.stats import binom


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_stated(trained):
    table = trained.held_out
    for name, one in trained.model.regressors.items():
        ends = one.predict_interval(table.values)
        truth = table.labels[name]
        hits = int(((ends[:, 0] <= truth) & (truth <= ends[:, 1])).sum())
        # 60 machines, one record each: fewer hits than this has a chance below 1e-3 at the coverage of 90 %. The
        # quantile itself comes from 40 machines; 0.87 leaves it three points.
        assert hits >= binom(truth.size, 0.87).ppf(1e-3), name


@pytest.mark.slow
def test_predicted_zones_are_those_of_the_machines(trained):
    score = score_zones(trained.model, trained.held_out)
    assert score is not None
    assert score.records == 60
    assert score.off_by_two == 0
    assert score.right >= 0.95 * score.away  # those 10 % or more away from a limit


@pytest.mark.slow
def test_what_is_too_small_to_see_gives_an_interval_that_holds_zero(trained):
    table = trained.held_out
    for name, one in trained.model.regressors.items():
        low = one.predict_interval(table.values)[:, 0]
        absent = table.labels[name] == 0
        assert np.mean(low[absent] == 0) >= binom(int(absent.sum()), 0.87).ppf(1e-3) / absent.sum(), name
        strong = table.labels[name] > 10 * one.floor
        assert np.mean(low[strong] > 0) > 0.5, name


@pytest.mark.slow
def test_large_offsets_are_estimated_within_a_factor(trained):
    """Twelve lines of four probes tell offset, angle and unbalance apart: far better than the amplitudes alone."""
    score = next(one for one in score_targets(trained.model, trained.held_out) if one.case == "with the fault")
    assert score.target == "parallel offset"
    assert score.error_factor < 1.3
    assert score.machines == score.records


@pytest.mark.slow
@pytest.mark.parametrize("name", ["parallel offset", "angular misalignment"])
def test_values_never_fall_below_zero(trained, name):
    one = trained.model.regressors[name]
    assert one.predict(trained.held_out.values).min() >= 0
    assert one.predict_interval(trained.held_out.values).min() >= 0
