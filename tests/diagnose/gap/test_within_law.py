"""An effect that leaves only noise keeps its name beside something unknown that is a little tighter; no other does."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.hypotheses import Candidate, candidates
from rotorwise.diagnose.gap.lines import LineKind
from rotorwise.diagnose.gap.posterior import posterior_of
from rotorwise.diagnose.gap.refine import Fit
from rotorwise.diagnose.gap.within_law import PAIR_MARGIN, loose_law_words, pair_margin, takes_any_form, within_its_law
from rotorwise.simulators import rigid_coupling, test_rig

REALS = 40


@pytest.fixture(scope="module")
def by_name() -> dict[str, Candidate]:
    found = candidates(rigid_coupling, probes=[one.name for one in rigid_coupling.bare_assembly().probes])
    return {one.name: one for one in found}


def _fit(*chosen: Candidate, evidence: float, sigmas: float = 1.0) -> Fit:
    """A fit that leaves so many standard deviations in every real."""
    count = sum(len(one.coordinates) for one in chosen)
    lines = np.zeros((1, 1, 1), dtype=complex)
    slopes, law = np.zeros((count, 1, 1, 1), dtype=complex), np.zeros((0, REALS))
    left = sigmas * np.ones(REALS)
    return Fit(chosen, np.zeros(count), np.eye(count), lines, slopes, evidence, left, law)


NONE = _fit(evidence=-9000.0, sigmas=20.0)


@pytest.mark.parametrize(("name", "behind", "kept"), [("looseness", 61, True), ("looseness", 101, False)])
def test_an_idealised_law_may_be_behind(by_name, name, behind, kept):
    fit = _fit(by_name[name], evidence=0.0)
    assert (within_its_law([fit], NONE, behind, misfit=1e-3) is fit) == kept


@pytest.mark.parametrize("behind", [-5, 2, 29])
def test_an_effect_of_a_known_law_has_no_need_of_it(by_name, behind):
    # A run-out that imitates a sensor put on anew leaves only noise, too.
    assert within_its_law([_fit(by_name["unbalance"], evidence=0.0)], NONE, behind, misfit=1e-3) is None


@pytest.fixture(scope="module")
def of_any_form() -> Candidate:
    every = candidates(test_rig, probes=[one.name for one in test_rig.bare_assembly().probes])
    return next(one for one in every if one.name == "misalignment_forces")


@pytest.mark.parametrize(("ahead", "kept"), [(61.0, True), (101.0, False)])
def test_an_effect_that_takes_any_form_may_be_as_far_ahead(by_name, of_any_form, ahead, kept):
    crack, forces = _fit(by_name["looseness"], evidence=0.0), _fit(of_any_form, evidence=ahead)
    assert (within_its_law([forces, crack], NONE, 50.0, misfit=1e-3) is crack) == kept
    assert takes_any_form(forces)
    assert not takes_any_form(crack)


def test_an_effect_of_a_known_law_may_not_be_ahead(by_name):
    fits = [_fit(by_name["unbalance"], evidence=61.0), _fit(by_name["looseness"], evidence=0.0)]
    assert within_its_law(fits, NONE, 50.0, misfit=1e-3) is None


@pytest.mark.parametrize(("ahead", "level"), [(61.0, True), (101.0, False)])
def test_which_are_then_level(by_name, of_any_form, ahead, level):
    crack, forces = _fit(by_name["looseness"], evidence=0.0), _fit(of_any_form, evidence=ahead)
    compared: Any = SimpleNamespace()
    unknown: Any = SimpleNamespace(log_evidence=50.0)
    probabilities = posterior_of(compared, NONE, [forces, crack], unknown, 20, []).probabilities
    assert (probabilities["looseness",] == pytest.approx(probabilities["misalignment_forces",])) == level


def test_what_leaves_more_than_noise_is_passed(by_name):
    fit = _fit(by_name["looseness"], evidence=0.0, sigmas=2.0)
    assert within_its_law([fit], NONE, 2.0, misfit=1e-3) is None


def test_what_explains_little_more_than_nothing_is_passed(by_name):
    fit = _fit(by_name["looseness"], evidence=0.0)
    assert within_its_law([fit], replace(NONE, log_evidence=-90.0), 1.0, misfit=1e-3) is None
    # Of a gain of 200, 4 may be missing.
    faint = replace(NONE, log_evidence=-200.0)
    assert within_its_law([fit], faint, 3.9, misfit=1e-3) is fit
    assert within_its_law([fit], faint, 4.1, misfit=1e-3) is None


def test_what_only_its_law_s_tolerance_explains_is_passed(by_name):
    # A rub or a looseness that bends itself to other lines leaves more than a tenth of them, within so wide a law.
    fit = _fit(by_name["looseness"], evidence=0.0, sigmas=7.0)
    wide = replace(fit, law=20.0 * np.eye(REALS))
    assert within_its_law([wide], NONE, 2.0, misfit=1e-3) is None
    assert within_its_law([replace(wide, residual=0.8 * wide.residual)], NONE, 2.0, misfit=1e-3) is not None


def test_two_effects_have_no_such_right(by_name):
    # Two together imitate a third far more often than one does.
    both = _fit(by_name["unbalance"], by_name["run_out"], evidence=0.0)
    assert within_its_law([both], NONE, 1.0, misfit=1e-3) is None


def test_the_answer_says_that_the_law_is_another(by_name):
    fit = _fit(by_name["looseness"], evidence=0.0)
    assert "looseness" in loose_law_words(fit, 61.0)[0]
    assert not loose_law_words(fit, -61.0)


@pytest.mark.parametrize(
    ("phase", "gain", "margin"), [(False, 9000.0, 100.0), (False, 500.0, 10.0), (True, 9000.0, 5.0)]
)
def test_beside_an_effect_that_sizes_tell_a_second_one_needs_more(by_name, phase, gain, margin):
    lines = SimpleNamespace(kinds=(LineKind(phase=phase),))
    seen: Any = SimpleNamespace(
        lines=lines,
        detectability=lambda response: float((np.abs(response) ** 2).sum()),
        whitened=lambda slopes: np.zeros((len(slopes), REALS)),
    )
    fit = _fit(by_name["load_fluctuation"], evidence=0.0)
    fit = replace(fit, response=np.full((1, 1, 1), 30.0 + 0j), compared=seen)
    none = replace(NONE, log_evidence=-gain)
    assert pair_margin(fit, none, misfit=1e-3) == margin
    # What leaves more than noise is at best a part of the truth.
    assert pair_margin(replace(fit, residual=2 * fit.residual), none, misfit=1e-3) == PAIR_MARGIN
    hum = replace(fit, candidates=(by_name["mains_hum"],))
    assert pair_margin(hum, none, misfit=1e-3) == PAIR_MARGIN


def test_beside_a_contact_that_leaves_only_noise_a_second_effect_needs_more(by_name):
    fit = _fit(by_name["rub"], evidence=0.0)
    none = replace(NONE, log_evidence=-9000.0)
    assert pair_margin(fit, none, misfit=1e-3) == 100.0
    assert pair_margin(replace(fit, residual=2 * fit.residual), none, misfit=1e-3) == PAIR_MARGIN
