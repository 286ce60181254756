"""How quickly a model's error changes with speed is told by many healthy speeds, and taken as usual from few."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.error_smoothness import length_of
from rotorwise.diagnose.gap.lines import Condition
from rotorwise.diagnose.gap.model_error import ERROR_LENGTH_SPEED, ModelError, similarity

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
    assert length_of(conditions, left, np.full(left.shape, 0.01), SIZE, np.full(left.shape[2], 2)) == length


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("count", [1, 3, 6, 40])
def test_a_smooth_error_keeps_the_usual_length(count: int, seed: int) -> None:
    conditions, left = drawn(count, ERROR_LENGTH_SPEED, seed)
    assert length_of(conditions, left, np.full(left.shape, 0.01), SIZE, np.full(left.shape[2], 2)) == ERROR_LENGTH_SPEED


def test_lines_that_are_not_seen_say_nothing() -> None:
    conditions, left = drawn(40, 0.05, 0)
    hidden = np.full(left.shape, np.inf)
    assert (
        length_of(conditions, np.where(np.isinf(hidden), np.nan, left), hidden, SIZE, np.full(left.shape[2], 2))
        == ERROR_LENGTH_SPEED
    )
    hidden[:, 0, 0] = 0.01
    assert length_of(conditions, left, hidden, SIZE, np.full(left.shape[2], 2)) == 0.05
