"""The machine's own unknowns beside an effect: moves near a resonance, where slopes promise more than is there."""

import math
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import linearised
from rotorwise.diagnose.gap.beside_unknown import MISFIT, _taken_up, chance_in_order
from rotorwise.diagnose.gap.coordinates import Coordinate, coordinates_of
from rotorwise.diagnose.gap.evidence import Problem
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.joint_fit import density_at_values, jointly
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.refine import Fit, refined
from rotorwise.diagnose.gap.transfer_error import none_of
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.parameter import Normal, Parameter

GIVEN_RPM, DAMPING, NOISE = 1000.0, 0.03, 0.05
SPEEDS_RPM = (880.0, 940.0, 990.0, 1010.0, 1060.0, 1130.0)
#: The one unknown of the machine: its critical speed, carried by a parameter that the predictor reads.
PRIOR = Normal(GIVEN_RPM, 20.0)
OWN = Parameter("support_2_n_m", "N/m", GIVEN_RPM, bounds=(1.0, 1e5), meaning="test", source="test", prior=PRIOR)
CRITICAL = Coordinate(OWN)
HIDDEN = Unbalance(at="rotor_2", moment_kg_m=3e-3, angle_rad=0.5)


class OneResonance:
    """Predicts 1X of a rotor on one spring at one probe: 0.2 of residual unbalance, and what the effect adds."""

    conditions = tuple(Condition(speed) for speed in SPEEDS_RPM)
    phase_orders, reference, knees = (1.0,), (), None

    def amplitudes(self, machine: Any) -> np.ndarray:
        ratio = np.array(SPEEDS_RPM) / machine.values["support_2_n_m"]
        turning = 0.2 + sum(1e3 * e.moment_kg_m * np.exp(1j * e.angle_rad) for e in machine.effects)
        return (turning * ratio**2 / (1 - ratio**2 + 2j * DAMPING * ratio))[:, None, None]

    def prepare(self, machines: Any, **_: Any) -> None:
        pass

    def repeats(self, machine: Any) -> bool:
        return True

    def steps(self, machine: Any) -> bool:
        return not self.repeats(machine)


def _case(critical_rpm: float) -> tuple[Fit, Problem]:
    predictor: Any = OneResonance()
    machine = rigid_coupling.with_parameters(support_2_n_m=critical_rpm).with_effects(HIDDEN)
    lines = predictor.amplitudes(machine)
    noise = NOISE * np.random.default_rng(1).normal(size=(2, *lines.shape))
    seen = lines + noise[0] + 1j * noise[1]
    measured = OrderLines(predictor.conditions, ("a",), (1.0,), seen, np.full(lines.shape, NOISE), (LineKind(),))
    start = linearised(rigid_coupling, (CRITICAL,), np.zeros(1), np.zeros(1), np.ones(1, dtype=bool), predictor)
    problem = Problem(measured, start, None, None, np.zeros((1, 1)), none_of(measured), predictor, predictor)
    of_unbalance = coordinates_of(p for p in HIDDEN.parameters() if p.name in HIDDEN.values())
    effect = Candidate(HIDDEN, tuple(of_unbalance), frozenset({"moment_kg_m"}))
    fit = refined([effect], np.zeros(len(of_unbalance)), problem.plain(), start.machine, predictor)
    assert fit is not None
    return fit, problem


@pytest.mark.parametrize("critical_rpm", [980.0, 990.0, 1010.0, 1020.0, 1030.0])
def test_the_machine_moves_towards_what_the_lines_bear_out(critical_rpm):
    fit, problem = _case(critical_rpm)
    still, moved = (jointly(fit, problem, moves=moves) for moves in (0, 5))
    assert still.problem
    assert moved.problem
    assert density_at_values(moved, moved.problem) >= density_at_values(still, still.problem)
    found = CRITICAL.value(float(moved.problem.baseline.position[0]))
    assert abs(found - critical_rpm) < 0.1 * abs(GIVEN_RPM - critical_rpm)
    (values,) = moved.values()
    assert values["moment_kg_m"] == pytest.approx(HIDDEN.moment_kg_m, rel=0.03)
    assert math.remainder(values["angle_rad"] - HIDDEN.angle_rad, 2 * math.pi) == pytest.approx(0.0, abs=0.03)


def test_a_move_that_the_lines_do_not_bear_out_is_taken_back():
    # Twice the prior's width away and further than the resonance is wide: the slopes point anywhere.
    fit, problem = _case(960.0)
    still, moved = (jointly(fit, problem, moves=moves) for moves in (0, 5))
    assert still.problem
    assert moved.problem
    assert density_at_values(moved, moved.problem) >= density_at_values(still, still.problem)


def test_beside_something_unknown_an_effect_is_taken_up_with_the_machine_moved():
    """About the machine as given the same effect does not make its order."""
    fit, problem = _case(1030.0)
    moved = jointly(fit, problem, moves=5)
    plain = problem.plain()
    nothing_more = np.zeros_like(plain.covariance)
    assert chance_in_order(fit.candidates[0], fit.response, plain, 0) < MISFIT
    assert _taken_up(fit, problem, nothing_more, plain.transfer, 0) is None
    taken = _taken_up(moved, problem, nothing_more, plain.transfer, 0)
    assert taken is not None
    assert taken.problem is moved.problem
    assert taken.log_evidence == pytest.approx(moved.log_evidence, abs=0.1)
