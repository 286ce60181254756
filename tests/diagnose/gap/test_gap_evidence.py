"""The Gaussian comparison against brute force."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import Baseline
from rotorwise.diagnose.gap.coordinates import coordinates_of
from rotorwise.diagnose.gap.evidence import (
    IDEALISED_LAW,
    IDEALISED_PROBE,
    IDEALISED_TRANSFER,
    LAW_TOLERANCE,
    LEAST_OF_MEAN,
    PROBE_TOLERANCE,
    STRENGTH_TOLERANCE,
    Problem,
    Widened,
    comparison,
    law_columns,
    log_density,
    strength_columns,
)
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines, joined, stacked
from rotorwise.diagnose.gap.model_error import error_covariance
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.responses import Responses
from rotorwise.diagnose.gap.transfer_error import none_of
from rotorwise.simulators import amb_rotor, rigid_coupling
from rotorwise.simulators.effects.looseness import Looseness
from rotorwise.simulators.effects.shaft_bow import ShaftBow
from rotorwise.simulators.effects.unbalance import Unbalance

GENERATOR = np.random.default_rng(4)
START = GENERATOR.bit_generator.state
PROBES, ORDERS = ("a", "b"), (1.0, 2.0)


@pytest.fixture(autouse=True)
def _same_draws() -> None:
    """Whatever ran before, each test draws the same numbers."""
    GENERATOR.bit_generator.state = START


def _complex(*shape: int) -> np.ndarray:
    return GENERATOR.normal(size=shape) + 1j * GENERATOR.normal(size=shape)


def _lines(speeds: tuple[float, ...]) -> OrderLines:
    shape = (len(speeds), 2, 2)
    deviations = 0.3 + GENERATOR.random(shape)
    deviations[0, 1, 1] = np.inf
    # One line without phase, and one condition whose phases are relative: their imaginary parts say nothing.
    conditions = tuple(Condition(s, tied=s != speeds[-1]) for s in speeds)
    kinds = (LineKind(), LineKind(phase=False))
    return OrderLines(conditions, PROBES, ORDERS, _complex(*shape), deviations, kinds)


def _baseline(count: int, prior: np.ndarray, mean: np.ndarray) -> Baseline:
    nothing = np.zeros(0)
    drift = np.zeros(prior.size)
    return Baseline(
        None,
        (),
        nothing,
        nothing,
        nothing.astype(bool),
        _complex(count, 2, 2),
        _complex(prior.size, count, 2, 2),
        prior,
        mean,
        drift,
    )


def test_conditioning_on_the_healthy_lines_is_that_of_the_joint_gaussian():
    healthy, lines = _lines((600.0, 900.0, 1200.0)), _lines((650.0, 1300.0))
    prior, mean = np.array([0.7, 1.1, 0.2]), np.array([0.1, -0.3, 0.0])
    at_healthy, baseline = _baseline(3, prior, mean), _baseline(2, prior, mean)
    error = np.array([[0.2, 0.4], [0.1, 0.3]])
    found = comparison(lines, baseline, healthy, at_healthy, error)

    both = joined(healthy, lines)
    slopes = stacked(np.concatenate([at_healthy.slopes, baseline.slopes], axis=1), both.parts)
    whole = slopes.T @ np.diag(prior**2) @ slopes + error_covariance(both.conditions, error, both.parts)
    whole += np.diag(stacked((1 + 1j) * both.deviations, both.parts) ** 2)
    model = np.concatenate([at_healthy.lines, baseline.lines]) + np.tensordot(
        mean, np.concatenate([at_healthy.slopes, baseline.slopes], axis=1), 1
    )
    left = stacked(both.amplitudes - model, both.parts)
    first = np.zeros(both.seen.shape, dtype=bool)
    first[:3] = True
    rows = np.concatenate([first[part] for part in both.parts])
    weights = whole[np.ix_(~rows, rows)] @ np.linalg.inv(whole[np.ix_(rows, rows)])
    covariance = whole[np.ix_(~rows, ~rows)] - weights @ whole[np.ix_(rows, ~rows)]
    residual = left[~rows] - weights @ left[rows]
    assert found.factor @ found.residual == pytest.approx(residual, rel=1e-8)
    assert found.covariance == pytest.approx(covariance, rel=1e-8, abs=1e-10)
    # The unknowns given all lines: known + learnt . whitened residual.
    cross = np.diag(prior**2) @ slopes
    everything = mean + cross @ np.linalg.solve(whole, left)
    assert found.known + found.learnt @ found.residual == pytest.approx(everything, rel=1e-8)


def test_healthy_conditions_of_a_wider_range_of_loads_leave_a_covariance():
    # A large model error and little noise: that the healthy lines know it must not make a negative variance.
    few, many = (tuple(Condition(1000.0, load) for load in loads) for loads in ((300.0, 500.0), (100.0, 400.0, 900.0)))
    shapes = [(len(conditions), 1, 2) for conditions in (few, many)]
    lines, healthy = (
        OrderLines(own, ("a",), (1.0, 2.0), _complex(*shape), np.full(shape, 1e-3))
        for own, shape in zip((few, many), shapes, strict=True)
    )
    none = np.zeros(0)
    bare = [
        Baseline(
            None, (), none, none, none.astype(bool), np.zeros(shape, dtype=complex), np.zeros((0, *shape)), none, none,
            none,
        )
        for shape in shapes
    ]  # fmt: skip
    found = comparison(lines, bare[0], healthy, bare[1], np.full((1, 2), 10.0))
    assert np.linalg.eigvalsh(found.covariance)[0] > 0


@pytest.mark.parametrize("count", [3, 40])
def test_widened_density_is_the_plain_gaussian_one(count):
    from scipy.stats import multivariate_normal

    lines = _lines((600.0, 900.0))
    compared = comparison(lines, _baseline(2, np.ones(2), np.zeros(2)), None, None, np.full((2, 2), 0.1))
    directions = 0.5 * GENERATOR.normal(size=(count, compared.residual.size))
    widened = Widened(directions)
    inside = np.eye(compared.residual.size) + directions.T @ directions
    assert widened.solve(compared.residual) == pytest.approx(np.linalg.solve(inside, compared.residual))
    covariance = compared.factor @ inside @ compared.factor.T
    expected = multivariate_normal(np.zeros(len(covariance)), covariance).logpdf(compared.factor @ compared.residual)
    assert log_density(compared, compared.residual, widened) == pytest.approx(expected)


@pytest.mark.parametrize(("strong", "least"), [(5.0, 1.0), (1e3, LEAST_OF_MEAN * 1e3 / math.sqrt(2))])
def test_a_weak_line_is_told_as_well_beside_a_strong_one_of_another_speed(strong, least):
    """What an effect makes may be wrong by a share of what it makes in that condition, not elsewhere."""
    size = np.array([1.0, strong])[:, None, None] * np.ones((2, 2, 2))
    conditions = (Condition(600.0), Condition(2400.0))
    lines = OrderLines(conditions, PROBES, ORDERS, size.astype(complex), np.full(size.shape, 0.3))
    silent = replace(_baseline(2, np.zeros(0), np.zeros(0)), lines=np.zeros(size.shape, dtype=complex))
    unused: Any = None
    problem = Problem(lines, silent, None, None, np.zeros((2, 2)), none_of(lines), unused, unused)
    added = np.diag(problem.around(silent, size.astype(complex)).covariance) - np.diag(problem.plain().covariance)
    found = np.sqrt(added[: size.size]).reshape(size.shape)
    expected = PROBE_TOLERANCE * np.array([least, strong])[:, None, None] * np.ones(size.shape) / math.sqrt(2)
    assert found == pytest.approx(expected, rel=1e-3)


def _two(machine, conditions, *effects):
    """Return the responses of two effects together, their position, and those of each alone."""
    probes = tuple(probe.name for probe in machine.bare_assembly().probes)
    count, orders, plain = len(conditions), (1.0, 2.0, 3.0), (LineKind(),) * 3
    predictor = Predictor(conditions, probes, orders, (4000.0,) * count, (12000,) * count, plain, (0,) * 3)
    chosen = [Candidate(one, coordinates_of(one.parameters())) for one in effects]
    places = [
        np.array([c.coordinate(e.values()[c.parameter.name]) for c in k.coordinates])
        for e, k in zip(effects, chosen, strict=True)
    ]
    alone = [Responses([candidate], machine, predictor)(place) for candidate, place in zip(chosen, places, strict=True)]
    return Responses(chosen, machine, predictor), np.concatenate(places), alone


def test_two_effects_of_a_linear_machine_add_what_each_adds_alone():
    effects = Unbalance(at="disc", moment_kg_m=3e-4, angle_rad=0.7), ShaftBow(bow_m=2e-5, angle_rad=-1.0)
    both, position, alone = _two(amb_rotor, (Condition(1500.0), Condition(3000.0)), *effects)
    for own, other in zip(both.own(position, both(position)), alone, strict=True):
        assert np.abs(own - other).max() < 1e-9 * np.abs(other).max()


def test_an_effect_that_bends_adds_no_more_than_what_is_missing_without_it():
    # A loose support's response at its strength's slope would be far from what it adds.
    effects = Unbalance(at="rotor_1", moment_kg_m=2e-4, angle_rad=0.7), Looseness(at="support_1", loss=0.6)
    both, position, alone = _two(rigid_coupling, (Condition(1500.0),), *effects)
    added = both(position)
    unbalance, looseness = both.own(position, added)
    np.testing.assert_allclose(looseness, added - alone[0], rtol=1e-9, atol=1e-20)
    np.testing.assert_allclose(unbalance, added - alone[1], rtol=1e-9, atol=1e-20)


def test_a_strength_is_known_no_better_than_its_law():
    # One strength s of a line that noise hardly hides: its variance is that of the law's factor, beside the noise's.
    lines = _lines((600.0, 900.0, 1200.0))
    compared = comparison(lines, _baseline(3, np.array([0.1]), np.zeros(1)), None, None, np.full((2, 2), 0.1))
    response = np.zeros(lines.amplitudes.shape, dtype=complex)
    response[:, :, 0] = 1e3 * _complex(3, 2)
    white = compared.whitened(response)
    # A quarter turn on it may be wrong as well; where noise lets both look alike, that takes some of what is told.
    across = compared.whitened(1j * response)
    alike = STRENGTH_TOLERANCE**2 * float(white @ across) ** 2 / (1 + STRENGTH_TOLERANCE**2 * float(across @ across))
    noise = 1 / (float(white @ white) - alike)
    information = float(white @ Widened(strength_columns(compared, response)).solve(white))
    assert 1 / information == pytest.approx(noise + STRENGTH_TOLERANCE**2, rel=1e-6)


def test_where_no_angle_makes_up_for_it_the_strongest_order_may_be_wrong_in_phase():
    shape = (1, 2, 2)
    lines = OrderLines((Condition(900.0),), PROBES, ORDERS, np.zeros(shape, complex), np.ones(shape))
    response = np.array([[[9.0, 3.0j], [12.0, 0.1]]], dtype=complex)
    compared = replace(comparison(lines, _baseline(1, np.zeros(1), np.zeros(1)), None, None, np.zeros((2, 2))))
    plain, wider = (law_columns(compared, response, idealised=False, directed=own) for own in (True, False))
    across = LAW_TOLERANCE * compared.whitened(1j * np.where(np.array(ORDERS) == 1.0, response, 0.0))
    np.testing.assert_allclose(wider.T @ wider - plain.T @ plain, np.outer(across, across), atol=1e-9)


@pytest.mark.parametrize(("idealised", "inexact"), [(False, 1.0), (True, 1.0), (True, 2.0)])
def test_a_weaker_order_may_be_wrong_by_the_tolerances_of_its_law(idealised, inexact):
    shape = (1, 2, 2)
    lines = OrderLines((Condition(900.0),), PROBES, ORDERS, np.zeros(shape, complex), np.ones(shape))
    response = np.array([[[9.0, 3.0j], [12.0, 0.1]]], dtype=complex)
    compared = replace(comparison(lines, _baseline(1, np.zeros(1), np.zeros(1)), None, None, np.zeros((2, 2))))
    directions = law_columns(replace(compared, inexact=inexact), response, idealised=idealised)
    found = directions.T @ directions
    law, probe, passed = LAW_TOLERANCE, PROBE_TOLERANCE, 0.0
    if idealised:
        law, probe, passed = (inexact * own for own in (IDEALISED_LAW, IDEALISED_PROBE, IDEALISED_TRANSFER))
    # Stacked: the real parts of both orders at one probe, then at the other. An order's error has any phase.
    number = ORDERS.index(2.0)
    assert found[number, number] == pytest.approx(9.0 * (law**2 + probe**2 + passed**2))
    # The factor of the strongest order is its strength; its errors at the probes and in speed stay.
    assert found[0, 0] == pytest.approx(81.0 * (probe**2 + passed**2))
