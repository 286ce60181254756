"""The responses of a second effect beside the first one."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.evidence import comparison
from rotorwise.diagnose.gap.hypotheses import Candidate, candidates
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.refine import Fit, nothing
from rotorwise.diagnose.gap.screen import atoms_of
from rotorwise.diagnose.gap.screening import Screening
from rotorwise.diagnose.gap.two_effects import PAIR_MARGIN, screened_beside, told_by_more_than_one_size
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.effects.ball_defect import BallDefect
from rotorwise.simulators.effects.looseness import Looseness
from rotorwise.simulators.effects.outer_race_defect import OuterRaceDefect
from rotorwise.simulators.effects.unbalance import Unbalance

from .test_gap_evidence import _baseline

SPEEDS_RPM, PROBES = (700.0, 1500.0), ("rotor_1.x", "rotor_1.y")
FIRST = Unbalance(at="rotor_1", moment_kg_m=0.04, angle_rad=1.2)


@pytest.mark.parametrize(("stages", "beside"), [(("sensor",), True), (("structure",), False)])
def test_a_turned_sensor_turns_what_the_first_effect_makes(stages, beside):
    conditions, count = tuple(Condition(speed) for speed in SPEEDS_RPM), len(SPEEDS_RPM)
    kinds = (LineKind(),)
    predictor = Predictor(conditions, PROBES, (1.0,), (500.0,) * count, (2000,) * count, kinds, (0,))
    without = frozenset(effect_catalogue()) - {"remounted_sensor"}
    every = candidates(rigid_coupling, without=without, probes=PROBES)
    (turned,) = [one for one in every if one.effect.at == "rotor_1" and one.strengths and _only_turns(one)]
    deviations = np.full((count, len(PROBES), 1), 1e-9)
    atoms = {turned: atoms_of(turned, rigid_coupling, predictor, deviations=deviations)}
    compared: Any = SimpleNamespace(lines=SimpleNamespace(deviations=deviations))
    problem: Any = SimpleNamespace(baseline=SimpleNamespace(machine=rigid_coupling), predictor=predictor)
    first = rigid_coupling.with_effects(FIRST)
    leader: Any = SimpleNamespace(
        candidates=(SimpleNamespace(effect=FIRST),), names=("unbalance",), machine=lambda _: first
    )
    found = screened_beside(leader, Screening((0, 1), compared, atoms), problem, stages)
    machine = first if beside else rigid_coupling
    for atom in found.atoms[turned]:
        expected = predictor.amplitudes(machine.with_effects(turned.at(atom.position))) - predictor.amplitudes(machine)
        np.testing.assert_allclose(atom.response, expected)
    own, with_first = predictor.amplitudes(rigid_coupling), predictor.amplitudes(first)
    assert np.abs(with_first - own).max() > 0.3 * np.abs(own).max()


def _only_turns(candidate: Any) -> bool:
    return [one.parameter.name for one in candidate.coordinates] == ["rotation_rad"]


def _leaving(
    sizes: np.ndarray, knees: np.ndarray | None, evidence: float, *, envelope: bool = False, effects: Any = ()
) -> Fit:
    """Return a fit of effects that leaves sizes (conditions, probes, orders) in their deviations."""
    conditions = tuple(Condition(600.0 * 2**k) for k in range(len(sizes)))
    orders, probes = tuple(3.1 + k for k in range(sizes.shape[2])), ("a", "b")
    kinds = (LineKind(phase=False, envelope=envelope),) * sizes.shape[2]
    lines = OrderLines(conditions, probes, orders, sizes.astype(complex), np.ones(sizes.shape), kinds, knees=knees)
    bare = _baseline(len(sizes), np.array([0.5]), np.zeros(1))
    none = np.zeros(sizes.shape, dtype=complex)
    bare = replace(bare, lines=none, slopes=np.zeros((len(bare.prior), *sizes.shape), dtype=complex))
    compared = comparison(lines, bare, None, None, np.full(sizes.shape[1:], 1e-3))
    every = tuple(Candidate(one, ()) for one in effects)
    return replace(nothing(compared), candidates=every, compared=compared, log_evidence=evidence)


def test_a_second_effect_that_one_line_of_one_record_tells_is_none_on_the_scale():
    knees = np.full((2, 4), 3.0)
    clear, one, several = np.zeros((3, 2, 4)), np.zeros((3, 2, 4)), np.zeros((3, 2, 4))
    # 36 of a squared residual: at both probes of one line in one record, or in four.
    one[1, :, 2] = np.sqrt(18.0)
    several[1, 0, :] = 3.0
    pair = _leaving(clear, knees, 15.0)
    assert not told_by_more_than_one_size(pair, _leaving(one, knees, 0.0))
    assert told_by_more_than_one_size(pair, _leaving(several, knees, 0.0))
    # What stays is what the other three lines tell.
    assert not told_by_more_than_one_size(replace(pair, log_evidence=PAIR_MARGIN + 4.0), _leaving(several, knees, 0.0))
    assert told_by_more_than_one_size(_leaving(clear, None, 15.0), _leaving(one, None, 0.0))


@pytest.mark.parametrize(
    ("second", "told"), [(Unbalance(at="disc"), False), (Looseness(at="housing_a"), True), (BallDefect(), True)]
)
def test_what_the_envelope_gains_beside_strikes_tells_only_what_makes_lines_in_it(second, told):
    knees, several = np.full((2, 4), 3.0), np.zeros((3, 2, 4))
    several[:, 0, :] = 3.0
    first = OuterRaceDefect(at="bearing_a")
    single = _leaving(several, knees, 0.0, envelope=True, effects=(first,))
    pair = _leaving(np.zeros((3, 2, 4)), knees, 30.0, envelope=True, effects=(first, second))
    assert told_by_more_than_one_size(pair, single) == told
    # What it makes in the spectrum counts.
    pair = replace(pair, log_evidence=70.0)
    assert told_by_more_than_one_size(pair, single)


def test_what_was_put_aside_is_taken_up_where_it_explains_what_is_left():
    names, looked = ("much", "some", "little", "most"), []
    share = {"much": 60.0, "some": 30.0, "little": 5.0, "most": 90.0}
    aside: Any = {name: (lambda name=name: looked.append(name) or (name,)) for name in names}
    explains: Any = lambda name, left: share[name] if left == "left" else 0.0  # noqa: E731
    compared: Any = "all"
    screening = Screening((0,), compared, {}, None, aside, explains)
    left: Any = "left"
    assert set(screening.taking_up(left).atoms) == {"most", "much"}
    assert sorted(looked) == ["most", "much"]
    assert not screening.taking_up(compared).atoms
    assert replace(screening, aside={}).taking_up(left).atoms == {}
