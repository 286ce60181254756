"""Vectors of unit variance: pieces of a response alone are what the whole machinery gives for them."""

from __future__ import annotations

import numpy as np
import pytest
from rotorwise.diagnose.gap.whitening import Whitening

CONDITIONS, PROBES, ORDERS = 3, 4, 5


@pytest.fixture(scope="module")
def whitening() -> Whitening:
    random = np.random.default_rng(1)
    parts = random.random((2, CONDITIONS, PROBES, ORDERS)) < 0.8
    # One order without phase, and one that is not seen at all.
    parts[1, :, :, 1] = False
    parts[:, :, :, 3] = False
    size = int(parts.sum())
    root = random.normal(size=(size, size))
    return Whitening(np.linalg.cholesky(root @ root.T + 0.1 * np.eye(size)), parts)


@pytest.fixture(scope="module")
def response() -> np.ndarray:
    random = np.random.default_rng(2)
    return random.normal(size=(CONDITIONS, PROBES, ORDERS)) + 1j * random.normal(size=(CONDITIONS, PROBES, ORDERS))


def test_has_the_covariance_that_it_was_made_for(whitening: Whitening) -> None:
    # Unit vectors of the stacked lines: W W' of all of them is the inverse covariance.
    covariance = whitening.factor @ whitening.factor.T
    units = np.zeros((covariance.shape[0], CONDITIONS, PROBES, ORDERS), dtype=complex)
    real, imaginary = (np.argwhere(part) for part in whitening.parts)
    for number, place in enumerate(real):
        units[(number, *place)] = 1.0
    for number, place in enumerate(imaginary):
        units[(len(real) + number, *place)] = 1j
    white = whitening.whole(units)
    assert white @ white.T == pytest.approx(np.linalg.inv(covariance), rel=1e-8, abs=1e-10)


def test_pieces_alone_are_the_whole_of_a_response_without_the_others(
    whitening: Whitening, response: np.ndarray
) -> None:
    of_orders, of_probes = whitening.of_orders(response), whitening.of_probes(response)
    assert of_orders.shape == (2, ORDERS, whitening.factor.shape[0])
    assert of_probes.shape == (2, ORDERS, PROBES, whitening.factor.shape[0])
    for turn, factor in enumerate((1.0, 1j)):
        for order in range(ORDERS):
            alone = np.zeros_like(response)
            alone[:, :, order] = response[:, :, order]
            assert of_orders[turn, order] == pytest.approx(whitening.whole(factor * alone), rel=1e-9, abs=1e-12)
            for probe in range(PROBES):
                alone = np.zeros_like(response)
                alone[:, probe, order] = response[:, probe, order]
                expected = whitening.whole(factor * alone)
                assert of_probes[turn, order, probe] == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_pieces_add_up(whitening: Whitening, response: np.ndarray) -> None:
    assert whitening.of_orders(response)[0].sum(axis=0) == pytest.approx(whitening.whole(response), rel=1e-9)
    assert whitening.of_probes(response).sum(axis=2) == pytest.approx(whitening.of_orders(response), abs=1e-10)


def test_single_lines_are_the_whole_of_a_response_without_the_others(
    whitening: Whitening, response: np.ndarray
) -> None:
    sizes = np.where(whitening.parts[0], np.abs(response), 0.0)
    units = np.zeros((int(whitening.parts[0].sum()), *sizes.shape), dtype=complex)
    places = np.nonzero(sizes)
    units[(np.arange(len(units)), *places)] = sizes[places]
    expected, found = whitening.whole(units), whitening.of_each(sizes)
    assert found.T @ found == pytest.approx(expected.T @ expected, rel=1e-9, abs=1e-12)
    assert whitening.of_each(0 * sizes).shape == (0, whitening.factor.shape[0])


def test_lines_of_one_order_at_one_probe_are_that_of_a_response_without_the_others(whitening: Whitening) -> None:
    random = np.random.default_rng(3)
    places = np.array([[0, 0], [2, 1], [3, 4], [1, 3]])
    values = random.normal(size=(4, 2, CONDITIONS)) + 1j * random.normal(size=(4, 2, CONDITIONS))
    alone = np.zeros((4, 2, CONDITIONS, PROBES, ORDERS), dtype=complex)
    for number, (probe, order) in enumerate(places):
        alone[number, :, :, probe, order] = values[number]
    alone = alone.reshape(8, CONDITIONS, PROBES, ORDERS)
    expected = whitening.whole(np.concatenate([alone, 1j * alone]))
    assert whitening.at_places(values, places) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    none = whitening.at_places(np.zeros((0, 2, CONDITIONS), dtype=complex), np.zeros((0, 2), dtype=int))
    assert none.shape == (0, whitening.factor.shape[0])


def test_nothing_stays_nothing(whitening: Whitening, response: np.ndarray) -> None:
    assert not whitening.of_orders(0 * response).any()
    assert not whitening.of_orders(response)[:, 3].any()
