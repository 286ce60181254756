"""Lines whitened line by line, and what unknowns do to them beside that, are as by one matrix of all lines."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.line_covariance import LineCovariance, line_covariance
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines, stacked
from rotorwise.diagnose.gap.model_error import error_blocks, error_covariance
from rotorwise.simulators.machine import find_machine

SPEEDS_RPM, UNKNOWNS = (900.0, 950.0, 1400.0, 2100.0), 5
PRIOR = np.array([1.0, 0.3, 1e3, 1e-4, 2.0])


@pytest.fixture
def generator() -> np.random.Generator:
    return np.random.default_rng(7)


def _lines(generator: np.random.Generator) -> OrderLines:
    """Return lines of which one has no phase, one is nowhere seen, and one is missing in one condition."""
    probes, kinds = find_machine("amb_rotor").system(speed_rpm=1000.0).probes[:2], (LineKind(), LineKind(phase=False))
    shape = (len(SPEEDS_RPM), len(probes), len(kinds))
    deviations = generator.uniform(0.1, 2.0, size=shape)
    deviations[:, 1, 1] = deviations[2, 0, 0] = np.inf
    conditions = tuple(Condition(speed) for speed in SPEEDS_RPM)
    values = generator.normal(size=shape) + 1j * generator.normal(size=shape)
    return OrderLines(conditions, probes, (1.0, 2.5), values, deviations, kinds)


def _slopes(generator: np.random.Generator, lines: OrderLines, count: int) -> np.ndarray:
    shape = (count, *lines.amplitudes.shape)
    return generator.normal(size=shape) + 1j * generator.normal(size=shape)


def _both(generator: np.random.Generator, count: int) -> tuple[OrderLines, LineCovariance, np.ndarray, np.ndarray]:
    """Return lines, their covariance, the same as a matrix, and what each unknown does to the stacked lines."""
    lines = _lines(generator)
    slopes, prior = _slopes(generator, lines, count), np.resize(PRIOR, count)
    error = generator.uniform(0.1, 1.0, size=lines.amplitudes.shape[1:])
    flat = stacked(slopes, lines.parts)
    whole = np.diag(stacked((1 + 1j) * lines.deviations, lines.parts) ** 2)
    whole += error_covariance(lines.conditions, error, lines.parts)
    whole += (flat.T * prior**2) @ flat
    return lines, line_covariance(lines, error_blocks(lines.conditions, error), slopes, prior), whole, flat


#: Fewer unknowns than there are reals (18), and more.
@pytest.mark.parametrize("count", [0, UNKNOWNS, 30])
def test_it_whitens_as_the_matrix_does(generator, count):
    lines, covariance, whole, _ = _both(generator, count)
    others = _slopes(generator, lines, 3)
    flat = stacked(others, lines.parts)
    white = covariance.whole(others)
    np.testing.assert_allclose(white @ white.T, flat @ np.linalg.solve(whole, flat.T), rtol=1e-7)
    wanted = -0.5 * (np.diag(white @ white.T) + np.linalg.slogdet(whole)[1])
    np.testing.assert_allclose(covariance.density(white), wanted, rtol=1e-9)


@pytest.mark.parametrize("count", [UNKNOWNS, 30])
def test_what_lines_say_of_the_unknowns_is_bayes_rule(generator, count):
    lines, covariance, whole, flat = _both(generator, count)
    prior = np.resize(PRIOR, count)
    gain = (prior[:, None] ** 2 * flat) @ np.linalg.inv(whole)
    change, root = covariance.told(lines.amplitudes)
    np.testing.assert_allclose(prior * change, gain @ stacked(lines.amplitudes, lines.parts), rtol=1e-6, atol=1e-9)
    wanted = np.diag(prior**2) - gain @ (prior[:, None] ** 2 * flat).T
    np.testing.assert_allclose(root @ root.T, wanted / np.outer(prior, prior), rtol=1e-6, atol=1e-9)


def test_a_multiple_of_it_has_the_same_directions(generator):
    lines, covariance, _, _ = _both(generator, UNKNOWNS)
    once, doubled = covariance.whole(lines.amplitudes), covariance.times(4.0).whole(lines.amplitudes)
    np.testing.assert_allclose(doubled, once / 2, rtol=1e-12)
