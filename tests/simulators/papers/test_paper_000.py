"""The claims of paper 000: complete, and their verdicts follow the numbers."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects import CouplingMisalignment
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.papers import paper_000
from rotorwise.simulators.papers.claim import VERDICTS
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

CACHED = (paper_000._lines, paper_000._combined, paper_000._printed)


@pytest.fixture
def fresh():
    for function in CACHED:
        function.cache_clear()
    yield
    for function in CACHED:
        function.cache_clear()


@pytest.fixture(scope="module")
def found():
    return paper_000.claims()


def test_every_claim_is_complete(found):
    assert len(found) == 14
    assert len({(claim.place, claim.says) for claim in found}) == 14
    for claim in found:
        assert claim.paper == "000"
        assert claim.verdict in VERDICTS
        assert all((claim.place, claim.says, claim.as_printed, claim.corrected))
        assert "nan" not in claim.corrected + claim.with_effect


def test_numbers_in_the_text_are_those_of_the_solver(found):
    effect = CouplingMisalignment(offset_m=5e-4, angle_rad=0.0)
    motion = harmonic_balance(find_machine("amb_rotor").with_effects(effect), speed_rpm=4000.0)
    lines = 1e6 * np.abs(motion.amplitudes[:, 1:4]).max(axis=0)
    (second,) = [claim for claim in found if claim.place == "Fig 6, Case 2"]
    assert "/".join(f"{value:.3g}" for value in lines) in second.corrected


def test_what_the_model_says_of_the_paper(found):
    """Findings that must not turn round unnoticed; the numbers behind them are ours, the comparison is the paper's."""
    verdict = {claim.place: claim.verdict for claim in found}
    assert verdict["Eqs (4), (5), (7), (10)"] == "not reproduced"
    assert verdict["Fig 6, Case 2"] == verdict["Fig 7, Case 3"] == verdict["Fig 8, Case 4"] == "reproduced"
    assert verdict["Fig 5, Case 1"] == verdict["Figs 6 and 8"] == "partly"
    assert verdict["Eqs (12) to (15)"] == "not reproduced"


def test_verdicts_follow_the_numbers(fresh, monkeypatch):
    whole = paper_000._machine
    monkeypatch.setattr(paper_000, "_machine", lambda *, harmonics=True: whole(harmonics=False))
    assert paper_000._case_1().verdict == "reproduced"
    assert paper_000._case_2().verdict == "not reproduced"
    assert paper_000._odd_lines().verdict == "partly"


def test_a_stiff_rotation_turns_the_comparison_of_parallel_and_angular_round(fresh, monkeypatch):
    whole = paper_000._machine

    def stiff(*, harmonics=True):
        return whole(harmonics=harmonics).with_parameters(
            coupling_rotational_stiffness_n_m_rad=1397.0, coupling_stiffness_n_m=8e3
        )

    assert paper_000._parallel_against_angular().verdict == "reproduced"
    monkeypatch.setattr(paper_000, "_machine", stiff)
    for function in CACHED:
        function.cache_clear()
    assert paper_000._parallel_against_angular().verdict == "not reproduced"


def test_peak_speeds_of_a_known_sweep():
    speed = np.linspace(50, 4500, 20_000)
    signals = np.stack([np.exp(-(((speed - centre) / 100) ** 2)) * np.sin(speed) for centre in (1010.0, 3333.0)])
    np.testing.assert_allclose(paper_000._peak_speeds_rpm(signals, speed), [1025, 3325])


def test_reading_between_lines_is_a_sinc(found):
    (reading,) = [claim for claim in found if claim.place == "Eqs (12), (13)"]
    assert f" {math.sin(math.pi / 3) / (math.pi / 3):.3f}/" in reading.corrected
