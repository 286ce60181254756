"""The responses of a second effect beside the first one."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.hypotheses import candidates
from rotorwise.diagnose.gap.lines import Condition, LineKind
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.screen import atoms_of
from rotorwise.diagnose.gap.screening import Screening
from rotorwise.diagnose.gap.two_effects import screened_beside
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.effects.unbalance import Unbalance

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
