"""Strengths with angles of their own: those that were put in come out, others are left out."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import Baseline
from rotorwise.diagnose.gap.evidence import Comparison, comparison
from rotorwise.diagnose.gap.further_strengths import with_further_strengths
from rotorwise.diagnose.gap.hypotheses import Candidate, candidates
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.own_angles import at_own_angles, have_own_angles, that_make
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.refine import refined
from rotorwise.diagnose.gap.responses import Responses
from rotorwise.diagnose.gap.screen import atoms_of
from rotorwise.diagnose.gap.screening import Screening
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.effect import effect_catalogue, make_effect

SPEEDS_RPM, ORDERS = (1300.0, 1900.0, 2600.0, 3400.0), (1.0, 2.0, 3.0, 4.0)
PROBES = ("path_1", "path_2", "path_3", "path_4")
SHAPE, NOISE = (len(SPEEDS_RPM), len(PROBES), len(ORDERS)), 1e-9
CONDITIONS = tuple(Condition(speed) for speed in SPEEDS_RPM)
PUT_IN = {
    "misalignment_forces": {
        "forward_1_n": 0.3,
        "backward_2_n": 2.0,
        "forward_bend_3_n_m": 0.05,
        "circling_2_kg_m": 1e-5,
    },
    "run_out": {"harmonic_1_m": 2e-6, "harmonic_4_m": 3e-7},
}


KINDS = (LineKind(),) * len(ORDERS)


def predictor(kinds: tuple[LineKind, ...] = KINDS) -> Predictor:
    count = len(SPEEDS_RPM)
    return Predictor(CONDITIONS, PROBES, ORDERS, (4000.0,) * count, (8000,) * count, kinds, tuple(range(len(ORDERS))))


def whole(name: str) -> Candidate:
    without = frozenset(effect_catalogue()) - {name}
    every = candidates(amb_rotor, without=without, probes=PROBES, reach=reach)
    return max((one for one in every if have_own_angles(one)), key=lambda one: len(one.strengths))


def reach(one: Candidate) -> float:
    """How far a candidate moves the lines: not at all along the shaft, nor above the highest order."""
    return float(np.abs(Responses([one], amb_rotor, predictor())(np.zeros(len(one.coordinates)))).max())


def compared_with(seen: np.ndarray, kinds: tuple[LineKind, ...] = KINDS, noise: float = NOISE) -> Comparison:
    generator = np.random.default_rng(1)
    noisy = seen + noise * (generator.normal(size=SHAPE) + 1j * generator.normal(size=SHAPE))
    lines = OrderLines(CONDITIONS, PROBES, ORDERS, noisy, np.full(SHAPE, noise), kinds)
    nothing, none = np.zeros(0), np.zeros((0, *SHAPE), dtype=complex)
    baseline = Baseline(
        None, (), nothing, nothing, nothing.astype(bool), np.zeros(SHAPE, complex), none, nothing, nothing, nothing
    )
    return comparison(lines, baseline, None, None, np.full(SHAPE[1:], 1e-10))


def made(name: str, kinds: tuple[LineKind, ...] = KINDS, **values: float) -> np.ndarray:
    """What an effect adds to the lines with these strengths and no others, at angles of 0.4 rad."""
    lines = predictor(kinds)
    one = whole(name)
    absent = {p.name: 0.0 for p in one.effect.parameters() if p.zero is not None}
    angles = {p.name: 0.4 for p in one.effect.parameters() if p.only_with}
    effect = make_effect(name, {**absent, **angles, **values}, at=one.effect.at)
    return lines.amplitudes(amb_rotor.with_effects(effect)) - lines.amplitudes(amb_rotor)


@pytest.mark.parametrize("name", PUT_IN)
def test_the_strengths_that_were_put_in_come_out_and_no_others(name):
    one, compared = whole(name), compared_with(made(name, **PUT_IN[name]))
    found = at_own_angles(one, atoms_of(one, amb_rotor, predictor()), compared)
    assert found is not None
    few, position, response = found
    values = few.at(position).values()
    assert {few.coordinates[i].parameter.name for i in few.strengths} == PUT_IN[name].keys()
    for strength, value in PUT_IN[name].items():
        assert values[strength] == pytest.approx(value, rel=0.02)
    angles = [c for c in few.coordinates if c.is_angle]
    for c in angles:
        away = (values[c.parameter.name] - 0.4 + c.parameter.period / 2) % c.parameter.period - c.parameter.period / 2
        assert abs(away) < 0.02
    assert response == pytest.approx(made(name, **PUT_IN[name]), abs=20 * NOISE)


def test_a_strength_is_asked_for_by_sizes_of_a_line_without_phase():
    kinds = (*KINDS[:3], LineKind(phase=False))
    one, values = whole("run_out"), PUT_IN["run_out"]
    found = at_own_angles(
        one, atoms_of(one, amb_rotor, predictor(kinds)), compared_with(made("run_out", kinds, **values), kinds)
    )
    assert found is not None
    few, position, _ = found
    assert {few.coordinates[i].parameter.name for i in few.strengths} == values.keys()
    # Where a fit begins; the machine's own 4X, small as it is, adds to the size by its phase.
    assert few.at(position).values()["harmonic_4_m"] == pytest.approx(values["harmonic_4_m"], rel=0.2)


@pytest.mark.parametrize("values", [{}, {"forward_1_n": 0.3}, {"backward_2_n": 2.0}])
def test_fewer_than_two_are_another_candidate(values):
    # Noise asks for none; 1X alone is another effect; one strength competes by itself.
    one = whole("misalignment_forces")
    compared = compared_with(made("misalignment_forces", **values))
    assert at_own_angles(one, atoms_of(one, amb_rotor, predictor()), compared) is None


def test_those_that_make_an_order_are_told_from_their_slopes():
    one = whole("misalignment_forces")
    slopes = np.zeros((len(one.coordinates), *SHAPE), dtype=complex)
    for i in one.strengths:
        order = int(
            one.coordinates[i].parameter.name.split("_")[-2 if one.coordinates[i].parameter.unit == "N" else -3]
        )
        slopes[i, ..., order - 1] = 1.0
    few, position = that_make(1, one, np.arange(float(len(one.coordinates))), slopes)
    names = [c.parameter.name for c in one.coordinates]
    assert all("_2_" in few.coordinates[i].parameter.name for i in few.strengths)
    assert len(few.strengths) == 5
    assert [names[int(at)] for at in position] == [c.parameter.name for c in few.coordinates]


def test_strengths_that_were_missed_are_found_about_the_fit():
    one, compared = (
        whole("misalignment_forces"),
        compared_with(made("misalignment_forces", **PUT_IN["misalignment_forces"])),
    )
    start = one.with_only(frozenset({"backward_2_n"}))
    fit = refined([start], np.zeros(2), compared, amb_rotor, predictor())
    problem: Any = SimpleNamespace(
        plain=lambda: compared, baseline=SimpleNamespace(machine=amb_rotor), predictor=predictor()
    )
    assert fit is not None
    found = with_further_strengths(fit, Screening((), compared, {one: (), start: ()}), problem)
    names = {c.parameter.name for c in found.coordinates if not c.is_angle}
    assert names >= PUT_IN["misalignment_forces"].keys()
    assert found.log_evidence > fit.log_evidence + 100
    # Nothing more is asked for there.
    assert with_further_strengths(found, Screening((), compared, {one: ()}), problem) is found
