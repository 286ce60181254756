"""Two effects of which one is as strong as it can be are not told; of motions that repeat, phases tell."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.coordinates import coordinates_of
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.refine import Fit
from rotorwise.diagnose.gap.stretched import at_its_end, stretched_words
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.machine import find_machine


def fitted(*effects: tuple[str, dict[str, float]], repeats: bool = False) -> tuple[Fit, Any]:
    """The fit of effects at the pinion with some values, and the problem."""
    chosen, places = [], []
    for name, values in effects:
        effect = effect_catalogue()[name](at="pinion")
        one = Candidate(effect, coordinates_of(effect.parameters()))
        chosen.append(one)
        places += [c.coordinate(values.get(c.parameter.name, c.parameter.default)) for c in one.coordinates]
    count, lines = len(places), np.zeros((1, 1, 1), dtype=complex)
    slopes, none = np.zeros((count, 1, 1, 1), dtype=complex), np.zeros((0, 1))
    fit = Fit(tuple(chosen), np.array(places), np.eye(count), lines, slopes, 0.0, np.zeros(1), none)
    predictor = SimpleNamespace(repeats=lambda machine: repeats)
    return fit, SimpleNamespace(baseline=SimpleNamespace(machine=find_machine("gearbox")), predictor=predictor)


@pytest.mark.parametrize(("share", "is_told"), [(0.3, False), (0.55, False), (0.597, True)])
def test_a_strength_at_the_end_of_what_it_can_be_is_told(share, is_told):
    both = fitted(("hunting_tooth", {}), ("pitting", {"share": share}))
    assert bool(at_its_end(*both)) is is_told
    words = stretched_words(*both)
    assert ("pitting share of 0.597 where 0.6 is the most" in words) is is_told
    assert words.startswith("Hunting tooth at pinion and pitting at pinion would explain it together") is is_told


def test_one_effect_and_motions_that_repeat_are_left_alone():
    assert at_its_end(*fitted(("pitting", {"share": 0.6}))) == ""
    assert at_its_end(*fitted(("hunting_tooth", {}), ("pitting", {"share": 0.6}), repeats=True)) == ""
