"""An effect whose line passes a resonance that no healthy recording came near: its values, and the machine's."""

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap import open_resonance as module
from rotorwise.diagnose.gap.evidence import Problem
from rotorwise.diagnose.gap.explain import prepare
from rotorwise.diagnose.gap.hypotheses import candidates
from rotorwise.diagnose.gap.null_distribution import chance_of_residual
from rotorwise.diagnose.gap.open_resonance import at_open_resonances
from rotorwise.diagnose.gap.predict import UnpredictableError
from rotorwise.diagnose.gap.refine import Fit, refined
from rotorwise.diagnose.gap.two_effects import MISFIT
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effects.torque_ripple import TorqueRipple

from .made_campaigns import recorded

#: 2X of 630 rpm lies on the torsional resonance of the real machine, 2.4 % above that of the model.
SPEEDS_RPM = (500.0, 630.0, 720.0, 800.0, 900.0)
STIFFER = 1.05
HIDDEN = TorqueRipple(at="load", torque_n_m=20.0, order=2.0, angle_rad=0.4)


@pytest.fixture(scope="module")
def prepared():
    real = rigid_coupling.with_parameters(bolt_stiffness_n_m=STIFFER * rigid_coupling.values["bolt_stiffness_n_m"])
    options = {"rate_hz": 500.0, "duration_s": 6.0, "settle_s": 40.0, "torsion": True}
    rippled = recorded(real.with_effects(HIDDEN), SPEEDS_RPM, seed=11, **options)
    return prepare(Campaign(rippled, recorded(real, SPEEDS_RPM, seed=1, **options)), rigid_coupling)


def _ripple(problem: Problem) -> Fit:
    """The ripple fitted about the calibrated machine, from its true order and angle and a smaller torque."""
    tried = candidates(rigid_coupling, found_lines=((HIDDEN.order, 0.0),))
    one = next(one for one in tried if one.name == "torque_ripple" and {"order"} <= one.placed)
    values = {**HIDDEN.values(), "torque_n_m": 0.6 * HIDDEN.torque_n_m}
    begin = np.array([c.coordinate(values[c.parameter.name]) for c in one.coordinates])
    found = refined([one], begin, problem.plain(), problem.baseline.machine, problem.predictor)
    assert found is not None
    return found


def test_effect_and_machine_are_found_together(prepared):
    problem = prepared.problem(range(len(SPEEDS_RPM)))
    slopes_only = _ripple(problem)
    assert chance_of_residual(slopes_only) < MISFIT
    assert slopes_only.values()[0]["torque_n_m"] < 0.8 * HIDDEN.torque_n_m

    (found,) = at_open_resonances([slopes_only], problem, 0.0, misfit=MISFIT)
    assert found.redrawn
    assert chance_of_residual(found) > MISFIT
    assert found.values()[0]["torque_n_m"] == pytest.approx(HIDDEN.torque_n_m, rel=0.03)
    assert found.values()[0]["angle_rad"] == pytest.approx(HIDDEN.angle_rad, abs=0.03)
    bolts = found.problem.baseline.machine.values["bolt_stiffness_n_m"]
    assert bolts == pytest.approx(STIFFER * rigid_coupling.values["bolt_stiffness_n_m"], rel=0.01)


@pytest.mark.parametrize("failing", [3, 9])
def test_machines_that_do_not_run_are_left_out_where_most_do(prepared, monkeypatch, failing):
    problem = prepared.problem([0, 3, 4])
    moves = 1e-3 * np.random.default_rng(2).normal(size=(12, len(problem.baseline.coordinates)))
    asked = iter([False] * failing + [True] * (len(moves) - failing))
    monkeypatch.setattr(module, "_runs", lambda machine, problem: next(asked))
    if failing > len(moves) / 2:
        with pytest.raises(UnpredictableError, match="Of 12 machines 3 run"):
            module._that_run((None,), problem, moves)
    else:
        assert np.array_equal(module._that_run((None,), problem, moves), moves[failing:])


def test_nothing_changes_away_from_the_resonance(prepared):
    problem = prepared.problem([0, 3, 4])
    fit = _ripple(problem)
    assert at_open_resonances([fit], problem, np.inf, misfit=MISFIT) == [fit]


def test_what_rounding_makes_of_the_unknowns_is_no_error(prepared, monkeypatch):
    problem = prepared.problem([0, 3, 4])
    count = problem.baseline.position.size
    monkeypatch.setattr(module, "fitted", lambda *_: (np.zeros(count), -np.eye(count)))
    fit = _ripple(problem)
    assert module.at_open_resonances([fit], problem, np.inf, misfit=MISFIT) == [fit]
