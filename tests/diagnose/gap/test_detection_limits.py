"""What would have shown: limits by their definition, proportional to the noise, and kept by hidden effects."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.detection_limits import SHOWN, detection_limits, limit_words
from rotorwise.diagnose.gap.explain import explain_gap, prepare
from rotorwise.diagnose.gap.hypotheses import candidates
from rotorwise.diagnose.gap.json_form import as_json
from rotorwise.diagnose.gap.responses import Responses
from rotorwise.diagnose.gap.result import DetectionLimit
from rotorwise.diagnose.report.gap_blocks import limits_block
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.effects.unbalance import Unbalance

from .made_campaigns import altered, recorded
from .made_results import made

SPEEDS_RPM = (1200.0, 1800.0, 2500.0, 3300.0)
HOW = {"rate_hz": 4000.0, "duration_s": 3.0}
ONLY = frozenset(("unbalance", "coupling_misalignment", "breathing_crack"))


@pytest.fixture(scope="module")
def real():
    return altered(amb_rotor, share=0.05, seed=3)


@pytest.fixture(scope="module")
def healthy(real):
    return recorded(real, SPEEDS_RPM, seed=1, **HOW)


@pytest.fixture(scope="module")
def sound(real, healthy):
    return Campaign(recorded(real, SPEEDS_RPM, seed=21, **HOW), healthy)


@pytest.fixture(scope="module")
def problem(sound):
    prepared = prepare(sound, amb_rotor)
    return prepared.problem(prepared.fitted)


@pytest.fixture(scope="module")
def answer(sound):
    return explain_gap(sound, amb_rotor, only=ONLY)


def _unbalance():
    found = candidates(amb_rotor, probes=["path_1", "path_2", "path_3", "path_4"])
    return next(one for one in found if one.name == "unbalance" and one.effect.at == "disc")


def test_at_the_limit_an_effect_is_worth_what_shows(problem):
    one = _unbalance()
    (limit,) = detection_limits([one], problem)
    position = np.zeros(len(one.coordinates))
    position[one.strengths[0]] = one.coordinates[one.strengths[0]].coordinate(limit.size)
    response = Responses([one], problem.baseline.machine, problem.predictor)(position)
    compared = problem.plain()
    angles = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    turned = [response * np.exp(1j * compared.lines.phase_orders * angle) for angle in angles]
    # Fifteen deviations of the prior's logarithm, halved nine times.
    assert min(map(compared.detectability, turned)) == pytest.approx(SHOWN, rel=0.15)


def test_twice_the_noise_needs_twice_the_size(problem):
    """Where the noise is far above all else that is uncertain."""
    sizes = []
    for factor in (100.0, 200.0):
        lines = replace(problem.lines, deviations=factor * problem.lines.deviations)
        (limit,) = detection_limits([_unbalance()], replace(problem, lines=lines))
        sizes.append(limit.size)
    assert sizes[1] / sizes[0] == pytest.approx(2.0, rel=0.15)


def test_a_sound_machine_tells_its_limits(answer):
    assert answer.kind == "none"
    found = {(one.effect, one.at, one.parameter): one.size for one in answer.detection_limits}
    assert 0 < found["unbalance", "disc", "moment_kg_m"] < 1e-4
    assert any("they would have shown" in one and "unbalance at disc, moment" in one for one in answer.remarks)
    rows = as_json(answer)["detection_limits"]
    assert len(rows) == len(answer.detection_limits)
    assert json.loads(json.dumps(rows)) == rows
    assert "What would have shown" in limits_block(answer)


def test_twice_the_limit_is_found(real, healthy, answer):
    size = max(one.size for one in answer.detection_limits if (one.effect, one.at) == ("unbalance", "disc"))
    faulty = real.with_effects(Unbalance(at="disc", moment_kg_m=2 * size, angle_rad=0.7))
    found = explain_gap(Campaign(recorded(faulty, SPEEDS_RPM, seed=31, **HOW), healthy), amb_rotor, only=ONLY)
    assert [one.effect for one in found.causes] == ["unbalance"]
    assert found.detection_limits == ()


def test_what_shows_nowhere_is_said():
    limits = [
        DetectionLimit("unbalance", "disc", "moment_kg_m", "kg.m", 2e-5),
        DetectionLimit("unbalance", "hub", "moment_kg_m", "kg.m", math.inf),
        DetectionLimit("breathing_crack", "shaft", "depth_ratio", "", math.inf),
        DetectionLimit("coupling_stiffness_harmonics", "coupling", "x_1", "", math.inf),
        DetectionLimit("coupling_stiffness_harmonics", "coupling", "x_2", "", 0.1),
        DetectionLimit("remounted_sensor", "bearing", "gain_change", "", 0.05),
    ]
    shown, never = limit_words(limits)
    assert shown.endswith(": unbalance at disc, moment 2e-05 kg.m; coupling stiffness harmonics at coupling, x 2 0.1.")
    assert never == "Too weak in these recordings to show at any likely size: unbalance at hub, breathing crack."
    assert limit_words([]) == []
    data = as_json(replace(made("none"), detection_limits=tuple(limits)))["detection_limits"]
    assert [one["size"] for one in data] == [2e-5, None, None, None, 0.1, 0.05]
