"""Beside one effect of a pair, another partner than the one it was found with."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.refine import Fit, nothing, refined
from rotorwise.diagnose.gap.swapped_pairs import swapped_pairs
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.effects.run_out import RunOut
from rotorwise.simulators.effects.shaft_bow import ShaftBow

from .made_campaigns import recorded, search_inputs

HIDDEN = (ShaftBow(bow_m=3e-5, angle_rad=0.8), RunOut(at="bearing_1", harmonic_1_m=2e-5, angle_1_rad=2.0))


@pytest.fixture(scope="module")
def begun() -> tuple[Any, ...]:
    """Return what the search is given: problem, screening."""
    options: dict[str, Any] = {"rate_hz": 4000.0, "duration_s": 2.0}
    speeds = (1200.0, 1800.0, 2500.0)
    hidden = recorded(amb_rotor.with_effects(*HIDDEN), speeds, seed=5, **options)
    campaign = Campaign(hidden, recorded(amb_rotor, speeds, seed=1, **options))
    return search_inputs(campaign, amb_rotor, only=frozenset(("shaft_bow", "run_out", "coupling_misalignment")))


def _fit(begun: tuple[Any, ...], *names: str) -> Fit:
    """Return the fit of effects of these names from their best starts of the first look."""
    problem, screening, *_ = begun
    best = {name: next(o[0] for o in screening.best() if o[0].candidate.name == name) for name in names}
    chosen = [one.candidate for one in best.values()]
    start = np.concatenate([one.position for one in best.values()])
    found = refined(chosen, start, problem.plain(), problem.baseline.machine, problem.predictor)
    assert found is not None
    return found


@pytest.mark.slow
def test_what_makes_the_lines_of_the_other_one_as_well_is_found(begun):
    problem, screening, *_ = begun
    pair, single = _fit(begun, "run_out", "coupling_misalignment"), _fit(begun, "coupling_misalignment")
    none = nothing(problem.plain())
    found = swapped_pairs([pair], [single], screening, problem, none, pair.log_evidence)
    assert found[0].names == ("run_out", "shaft_bow")
    assert found[0].log_evidence > pair.log_evidence + 5
    # Known pairs are not looked at again, nor any where a single effect leads.
    names = {fit.names for fit in swapped_pairs([pair, found[0]], [single], screening, problem, none, 0.0)}
    assert ("run_out", "shaft_bow") not in names
    ahead = replace(single, log_evidence=pair.log_evidence + 1)
    assert not swapped_pairs([pair], [ahead], screening, problem, none, pair.log_evidence)
