"""How quickly a model's error changes with speed is told by many healthy speeds, and taken as usual from few."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import ERROR_LENGTH_SPEED, ModelError, error_covariance, similarity
from rotorwise.diagnose.gap.error_smoothness import length_of
from rotorwise.diagnose.gap.lines import Condition

LINES = (2, 3)
SIZE = ModelError(np.ones(LINES), np.zeros(LINES))


def drawn(count: int, length: float, seed: int, *, noise: float = 0.1) -> tuple[tuple[Condition, ...], np.ndarray]:
    """Return speeds from 1000 to 3000 rpm and a model error that changes over this length, with noise."""
    conditions = tuple(Condition(float(speed)) for speed in np.geomspace(1000, 3000, count))
    generator = np.random.default_rng(seed)
    values, vectors = np.linalg.eigh(similarity(conditions, length))
    draws = generator.normal(size=(2, count, *LINES)) * np.sqrt(np.maximum(values, 0))[:, None, None]
    left = np.einsum("ij,kjpo->kipo", vectors, draws)
    left += noise * generator.normal(size=left.shape)
    return conditions, left[0] + 1j * left[1]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("length", [0.05, 0.1])
def test_many_speeds_tell_a_short_length(length: float, seed: int) -> None:
    conditions, left = drawn(40, length, seed)
    assert length_of(conditions, left, np.full(left.shape, 0.01), SIZE) == length


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("count", [1, 3, 6, 40])
def test_a_smooth_error_keeps_the_usual_length(count: int, seed: int) -> None:
    conditions, left = drawn(count, ERROR_LENGTH_SPEED, seed)
    assert length_of(conditions, left, np.full(left.shape, 0.01), SIZE) == ERROR_LENGTH_SPEED


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("count", "expected"), [(3, 0.05), (40, 0.2)])
def test_where_a_shorter_one_is_usual_many_speeds_tell_a_longer_one(count: int, expected: float, seed: int) -> None:
    conditions, left = drawn(count, 0.2, seed)
    assert length_of(conditions, left, np.full(left.shape, 0.01), SIZE, usual=0.05) == expected


def test_each_order_has_a_length_of_its_own() -> None:
    conditions = (Condition(1000.0), Condition(1050.0))
    parts = np.ones((2, 2, 1, 2), dtype=bool)
    error = ModelError(np.array([[1.0, 2.0]]), np.zeros((1, 2)), np.array([0.2, 0.05]))
    found = error_covariance(conditions, error, parts)[:4, :4].reshape(2, 2, 2, 2)
    for order, (size, length) in enumerate([(1.0, 0.2), (2.0, 0.05)]):
        assert found[:, order, :, order] == pytest.approx(size**2 * similarity(conditions, length))
    assert (found[:, 0, :, 1] == 0).all()


def test_lines_that_are_not_seen_say_nothing() -> None:
    conditions, left = drawn(40, 0.05, 0)
    hidden = np.full(left.shape, np.inf)
    assert length_of(conditions, np.where(np.isinf(hidden), np.nan, left), hidden, SIZE) == ERROR_LENGTH_SPEED
    hidden[:, 0, 0] = 0.01
    assert length_of(conditions, left, hidden, SIZE) == 0.05
