"""Steps within a box: inside it Newton's, at its wall better than Newton's scaled as a whole."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.diagnose.gap.boxed_step import boxed_step


def _quadratic(seed: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(size, size)) * np.exp(2 * generator.normal(size=size))
    return root @ root.T + 1e-3 * np.eye(size), generator.normal(size=size) * np.exp(2 * generator.normal(size=size))


def _value(curvature: np.ndarray, gradient: np.ndarray, move: np.ndarray) -> float:
    return 0.5 * float(move @ curvature @ move) - float(gradient @ move)


@given(st.integers(0, 10_000), st.integers(1, 12), st.floats(1e-3, 1e3))
def test_a_step_stays_in_the_box_and_gains_as_much_as_the_scaled_one(seed: int, size: int, limit: float) -> None:
    curvature, gradient = _quadratic(seed, size)
    move = boxed_step(curvature, gradient, limit)
    assert np.abs(move).max() <= limit * (1 + 1e-9)
    newton = np.linalg.solve(curvature, gradient)
    scaled = newton * min(1.0, limit / np.abs(newton).max())
    assert _value(curvature, gradient, move) <= _value(curvature, gradient, scaled)
    assert _value(curvature, gradient, move) <= 0
    if np.abs(newton).max() <= limit:
        assert move == pytest.approx(newton)


def test_what_the_lines_hardly_tell_does_not_hold_up_the_rest() -> None:
    # The first coordinate would go 1000 far; the others are done in one step all the same.
    curvature, gradient = np.diag([1e-3, 1.0, 4.0]), np.array([1.0, 0.5, -2.0])
    assert boxed_step(curvature, gradient, 1.0) == pytest.approx([1.0, 0.5, -0.5])


def test_coordinates_beside_one_that_was_cut_make_up_for_it() -> None:
    curvature, gradient = np.array([[2.0, 1.0], [1.0, 1.0]]), np.array([10.0, 6.0])
    # Newton: (4, 2). With the first at 1 the second alone would be at 5, beyond the box.
    assert boxed_step(curvature, gradient, 1.0) == pytest.approx([1.0, 1.0])
    assert boxed_step(curvature, gradient, 3.0) == pytest.approx([3.0, 3.0])
