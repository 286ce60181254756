"""Which effects are followed after the first look, and beside which of them a second one is looked for."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from rotorwise.diagnose.gap import search, two_effects
from rotorwise.diagnose.gap.evidence import Widened

NOTHING = -100_000.0


@dataclass(frozen=True)
class _InTime:
    name: str
    strengths: tuple[int, ...] = (0,)

    def on(self, machine: object, position: object) -> None:
        """Return what `repeats` takes."""


def _followed(monkeypatch: pytest.MonkeyPatch, scores: dict[str, float]) -> list[str]:
    """Return the names of those that are followed of effects which are all simulated in time."""
    monkeypatch.setattr(search, "nothing", lambda compared: SimpleNamespace(log_evidence=NOTHING))
    monkeypatch.setattr(search, "chance_of_residual", lambda fit: 0.0)

    def start(name: str, score: float) -> SimpleNamespace:
        return SimpleNamespace(candidate=_InTime(name), position=None, score=score)

    ranked = [[start(name, score)] for name, score in sorted(scores.items(), key=lambda item: -item[1])]
    problem = SimpleNamespace(
        baseline=SimpleNamespace(machine=None), predictor=SimpleNamespace(repeats=lambda machine: False)
    )
    screening = SimpleNamespace(best=lambda: ranked, compared=None)
    kept, _ = search._worth_following(screening, problem, None)  # type: ignore[arg-type]
    return [options[0].candidate.name for options in kept]


def test_a_contact_is_followed_that_explains_nearly_as_much_on_a_coarse_grid(monkeypatch) -> None:
    # A rub of 1e5 squared deviations: between the points of the grid it lacks hundreds, and is the right answer.
    scores = {"looseness": 4000.0, "rub": 3400.0, "oil_whirl": -20_000.0}
    assert _followed(monkeypatch, scores) == ["looseness", "rub"]


def test_where_little_is_to_be_explained_a_little_behind_is_too_far(monkeypatch) -> None:
    scores = {"looseness": NOTHING + 900.0, "rub": NOTHING + 650.0, "oil_whirl": NOTHING + 500.0}
    assert _followed(monkeypatch, scores) == ["looseness", "rub"]


def test_a_line_is_standardised_by_what_the_others_let_expect() -> None:
    generator = np.random.default_rng(2)
    factor = np.tril(generator.normal(size=(5, 5))) + 3 * np.eye(5)
    directions, line = generator.normal(size=(2, 5)), generator.normal(size=5)
    covariance = factor @ (np.eye(5) + directions.T @ directions) @ factor.T
    found = Widened(directions).standardised(np.linalg.solve(factor, line), factor)
    for i in range(5):
        others = [j for j in range(5) if j != i]
        weights = np.linalg.solve(covariance[np.ix_(others, others)], covariance[others, i])
        left = line[i] - weights @ line[others]
        assert found[i] == pytest.approx(left / np.sqrt(covariance[i, i] - weights @ covariance[others, i]))


@pytest.mark.parametrize(("standing_out", "gains"), [(0.3, False), (5.0, False), (9.0, True)])
def test_a_clear_line_is_worth_a_second_effect_though_the_sum_is_that_of_noise(
    standing_out: float, gains: bool
) -> None:
    # Sizes scatter by a third of what they may: 400 of them leave less than noise would, a clear one among them or not.
    residual = 0.3 * np.random.default_rng(3).normal(size=400)
    residual[7] = standing_out
    law = np.zeros((0, 400))
    leader = SimpleNamespace(
        residual=residual, compared=None, law=law, power=float(residual @ residual), log_evidence=10.0
    )
    assert leader.power < 400
    assert two_effects.may_gain(leader, 10.0) == gains  # type: ignore[arg-type]
