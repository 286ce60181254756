"""Beside one effect of a pair, another partner than the one it was found with."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.refine import Fit, nothing, refined
from rotorwise.diagnose.gap.swapped_pairs import _as_likely, swapped_pairs
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.effects.load_fluctuation import LoadFluctuation
from rotorwise.simulators.effects.run_out import RunOut
from rotorwise.simulators.effects.shaft_bow import ShaftBow

from .made_campaigns import recorded, search_inputs

HIDDEN = (ShaftBow(bow_m=3e-5, angle_rad=0.8), RunOut(at="bearing_1", harmonic_1_m=2e-5, angle_1_rad=2.0))


@pytest.fixture(scope="module")
def begun() -> tuple[Any, ...]:
    """Return what the search is given: problem, screening."""
    return _begun(HIDDEN, frozenset(("shaft_bow", "run_out", "coupling_misalignment")))


def _begun(hidden: tuple[Any, ...], only: frozenset[str]) -> tuple[Any, ...]:
    options: dict[str, Any] = {"rate_hz": 4000.0, "duration_s": 2.0}
    speeds = (1200.0, 1800.0, 2500.0)
    measured = recorded(amb_rotor.with_effects(*hidden), speeds, seed=5, **options)
    campaign = Campaign(measured, recorded(amb_rotor, speeds, seed=1, **options))
    return search_inputs(campaign, amb_rotor, only=only)


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


def test_beside_what_does_not_repeat_all_that_were_as_likely_alone_are_tried():
    """A load that fluctuates was found beside a misaligned coupling only, and the bow was as likely without it."""
    hidden = (ShaftBow(bow_m=3e-5, angle_rad=0.8), LoadFluctuation(torque_n_m=2.0, radial_n=20.0, frequency_hz=7.3))
    begun = _begun(hidden, frozenset(("shaft_bow", "load_fluctuation", "coupling_misalignment")))
    problem, screening, *_ = begun
    pair, none = _fit(begun, "load_fluctuation", "coupling_misalignment"), nothing(problem.plain())
    alone = [_fit(begun, name) for name in ("coupling_misalignment", "shaft_bow")]
    level = [replace(fit, log_evidence=pair.log_evidence - 100) for fit in alone]
    found = swapped_pairs([pair], level, screening, problem, none, pair.log_evidence)
    assert found[0].names == ("load_fluctuation", "shaft_bow")
    assert found[0].log_evidence > pair.log_evidence + 5
    behind = [level[0], replace(level[1], log_evidence=level[0].log_evidence - 50)]
    assert not swapped_pairs([pair], behind, screening, problem, none, pair.log_evidence)


def test_as_likely_alone_is_near_in_evidence(begun):
    bow, offset, run_out = (_fit(begun, name) for name in ("shaft_bow", "coupling_misalignment", "run_out"))
    evidence = {"shaft_bow": -100.0, "coupling_misalignment": -104.0, "run_out": -90.0 + 1.0}
    singles = [replace(fit, log_evidence=evidence[fit.names[0]]) for fit in (bow, offset, run_out)]
    names = [options[0].candidate.name for options in _as_likely(bow.candidates[0], singles)]
    # Eleven ahead is another effect's lines; the one that is replaced stays in the list, and is a known pair.
    assert names == ["shaft_bow", "coupling_misalignment"]
    assert not _as_likely(bow.candidates[0], singles[1:])
