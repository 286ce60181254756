"""An effect whose likelihood has many hills is found on the highest, and is as uncertain as the hills lie apart."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import linearised
from rotorwise.diagnose.gap.coordinates import coordinates_of
from rotorwise.diagnose.gap.evidence import Problem
from rotorwise.diagnose.gap.hills import CLOSEST, looked_about, with_hills
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.refine import Fit, refined
from rotorwise.diagnose.gap.transfer_error import none_of
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effects.looseness import Looseness

SPEEDS_RPM, NOISE = (900.0, 1100.0, 1300.0, 1500.0), 0.01
HIDDEN = Looseness(at="support_1", loss=0.92, hold=0.1, rounding=0.3)
COORDINATES = coordinates_of(p for p in HIDDEN.parameters() if p.prior is not None)
TRUE = np.array([one.coordinate(HIDDEN.values()[one.parameter.name]) for one in COORDINATES])
APART = 3.0


class Ripples:
    """Predicts three orders that a contact makes: each rises with a value of the effect, with ripples on it."""

    conditions = tuple(Condition(speed) for speed in SPEEDS_RPM)
    phase_orders, reference, knees = (1.0, 2.0, 3.0), (), None

    def amplitudes(self, machine: Any) -> np.ndarray:
        found = np.zeros((len(SPEEDS_RPM), 1, 3), dtype=complex)
        for effect in machine.effects:
            z = np.array([one.coordinate(effect.values()[one.parameter.name]) for one in COORDINATES])
            speed = np.array(SPEEDS_RPM)[:, None] / 1000.0
            found[:, 0] += z + np.sin(12.0 * z * speed)
        return found

    def prepare(self, machines: Any, **_: Any) -> list[bool]:
        return [True] * len(machines)

    def repeats(self, machine: Any) -> bool:
        return True

    def steps(self, machine: Any) -> bool:
        return not self.repeats(machine)


class Apart(Ripples):
    """The same with two hills for each value, the lower one `APART` below the higher."""

    def amplitudes(self, machine: Any) -> np.ndarray:
        found = np.zeros((len(SPEEDS_RPM), 1, 3), dtype=complex)
        for effect in machine.effects:
            z = np.array([one.coordinate(effect.values()[one.parameter.name]) for one in COORDINATES])
            found[:, 0] += 1 + (z - TRUE) * (z - TRUE + APART) + 0.1j * z * np.array(SPEEDS_RPM)[:, None] / 1000.0
        return found


@pytest.fixture(scope="module")
def case() -> tuple[Fit, Problem]:
    return _case(Ripples(), np.array([-1.0, -0.8, 0.9]))


def _case(predictor: Any, begin: np.ndarray) -> tuple[Fit, Problem]:
    lines = predictor.amplitudes(rigid_coupling.with_effects(HIDDEN))
    noise = NOISE * np.random.default_rng(1).normal(size=(2, *lines.shape))
    deviations, kinds = np.full(lines.shape, NOISE), (LineKind(),) * 3
    seen = OrderLines(
        predictor.conditions, ("a",), (1.0, 2.0, 3.0), lines + noise[0] + 1j * noise[1], deviations, kinds
    )
    start = linearised(rigid_coupling, (), np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool), predictor)
    problem = Problem(seen, start, None, None, np.zeros((1, 3)), none_of(seen), predictor, predictor)
    candidate = Candidate(replace(HIDDEN), COORDINATES, frozenset({"hold", "rounding"}))
    fit = refined([candidate], begin, problem.plain(), start.machine, predictor)
    assert fit is not None
    return fit, problem


def test_a_higher_hill_is_found_about_the_one_on_which_the_steps_ended(case):
    fit, problem = case
    found = looked_about(fit, problem)
    assert found.log_evidence > fit.log_evidence + 10


def test_the_highest_hill_is_found_from_one_far_away():
    fit, problem = _case(Apart(), np.full(3, -APART))
    lower = refined(fit.candidates, np.full(3, 0.1), problem.plain(), problem.baseline.machine, problem.predictor)
    assert lower is not None
    assert lower.log_evidence > fit.log_evidence + 10
    assert looked_about(fit, problem).log_evidence == pytest.approx(lower.log_evidence, abs=0.5)


def test_the_interval_holds_the_hills_that_come_closest(case):
    fit, problem = case
    found = looked_about(fit, problem)
    assert found.hills is not None
    # Second moments of a handful of places: no more directions than places, none negative.
    assert np.linalg.eigvalsh(found.hills).min() > -1e-12
    assert np.linalg.matrix_rank(found.hills) <= CLOSEST
    wide = with_hills(found, {found.candidates[0]: found.hills})
    np.testing.assert_allclose(wide.covariance, found.covariance + found.hills)
    for number in range(len(COORDINATES)):
        (low, high), (before_low, before_high) = wide.interval(number), found.interval(number)
        assert low <= before_low < before_high <= high
    assert with_hills(found, {}).covariance == pytest.approx(found.covariance)
