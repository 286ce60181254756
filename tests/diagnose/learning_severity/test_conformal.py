"""Conformal intervals: the quantile's closed form, the coverage that theory gives, scikit-learn's own checks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.diagnose.learning.severity.conformal import ConformalRegressor, group_quantile
from rotorwise.simulators.errors import InvalidValueError
from scipy.stats import betabinom
from sklearn.linear_model import Ridge
from sklearn.utils.estimator_checks import parametrize_with_checks


@parametrize_with_checks([ConformalRegressor(Ridge(), folds=2), ConformalRegressor(Ridge(), folds=2, floor=0.5)])
def test_scikit_learn_accepts_it(estimator, check):
    check(estimator)


@given(st.lists(st.floats(0, 1e6), min_size=1, max_size=40), st.floats(0.05, 0.95))
def test_groups_of_one_give_the_order_statistic_of_split_conformal_prediction(scores, coverage):
    place = int(np.ceil((len(scores) + 1) * coverage - 1e-9))
    wanted = sorted(scores)[place - 1] if place <= len(scores) else float("inf")
    assert group_quantile(np.array(scores), np.arange(len(scores)), coverage) == wanted


@given(st.lists(st.floats(0, 100), min_size=3, max_size=15), st.integers(2, 5), st.floats(0.1, 0.9))
def test_a_machine_weighs_the_same_however_often_it_was_recorded(scores, copies, coverage):
    once = group_quantile(np.array(scores), np.arange(len(scores)), coverage)
    counts = np.where(np.arange(len(scores)) % 2, copies, 1)
    many = group_quantile(np.repeat(scores, counts), np.repeat(np.arange(len(scores)), counts), coverage)
    assert many == once


def made(machines: int, records: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Records that share their machine's error and whose spread grows with the feature."""
    stream = np.random.default_rng(seed)
    groups = np.repeat(np.arange(machines), records)
    x = stream.uniform(0, 2, groups.size)
    y = 3 * x + (0.1 + x) * (stream.normal(size=machines)[groups] + 0.3 * stream.normal(size=groups.size))
    return x[:, None], y, groups


def test_coverage_on_machines_held_out_is_the_one_that_theory_gives():
    x, y, groups = made(150, 4, 0)
    model = ConformalRegressor(Ridge(), coverage=0.9).fit(x, y, groups)
    calibration, fresh = 199, 400
    model.calibrate(*made(calibration, 1, 1))
    ends = model.predict_interval(made(fresh, 1, 2)[0])
    truth = made(fresh, 1, 2)[1]
    hits = int(((ends[:, 0] <= truth) & (truth <= ends[:, 1])).sum())
    # With n = 199 scores the 180th is the quantile: the coverage is Beta(180, 20) (V. Vovk, ACML 2012, 475).
    law = betabinom(fresh, 180, 20)
    assert law.ppf(1e-4) <= hits <= law.ppf(1 - 1e-4)
    rows = np.argsort(made(fresh, 1, 2)[0][:, 0])
    width = (ends[:, 1] - ends[:, 0])[rows]
    assert width[-100:].mean() > 3 * width[:100].mean()


def test_folds_by_machine_cover_machines_held_out():
    model = ConformalRegressor(Ridge(), coverage=0.9).fit(*made(200, 4, 3))
    x, y, _ = made(400, 1, 4)
    ends = model.predict_interval(x)
    hits = int(((ends[:, 0] <= y) & (y <= ends[:, 1])).sum())
    # Four records a machine tell less than four machines; not less than one does.
    assert betabinom(400, 181, 20).ppf(1e-4) <= hits <= betabinom(400, 181, 20).ppf(1 - 1e-4)


def test_too_few_machines_give_no_bound():
    x, y, groups = made(8, 10, 5)
    ends = ConformalRegressor(Ridge(), coverage=0.9, least=0.0).fit(x, y, groups).predict_interval(x)
    assert np.all(ends[:, 1] == np.inf)
    assert np.all(ends[:, 0] == 0.0)


def test_the_coverage_holds_in_each_stratum():
    x, y, groups = made(100, 4, 6)
    hard = np.arange(y.size) % 4 == 0
    y = np.where(hard, y + 5 * np.random.default_rng(7).normal(size=y.size), y)
    plain = ConformalRegressor(Ridge()).fit(x, y, groups)
    strict = ConformalRegressor(Ridge()).fit(x, y, groups, hard)
    assert strict.quantile_ == max(group_quantile(plain.scores_[part], groups[part], 0.9) for part in (hard, ~hard))
    assert strict.quantile_ > plain.quantile_


def test_other_coverages_are_nested():
    x, y, groups = made(100, 2, 8)
    model = ConformalRegressor(Ridge()).fit(x, y, groups)
    narrow, wide = model.predict_interval(x, coverage=0.5), model.predict_interval(x, coverage=0.95)
    assert np.all(wide[:, 0] < narrow[:, 0])
    assert np.all(narrow[:, 1] < wide[:, 1])
    assert np.array_equal(model.predict_interval(x, coverage=0.9), model.predict_interval(x))


@pytest.mark.parametrize(
    ("options", "said"),
    [({"coverage": 1.0}, "coverage = 1.0"), ({"floor": 0.0}, "floor = 0.0"), ({"folds": 1}, "folds = 1")],
)
def test_values_that_make_no_sense_are_refused(options, said):
    with pytest.raises(InvalidValueError, match=said):
        ConformalRegressor(Ridge(), **options).fit(*made(20, 1, 9))


def test_groups_of_another_length_are_refused():
    x, y, _ = made(20, 1, 9)
    with pytest.raises(InvalidValueError, match="19 groups for 20 rows"):
        ConformalRegressor(Ridge()).fit(x, y, np.arange(19))


def test_no_interval_begins_or_ends_between_nothing_and_the_smallest_training_value():
    x, y, groups = made(100, 4, 10)
    y = np.where(x[:, 0] > 1, 3 * x[:, 0], 0.0)
    model = ConformalRegressor(Ridge(), coverage=0.5, floor=1.0, least=0.0)
    ends = model.fit(x, y, groups).predict_interval(x)
    smallest = y[y > 0].min()
    assert np.all((ends[:, 0] == 0) | (ends[:, 0] >= smallest))
    assert np.all(ends[:, 1] >= smallest)
    assert 0 < np.mean(ends[:, 0] == 0) < 1
