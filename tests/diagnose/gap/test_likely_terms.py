"""Of many terms those are chosen that made the lines, though none of them alone makes them much likelier."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import Baseline
from rotorwise.diagnose.gap.healthy_evidence import evidence
from rotorwise.diagnose.gap.lacking_terms import Term
from rotorwise.diagnose.gap.likely_terms import likely_terms, needed_terms, price_of
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.model_error import model_error
from rotorwise.simulators.effects.empirical_stiffness import EmpiricalStiffness
from rotorwise.simulators.effects.residual_unbalance import ResidualUnbalance

#: Speeds far apart: model errors have nothing to do with each other there.
CONDITIONS = tuple(Condition(600.0 * 2**k) for k in range(6))
SHAPE = (6, 4, 3)
SPRING = EmpiricalStiffness(
    at="bearing_1", stiffness_n_m=0.0, difference_n_m=0.0, cross_n_m=0.0, damping_n_s_m=0.0, speed_exponent=0.0,
    reference_speed_rpm=1000.0,
)  # fmt: skip
UNBALANCE = ResidualUnbalance(at="disc", moment_x_kg_m=0.0, moment_y_kg_m=0.0)


def _complex(generator: np.random.Generator, *shape: int) -> np.ndarray:
    return generator.normal(size=shape) + 1j * generator.normal(size=shape)


def _machine(slopes: np.ndarray | None = None, position: np.ndarray | None = None) -> Baseline:
    """Return a machine whose lines are 1, with strengths of unit variance where slopes are given."""
    slopes = np.zeros((0, *SHAPE), dtype=complex) if slopes is None else slopes
    position = np.zeros(len(slopes)) if position is None else position
    lines = 1.0 + np.tensordot(position, slopes, 1)
    ones = np.ones(len(slopes))
    return Baseline(None, (), position, 0 * position, ones > 0, lines, slopes, ones, -position, 0 * ones)


def _terms(generator: np.random.Generator, count: int) -> list[Term]:
    """Return springs, each moving the lines by a few model errors, and an unbalance with two strengths at the end."""
    springs = [Term(SPRING, ("cross_n_m",), 1.0, 0.02 * _complex(generator, 1, *SHAPE)) for _ in range(count)]
    pair = Term(UNBALANCE, ("moment_x_kg_m", "moment_y_kg_m"), 1.0, 0.02 * _complex(generator, 2, *SHAPE))
    return [*springs, pair]


def _measured(generator: np.random.Generator, made: np.ndarray) -> OrderLines:
    error = model_error(np.ones(SHAPE))
    noise = error * _complex(generator, *SHAPE)
    orders = tuple(float(k + 1) for k in range(SHAPE[2]))
    probes = tuple(f"probe {k}" for k in range(SHAPE[1]))
    return OrderLines(CONDITIONS, probes, orders, 1.0 + made + noise, np.full(SHAPE, 1e-4))


@pytest.mark.parametrize("seed", range(4))
def test_what_made_the_lines_is_chosen_and_nothing_else(seed: int) -> None:
    generator = np.random.default_rng(seed)
    terms = _terms(generator, 25)
    made = sum(terms[i].slopes[0] for i in (2, 7, 11)) + terms[-1].slopes[0] - terms[-1].slopes[1]
    chosen = likely_terms(_machine(), _measured(generator, made), terms)
    assert {id(one) for one in chosen} == {id(terms[i]) for i in (2, 7, 11, 25)}


@pytest.mark.parametrize("seed", range(4))
def test_noise_asks_for_nothing(seed: int) -> None:
    generator = np.random.default_rng(seed)
    assert not likely_terms(_machine(), _measured(generator, np.zeros(SHAPE)), _terms(generator, 25))
    assert not likely_terms(_machine(), _measured(generator, np.zeros(SHAPE)), [])


def test_of_terms_in_a_calibrated_machine_those_stay_that_are_worth_their_price() -> None:
    generator = np.random.default_rng(5)
    terms = _terms(generator, 5)[:5]
    slopes = np.concatenate([term.slopes for term in terms])
    position = np.array([1.0, 0.0, -0.8, 0.05, 0.0])
    healthy = _measured(generator, np.tensordot(position, slopes, 1))
    parts = [slice(i, i + 1) for i in range(5)]
    kept = needed_terms(_machine(slopes, position), healthy, terms, parts)
    assert [id(one) for one in kept] == [id(terms[0]), id(terms[2])]
    # The price is that of the evidence: all of it lost with a term that stays, little with one that goes.
    whole = evidence(_machine(slopes), healthy)
    for number, term in enumerate(terms):
        lost = whole - evidence(_machine(np.delete(slopes, number, axis=0)), healthy)
        assert (lost > price_of(term)) == (number in (0, 2))
