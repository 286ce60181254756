"""Two causes along one line of the shaft are not named as two; others are."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.aligned import along_one_line, not_as_two
from rotorwise.diagnose.gap.hypotheses import Candidate, candidates
from rotorwise.diagnose.gap.posterior import Posterior
from rotorwise.diagnose.gap.refine import Fit, refined
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.effect import effect_catalogue

from .test_own_angles import PROBES, compared_with, predictor

TURNING = {
    "unbalance": {"moment_kg_m": 1e-4, "axial_offset_m": 0.0},
    "rotating_coupling_force": {"force_n": 3.0},
    "coupling_misalignment": {"offset_m": 1e-4, "angle_rad": 0.0},
    "axis_misalignment": {"offset_m": 3e-5, "angle_rad": 0.0},
    "run_out": {"harmonic_1_m": 2e-5},
}
ANGLE = {
    "coupling_misalignment": "offset_phase_rad",
    "axis_misalignment": "offset_direction_rad",
    "run_out": "angle_1_rad",
}


def one_of(name: str) -> Candidate:
    every = candidates(amb_rotor, without=frozenset(effect_catalogue()) - {name}, probes=PROBES)
    strength = next(iter(TURNING[name]))
    return next(one for one in every if [one.coordinates[i].parameter.name for i in one.strengths] == [strength])


def fitted(*directions: tuple[str, float]) -> tuple[Fit, Any]:
    """The fit of effects that point somewhere, to what they make, and the problem."""
    chosen, places = [], []
    for name, angle_rad in directions:
        one = one_of(name)
        values = {**TURNING[name], ANGLE.get(name, "angle_rad"): angle_rad}
        chosen.append(one)
        places += [c.coordinate(values.get(c.parameter.name, c.parameter.default)) for c in one.coordinates]
    lines = predictor()
    machine, start = amb_rotor, 0
    for one in chosen:
        stop = start + len(one.coordinates)
        machine = one.on(machine, np.array(places[start:stop]))
        start = stop
    compared = compared_with(lines.amplitudes(machine) - lines.amplitudes(amb_rotor))
    fit = refined(chosen, np.array(places), compared, amb_rotor, lines)
    assert fit is not None
    problem: Any = SimpleNamespace(baseline=SimpleNamespace(machine=amb_rotor), predictor=lines, lines=compared.lines)
    return fit, problem


@pytest.mark.parametrize(
    ("away_rad", "is_aligned"),
    [(0.0, True), (math.pi, True), (-math.pi + 0.05, True), (0.7, False), (math.pi / 2, False)],
)
@pytest.mark.parametrize("second", ["coupling_misalignment", "rotating_coupling_force"])
def test_two_that_turn_with_the_shaft_are_along_one_line_where_they_point_so(second, away_rad, is_aligned):
    fit, problem = fitted(("unbalance", 0.9), (second, 0.9 + away_rad))
    assert along_one_line(fit, problem) is is_aligned


@pytest.mark.parametrize("second", ["axis_misalignment", "run_out"])
def test_what_stands_still_and_what_a_sensor_adds_has_no_direction_on_the_shaft(second):
    fit, problem = fitted(("unbalance", 0.9), (second, 0.9))
    assert along_one_line(fit, problem) is False


def test_one_effect_is_along_no_line_with_another():
    assert along_one_line(*fitted(("unbalance", 0.9))) is False


@pytest.mark.parametrize("away_rad", [0.0, 0.7])
def test_something_unknown_takes_the_place_of_two_along_one_line(away_rad):
    fit, problem = fitted(("unbalance", 0.9), ("rotating_coupling_force", 0.9 + away_rad))
    shares = {fit.names: 0.98, ("unknown",): 0.015, (): 0.005}
    nothing: Any = SimpleNamespace(names=())
    something: Any = None
    plain: Any = None
    posterior = Posterior(plain, nothing, (fit,), something, shares, 0.5)
    found = not_as_two(posterior, problem)
    if away_rad:
        assert found is posterior
    else:
        assert next(iter(found.probabilities)) == ("unknown",)
        assert found.probabilities["unknown",] == pytest.approx(0.995)
        assert found.opposed == (fit,)
