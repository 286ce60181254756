"""What acts more strongly in one recording than in the next of the same condition."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.record_scatter import alike, directions, record_scatter, same_conditions
from rotorwise.diagnose.gap.whitening import Whitening

NOISE, PROBES, ORDERS = 1e-8, 4, (1.0, 2.0, 3.0)
#: What acts makes 1X clearly; 2X and 3X hardly stand out of the noise.
MADE = np.array([1.0, 0.003, 0.0]) * 2e-5 * np.exp(1j * np.arange(PROBES))[:, None]


def _lines(speeds_rpm: tuple[float, ...], factors: np.ndarray, seed: int) -> OrderLines:
    generator = np.random.default_rng(seed)
    shape = len(speeds_rpm), PROBES, len(ORDERS)
    noise = NOISE * (generator.normal(size=shape) + 1j * generator.normal(size=shape))
    names = tuple("abcd")
    conditions = tuple(Condition(speed) for speed in speeds_rpm)
    return OrderLines(conditions, names, ORDERS, factors[:, None, None] * MADE + noise, np.full(shape, NOISE))


def _found(count: int, scatter: float, seed: int, *, rpm: float = 1480.0) -> float:
    generator = np.random.default_rng(100 + seed)
    factors = 1 + scatter * (generator.normal(size=count) + 1j * generator.normal(size=count))
    lines = _lines(tuple(np.linspace(rpm, 1.001 * rpm, count)), factors, seed)
    return record_scatter(lines, np.zeros(lines.amplitudes.shape, dtype=complex))


def test_the_scatter_of_many_recordings_is_found() -> None:
    # Of 60 real numbers a standard deviation is known to 9 %.
    assert np.mean([_found(31, 0.05, seed) for seed in range(5)]) == pytest.approx(0.05, rel=0.15)


def test_what_repeats_has_none() -> None:
    assert [_found(4, 0.0, seed) for seed in range(10)] == [0.0] * 10


def test_three_recordings_tell_its_order_of_magnitude() -> None:
    found = [_found(3, 0.03, seed) for seed in range(20)]
    assert 0.01 < np.median(found) < 0.05


def test_different_speeds_and_loads_tell_nothing() -> None:
    factors = np.array([1.0, 1.3, 0.8])
    lines = _lines((1200.0, 1500.0, 1800.0), factors, 3)
    assert record_scatter(lines, np.zeros_like(lines.amplitudes)) == 0.0
    assert same_conditions([Condition(1500.0, load=1.0), Condition(1500.0, load=2.0)]) == []
    assert same_conditions([Condition(1500.0), Condition(1800.0), Condition(1501.0)]) == [[0, 2]]


def test_lines_that_do_not_stand_out_and_sizes_tell_nothing() -> None:
    lines = _lines((1500.0, 1500.0), np.array([1.0, 2.0]), 3)
    assert record_scatter(lines, lines.amplitudes) == 0.0
    sizes = OrderLines(
        lines.conditions,
        lines.probes,
        ORDERS,
        lines.amplitudes,
        lines.deviations,
        kinds=(LineKind(phase=False),) * len(ORDERS),
    )
    assert record_scatter(sizes, np.zeros_like(lines.amplitudes)) == 0.0


def test_directions_are_a_factor_of_each_order_of_one_recording() -> None:
    lines = _lines((1500.0, 1500.0), np.ones(2), 4)
    whitening = Whitening(np.eye(int(lines.parts.sum())), lines.parts)
    response = lines.amplitudes
    found = directions(response, whitening, 0.1)
    assert found.shape == (2 * 2 * len(ORDERS), int(lines.parts.sum()))
    # Each turns one order of one recording: all together they make the response of unit size, and a quarter turn on.
    assert (found**2).sum() == pytest.approx(2 * 0.1**2 * (np.abs(response) ** 2).sum())
    assert ((found != 0).sum(axis=1) == 2 * PROBES).all()
    assert directions(response, whitening, 0.0).shape == (0, int(lines.parts.sum()))


def test_a_covariance_grows_within_recordings_only() -> None:
    np.testing.assert_allclose(alike(2, 0.1), [[1.02, 1.0], [1.0, 1.02]])
