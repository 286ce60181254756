"""Prediction of each condition from the others, against the same computed condition by condition."""

import math

import numpy as np
from rotorwise.diagnose.gap.evidence import comparison
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.prediction import left_out

from .test_gap_evidence import _baseline


def test_each_condition_is_predicted_from_the_others() -> None:
    generator = np.random.default_rng(7)
    shape = (3, 2, 2)
    amplitudes = generator.normal(size=shape) + 1j * generator.normal(size=shape)
    conditions = tuple(Condition(speed) for speed in (600.0, 700.0, 1300.0))
    lines = OrderLines(conditions, ("a", "b"), (1.0, 2.0), amplitudes, 0.5 + generator.random(shape))
    prior = np.array([0.7, 1.1])
    compared = comparison(lines, _baseline(3, prior, np.zeros(2)), None, None, np.full((2, 2), 0.3))
    directions = generator.normal(size=(3, compared.residual.size))

    covariance = compared.factor @ (np.eye(compared.residual.size) + directions.T @ directions) @ compared.factor.T
    left = compared.factor @ compared.residual
    condition = np.concatenate([np.nonzero(part)[0] for part in lines.parts])
    wanted = 0.0
    for one in range(3):
        here, rest = condition == one, condition != one
        weights = covariance[np.ix_(here, rest)] @ np.linalg.inv(covariance[np.ix_(rest, rest)])
        error = left[here] - weights @ left[rest]
        spread = covariance[np.ix_(here, here)] - weights @ covariance[np.ix_(rest, here)]
        wanted -= 0.5 * float(error @ np.linalg.solve(spread, error))
        wanted -= 0.5 * float(np.linalg.slogdet(2 * math.pi * spread)[1])
    np.testing.assert_allclose(left_out(compared, compared.residual, directions), wanted, rtol=1e-9)


def test_conditions_that_share_nothing_are_predicted_as_well_as_they_are_explained() -> None:
    generator = np.random.default_rng(8)
    shape = (3, 1, 1)
    amplitudes = generator.normal(size=shape) + 1j * generator.normal(size=shape)
    conditions = tuple(Condition(speed) for speed in (100.0, 1000.0, 10000.0))
    lines = OrderLines(conditions, ("a",), (1.0,), amplitudes, np.ones(shape))
    alone = _baseline(3, np.array([1e-9]), np.zeros(1))
    alone = type(alone)(**{**vars(alone), "lines": np.zeros(shape), "slopes": np.zeros((1, *shape))})
    compared = comparison(lines, alone, None, None, np.full((1, 1), 0.2))
    whole = compared.log_constant - 0.5 * float(compared.residual @ compared.residual)
    found = left_out(compared, compared.residual, np.zeros((0, compared.residual.size)))
    np.testing.assert_allclose(found, whole, rtol=1e-6)
