"""A shaft that lies is often modelled without its weight: a crack that this opens and closes must be found.

Nor may a crack of a shaft that stands be lost for that, nor weight be added where the sound machine shows it.
"""

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.first_look import in_the_middle
from rotorwise.diagnose.gap.hypotheses import candidates
from rotorwise.diagnose.gap.lines import Condition, LineKind
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.unseen_weight import beside_weight
from rotorwise.simulators import amb_rotor, test_rig
from rotorwise.simulators.effect import Effect
from rotorwise.simulators.effects.asymmetric_shaft import AsymmetricShaft
from rotorwise.simulators.effects.breathing_crack import BreathingCrack
from rotorwise.simulators.effects.gravity import Gravity
from rotorwise.simulators.machine import Machine

from .made_campaigns import altered, recorded

#: A slender shaft, behind a coupling that is as stiff in every direction.
EVEN = amb_rotor.with_parameters(
    shaft_length_m=0.9, shaft_diameter_m=0.03, disc_diameter_m=0.13, disc_width_m=0.1, proportional=0.7,
    derivative=0.0008, harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0
)  # fmt: skip
LYING = Gravity(gravity_m_s2=9.81)
CRACK = BreathingCrack(depth_ratio=0.3, angle_rad=0.7, position=0.6)
UNEVEN, VERY_UNEVEN = AsymmetricShaft(asymmetry=0.2), AsymmetricShaft(asymmetry=0.45)
SPEEDS_RPM = (700.0, 1040.0, 1390.0, 1960.0, 2490.0)
HOW = {"rate_hz": 4000.0, "duration_s": 3.0}
COMPETING = frozenset(("unbalance", "shaft_bow", "coupling_misalignment", "asymmetric_shaft", "breathing_crack"))


def laden(machine: Machine) -> list[str]:
    here = [Condition(speed, None, True) for speed in SPEEDS_RPM]
    probes = tuple(one.name for one in machine.bare_assembly().probes)
    kinds = (LineKind(phase=True),) * 3
    predictor = Predictor(tuple(here), probes, (1.0, 2.0, 3.0), (4000.0,) * 5, (12000,) * 5, kinds, (0, 0, 0))
    noise = np.full((5, len(probes), 3), 1e-9)
    every = candidates(machine, without=frozenset(("gravity",)))
    few = [one for one in every if one.name in COMPETING | {"remounted_sensor"}]
    found = beside_weight(few, machine, predictor, noise)
    assert all(in_the_middle(one, machine).effects[-2] == one.beside[0] for one in found)
    return sorted({one.name for one in found})


def test_only_what_the_weight_changes_competes_beside_it() -> None:
    assert laden(EVEN) == ["asymmetric_shaft", "breathing_crack"]


@pytest.mark.parametrize(
    "machine", [EVEN.with_effects(LYING), amb_rotor, test_rig], ids=["laden", "uneven coupling", "rig with weight"]
)
def test_nothing_does_where_the_weight_is_there_or_moves_lines_by_itself(machine: Machine) -> None:
    assert laden(machine) == []


@pytest.mark.parametrize(
    ("hidden", "lies"), [(CRACK, True), (UNEVEN, True), (VERY_UNEVEN, False)], ids=["cracked", "lying", "standing"]
)
def test_a_shaft_that_lies_and_one_that_stands_are_told(hidden: Effect, lies: bool) -> None:
    real = altered(EVEN, share=0.03, seed=2)
    sound = real.with_effects(LYING) if lies else real
    measured = recorded(sound.with_effects(hidden), SPEEDS_RPM, seed=11, **HOW)
    answer = explain_gap(Campaign(measured, recorded(sound, SPEEDS_RPM, seed=1, **HOW)), EVEN, only=COMPETING)
    (cause,) = answer.causes
    assert cause.effect == hidden.NAME
    assert cause.probability > 0.9
    (strength,) = (one.name for one in hidden.parameters() if one.zero is not None)
    assert cause.parameters[strength].low < hidden.values()[strength] < cause.parameters[strength].high
    assert any("given without weight" in remark for remark in answer.remarks) is lies
    assert any(isinstance(effect, Gravity) for effect in answer.extended.effects) is lies
