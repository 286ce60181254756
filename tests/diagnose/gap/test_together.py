"""Several strengths at one angle: what was put in comes out, wherever the angle lies between those computed."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import Baseline
from rotorwise.diagnose.gap.evidence import Comparison, comparison
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.together import together

SHAPE = (3, 2, 4)
STRENGTHS = np.array([0.4, 0.0, 1.7])


def _responses(angles: np.ndarray) -> np.ndarray:
    """Return responses (angles, strengths, ...) of which each holds harmonics of the angle up to 3."""
    generator = np.random.default_rng(3)
    size = (7, STRENGTHS.size, *SHAPE)
    parts = generator.normal(size=size) + 1j * generator.normal(size=size)
    return np.tensordot(np.exp(1j * np.outer(angles, np.arange(-3, 4))), parts, 1)


def _compared(seen: np.ndarray, noise: float = 1e-3) -> Comparison:
    conditions = tuple(Condition(speed) for speed in (600.0, 900.0, 1200.0))
    lines = OrderLines(conditions, ("a", "b"), (1.0, 2.0, 3.0, 4.0), seen, np.full(SHAPE, noise))
    nothing, none = np.zeros(0), np.zeros((0, *SHAPE), dtype=complex)
    baseline = Baseline(
        None, (), nothing, nothing, nothing.astype(bool), np.zeros(SHAPE, complex), none, nothing, nothing, nothing
    )
    return comparison(lines, baseline, None, None, np.zeros((2, 4)))


@pytest.mark.parametrize("degrees", [0.0, 65.0, 200.0, 355.0])
@pytest.mark.parametrize("count", [7, 8])
def test_angle_and_strengths_that_were_put_in_are_found(degrees, count):
    seen = np.tensordot(STRENGTHS, _responses(np.radians([degrees]))[0], 1)
    computed = _responses(2 * np.pi * np.arange(count) / count)
    angle, factors, response = together(computed, _compared(seen), idealised=False)
    assert 360 * angle == pytest.approx(degrees)
    np.testing.assert_allclose(factors, STRENGTHS, atol=1e-3)
    np.testing.assert_allclose(response, seen, rtol=1e-3, atol=1e-2)


def test_without_an_angle_the_strengths_are_those_of_the_one_place():
    computed = _responses(np.zeros(1))
    seen = np.tensordot(STRENGTHS, computed[0], 1)
    angle, factors, _ = together(computed, _compared(seen), idealised=False)
    assert angle == 0
    np.testing.assert_allclose(factors, STRENGTHS, atol=1e-3)


def test_no_strength_is_less_than_nothing():
    computed = _responses(np.zeros(1))
    seen = np.tensordot(np.array([0.4, -0.5, 1.7]), computed[0], 1)
    _, factors, _ = together(computed, _compared(seen), idealised=False)
    assert factors.min() >= 0


def test_what_explains_nothing_is_nothing():
    computed = np.zeros((8, 2, *SHAPE), dtype=complex)
    _, factors, response = together(computed, _compared(np.ones(SHAPE, complex)), idealised=False)
    assert np.all(np.isfinite(factors))
    assert not response.any()
