"""The held-out conditions as a witness: chances against simulation, and which names they withdraw."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap import held_out
from rotorwise.diagnose.gap.evidence import comparison
from rotorwise.diagnose.gap.held_out import checked
from rotorwise.diagnose.gap.judged import judged
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.posterior import Posterior
from rotorwise.diagnose.gap.prediction import Predicted, given_others, left_out

from .test_gap_evidence import _baseline

LEFT, RIGHT, UNKNOWN = ("left",), ("right",), ("unknown",)


def test_of_a_true_hypothesis_every_chance_is_as_frequent_as_it_says():
    generator = np.random.default_rng(3)
    shape = (3, 2, 2)
    conditions = tuple(Condition(speed) for speed in (600.0, 700.0, 1300.0))
    lines = OrderLines(conditions, ("a", "b"), (1.0, 2.0), np.ones(shape, dtype=complex), np.ones(shape))
    compared = comparison(lines, _baseline(3, np.array([0.5]), np.zeros(1)), None, None, np.full((2, 2), 0.3))
    directions = generator.normal(size=(3, compared.residual.size))
    chances = []
    for _ in range(2000):
        drawn = generator.normal(size=compared.residual.size) + generator.normal(size=3) @ directions
        chances.append(given_others(compared, drawn, directions, [1]).chance)
    # Of 2000 draws a share p has a standard deviation of sqrt(p (1 - p) / 2000).
    for share in (0.05, 0.5, 0.95):
        assert np.mean(np.array(chances) < share) == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / 2000))


def test_one_condition_given_the_others_is_a_part_of_the_sum_over_all():
    shape = (3, 2, 2)
    generator = np.random.default_rng(5)
    conditions = tuple(Condition(speed) for speed in (600.0, 700.0, 1300.0))
    amplitudes = generator.normal(size=shape) + 1j * generator.normal(size=shape)
    lines = OrderLines(conditions, ("a", "b"), (1.0, 2.0), amplitudes, np.ones(shape))
    compared = comparison(lines, _baseline(3, np.array([0.5]), np.zeros(1)), None, None, np.full((2, 2), 0.3))
    directions = generator.normal(size=(2, compared.residual.size))
    alone = sum(given_others(compared, compared.residual, directions, [i]).log_density for i in range(3))
    assert alone == pytest.approx(left_out(compared, compared.residual, directions))


def _after(
    monkeypatch: pytest.MonkeyPatch,
    shares: dict[tuple[str, ...], float],
    densities: dict[tuple[str, ...], float],
    *,
    chance: float = 0.5,
    gains: dict[tuple[str, ...], float] | None = None,
    unknown: float = 0.0,
    all_chance: float = 1.0,
    evidences: dict[tuple[str, ...], float] | None = None,
    repeats: bool = True,
    healthy: bool = True,
    smooth: float = 0.0,
    witness: tuple[int, ...] = (1,),
) -> tuple[Posterior, tuple[str, ...]]:
    logs = dict.fromkeys(shares, 0.0) | (evidences or {})
    named = [one for one in shares if one and one != UNKNOWN]
    fits: Any = [SimpleNamespace(names=one, log_evidence=logs[one], position=np.zeros(2)) for one in named]
    none: Any = SimpleNamespace(names=(), log_evidence=logs[()] - 4.0)
    something: Any = SimpleNamespace(log_evidence=0.0)
    compared: Any = None
    posterior = Posterior(compared, none, tuple(fits), something, shares, 0.5)
    monkeypatch.setattr(held_out, "_unknown_density", lambda *_: unknown)

    def predicted(fit: Any, _: Any, moves: int = 0) -> Predicted | None:
        one = densities.get(fit.names)
        return None if one is None else Predicted(one, min(chance, all_chance), chance)

    monkeypatch.setattr(held_out, "predicted", predicted)
    own = gains or dict.fromkeys(shares, 10.0)
    monkeypatch.setattr(held_out, "predicted_db", lambda fits, _: [own[fit.names] for fit in fits])
    monkeypatch.setattr(held_out, "smooth_db", lambda parameters, _: smooth if parameters == 2 else np.nan)
    predictor = SimpleNamespace(repeats=lambda machine: repeats)
    baseline, known = SimpleNamespace(machine=None), object() if healthy else None
    prepared: Any = SimpleNamespace(held_out=witness, predictor=predictor, baseline=baseline, healthy=known)
    return checked(prepared, posterior)


def test_where_the_leading_effect_predicts_best_nothing_changes(monkeypatch):
    shares = {LEFT: 0.97, RIGHT: 0.02, (): 0.005, UNKNOWN: 0.005}
    found, remarks = _after(monkeypatch, shares, {LEFT: 5.0, RIGHT: 1.0, (): -30.0})
    assert found.probabilities == pytest.approx(shares)
    assert not remarks


def test_an_effect_that_predicts_better_draws_level_and_does_not_pass(monkeypatch):
    shares = {LEFT: 0.97, RIGHT: 0.02, (): 0.005, UNKNOWN: 0.005}
    found, remarks = _after(monkeypatch, shares, {LEFT: 5.0, RIGHT: 30.0, (): -30.0})
    assert found.probabilities[RIGHT] == pytest.approx(0.97 / (2 * 0.97 + 0.01))
    kind, names, together = judged(found.probabilities)
    assert (kind, names, together) == ("one cause", LEFT, [LEFT, RIGHT])
    assert remarks == ("The held-out conditions are predicted better by right than by left.",)


def test_a_little_better_adds_only_what_it_tells(monkeypatch):
    shares = {LEFT: 0.97, RIGHT: 0.02, (): 0.005, UNKNOWN: 0.005}
    found, _ = _after(monkeypatch, shares, {LEFT: 5.0, RIGHT: 6.0, (): -30.0})
    assert found.probabilities[RIGHT] / found.probabilities[LEFT] == pytest.approx(np.e * 0.02 / 0.97)


def test_nothing_at_all_may_take_a_name_away(monkeypatch):
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    found, _ = _after(monkeypatch, shares, {LEFT: -40.0, (): 0.0})
    assert judged(found.probabilities)[0] == "none"


@pytest.mark.parametrize("unknown", [20.0, -10.0])
@pytest.mark.parametrize("chance", [1e-3, 1e-12, 0.0])
def test_what_misses_the_held_out_conditions_is_unknown_if_that_predicts_them_better(monkeypatch, chance, unknown):
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    found, remarks = _after(monkeypatch, shares, {LEFT: 5.0, (): 0.0}, chance=chance, unknown=unknown)
    if chance == 1e-3:
        assert found.probabilities == pytest.approx(shares)
        assert not remarks
    else:
        assert judged(found.probabilities)[0] == ("unknown" if unknown > 5.0 else "one cause")
        assert remarks[0].startswith("With left the model misses the held-out conditions")


@pytest.mark.parametrize(("own", "left_by_nothing", "kind"), [(-0.4, 0.9, "none"), (0.4, 0.9, "one cause"),
                                                              (-0.4, 1e-4, "one cause")])  # fmt: skip
def test_no_name_where_the_held_out_lines_gain_nothing_and_nothing_is_missed(monkeypatch, own, left_by_nothing, kind):
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    monkeypatch.setattr(held_out, "chance_of_residual", lambda _: left_by_nothing)
    found, remarks = _after(monkeypatch, shares, {LEFT: 5.0, (): 4.5}, gains={LEFT: own})
    assert judged(found.probabilities)[0] == kind
    assert bool(remarks) is (kind == "none")


@pytest.mark.parametrize(("own", "repeats", "kind"), [(0.2, False, "none"), (0.4, False, "one cause"),
                                                      (0.2, True, "one cause"), (-0.2, True, "none")])  # fmt: skip
def test_without_a_density_the_gain_has_to_be_one_where_nothing_is_missed(monkeypatch, own, repeats, kind):
    # Clearly one on a machine that does not repeat itself, whose sizes are predicted to a factor.
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    monkeypatch.setattr(held_out, "chance_of_residual", lambda _: 0.9)
    found, remarks = _after(monkeypatch, shares, {(): 4.5}, gains={LEFT: own}, repeats=repeats)
    assert judged(found.probabilities)[0] == kind
    assert bool(remarks) is (kind == "none")


@pytest.mark.parametrize(("own", "left_by_nothing", "kind"), [(-0.1, 0.9, "one cause"), (-0.4, 0.9, "unknown"),
                                                              (-0.1, 1e-4, "unknown")])  # fmt: skip
def test_where_nothing_is_missed_in_the_held_out_lines_only_they_confirm_nothing(
    monkeypatch, own, left_by_nothing, kind
):
    # A contact in time that is closed at the speed held out: it makes nothing there, and nothing is there.
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    monkeypatch.setattr(held_out, "chance_of_residual", lambda _: 1e-4)
    found, remarks = _after(monkeypatch, shares, {(): 4.5}, gains={LEFT: own}, chance=left_by_nothing)
    assert judged(found.probabilities)[0] == kind
    assert ("do not confirm it" in "".join(remarks)) is (kind == "one cause")


@pytest.mark.parametrize(("own", "smooth", "left_by_nothing", "has_density", "kind"), [
    # 11 % of the error is gone, and 28 or 31 %.
    (0.5, 1.4, 1e-4, False, "one cause"), (0.5, 1.6, 1e-4, False, "unknown"),
    # 50 %, and 99 %.
    (3.0, 20.0, 1e-4, False, "one cause"), (2.8, 20.0, 1e-4, False, "unknown"),
    # Nothing to be seen there, and a density that says it better.
    (0.5, 1.6, 0.9, False, "one cause"), (0.5, 1.6, 1e-4, True, "one cause"),
])  # fmt: skip
def test_without_a_density_a_smooth_function_that_is_clearly_nearer_takes_the_name(
    monkeypatch, own, smooth, left_by_nothing, has_density, kind
):
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    monkeypatch.setattr(held_out, "chance_of_residual", lambda _: 1e-4)
    densities = {(): 4.5} | ({LEFT: 5.0} if has_density else {})
    chances = {"chance": 0.5, "all_chance": left_by_nothing}
    found, remarks = _after(monkeypatch, shares, densities, gains={LEFT: own}, smooth=smooth, **chances)
    assert judged(found.probabilities)[0] == kind
    assert (f"by {smooth} dB with a smooth function of speed" in "".join(remarks)) is (kind == "unknown")


@pytest.mark.parametrize(("own", "kind"), [(-0.8, "one cause"), (-1.2, "unknown")])
def test_a_name_with_which_the_held_out_lines_are_clearly_farther_is_none(monkeypatch, own, kind):
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    monkeypatch.setattr(held_out, "chance_of_residual", lambda _: 1e-4)
    found, remarks = _after(monkeypatch, shares, {LEFT: 5.0, (): 4.5}, gains={LEFT: own})
    assert judged(found.probabilities)[0] == kind
    assert bool(remarks) is (kind == "unknown")


@pytest.mark.parametrize(("own", "kind"), [(-0.8, "one cause"), (-1.2, "unknown")])
def test_nor_is_one_that_misses_them_by_more_than_noise_though_something_unknown_does_no_better(monkeypatch, own, kind):
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    found, remarks = _after(monkeypatch, shares, {LEFT: 5.0, (): 0.0}, chance=1e-12, unknown=-10.0, gains={LEFT: own})
    assert judged(found.probabilities)[0] == kind
    assert ("no name" in remarks[0]) is (kind == "unknown")


def test_an_effect_whose_lines_lie_clearly_nearer_draws_level(monkeypatch):
    shares = {LEFT: 0.97, RIGHT: 1e-13, (): 0.02, UNKNOWN: 0.01}
    densities = {LEFT: 5.0, RIGHT: 5.0, (): -30.0}
    found, remarks = _after(monkeypatch, shares, densities, gains={LEFT: 14.9, RIGHT: 32.0})
    kind, names, together = judged(found.probabilities)
    assert (kind, names, together) == ("one cause", RIGHT, [RIGHT, LEFT])
    assert found.probabilities[RIGHT] == pytest.approx(found.probabilities[LEFT], rel=1e-4)
    assert remarks[0].endswith("the gain on these conditions is then no independent one.")
    found, remarks = _after(monkeypatch, shares, densities, gains={LEFT: 30.0, RIGHT: 32.0})
    assert found.probabilities == pytest.approx(shares)
    assert not remarks


def test_what_the_fitted_lines_speak_clearly_against_does_not_draw_level(monkeypatch):
    shares = {LEFT: 0.97, RIGHT: 1e-200, (): 0.02, UNKNOWN: 0.01}
    densities = {LEFT: 5.0, RIGHT: 5.0, (): -30.0}
    gains = {LEFT: 14.9, RIGHT: 32.0}
    found, remarks = _after(monkeypatch, shares, densities, gains=gains, evidences={RIGHT: -570.0})
    assert found.probabilities == pytest.approx(shares)
    assert not remarks


def test_one_of_two_names_alone_draws_level_whatever_the_fitted_lines_say(monkeypatch):
    both = (*LEFT, *RIGHT)
    shares = {both: 0.98, LEFT: 1e-96, (): 0.01, UNKNOWN: 0.01}
    densities = {both: 5.0, LEFT: 5.0, (): -30.0}
    gains = {both: 12.6, LEFT: 21.0}
    found, _ = _after(monkeypatch, shares, densities, gains=gains, evidences={LEFT: -220.0, (): -5e3})
    assert judged(found.probabilities)[1] == LEFT


def test_one_of_two_names_is_not_alone_where_lines_stand_out_that_it_does_not_make(monkeypatch):
    both = (*LEFT, *RIGHT)
    shares = {both: 0.98, LEFT: 1e-96, (): 0.01, UNKNOWN: 0.01}
    densities = {both: 5.0, LEFT: 5.0, (): -30.0}
    gains, evidences = {both: 12.6, LEFT: 21.0}, {LEFT: -220.0, (): -5e3}
    found, _ = _after(monkeypatch, shares, densities, gains=gains, evidences=evidences, all_chance=1e-9)
    assert judged(found.probabilities)[1] == both


def test_where_most_is_made_by_the_name_that_is_taken_away_the_other_is_not_alone(monkeypatch):
    both = (*LEFT, *RIGHT)
    shares = {both: 0.98, LEFT: 1e-200, (): 0.01, UNKNOWN: 0.01}
    densities = {both: 5.0, LEFT: 5.0, (): -30.0}
    gains = {both: 12.6, LEFT: 21.0}
    found, _ = _after(monkeypatch, shares, densities, gains=gains, evidences={LEFT: -3e3, (): -5e3})
    assert judged(found.probabilities)[0] == "unknown"


def test_lines_that_the_effect_does_not_make_are_told_and_take_no_name_away(monkeypatch):
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    found, remarks = _after(monkeypatch, shares, {LEFT: 5.0, (): 0.0}, all_chance=1e-9, unknown=20.0)
    assert found.probabilities == pytest.approx(shares)
    assert remarks == (
        "In the held-out conditions lines stand out that left does not make: something else acts there.",
    )


def test_the_chance_of_own_lines_is_that_of_these_alone():
    shape = (2, 1, 2)
    conditions = tuple(Condition(speed) for speed in (100.0, 10000.0))
    lines = OrderLines(conditions, ("a",), (1.0, 2.0), np.ones(shape, dtype=complex), np.ones(shape))
    alone = _baseline(2, np.array([1e-9]), np.zeros(1))
    alone = type(alone)(**{**vars(alone), "lines": np.zeros(shape), "slopes": np.zeros((1, *shape))})
    compared = comparison(lines, alone, None, None, np.full((1, 2), 0.1))
    order = np.concatenate([np.nonzero(part)[2] for part in lines.parts])
    # Only 2X is far off; the hypothesis makes 1X.
    residual = np.where(order == 1, 10.0, 0.0)
    found = given_others(compared, residual, np.zeros((0, residual.size)), [1], made=np.array([True, False]))
    assert found.chance < 1e-10
    assert found.own_chance == pytest.approx(1.0)


def test_nothing_at_all_that_predicts_beyond_any_number_takes_the_name_away(monkeypatch):
    shares = {LEFT: 0.97, (): 0.02, UNKNOWN: 0.01}
    found, _ = _after(monkeypatch, shares, {LEFT: -1e6, (): 0.0})
    assert judged(found.probabilities)[0] == "none"


@pytest.mark.parametrize("inexact", [0.5, 2.0])
def test_a_law_is_as_exact_in_the_held_out_conditions_as_in_the_fitted_ones(monkeypatch, inexact):
    conditions = tuple(Condition(speed) for speed in (600.0, 700.0, 1300.0))
    lines = OrderLines(conditions, ("a", "b"), (1.0, 2.0), np.ones((3, 2, 2), dtype=complex), np.ones((3, 2, 2)))
    compared = comparison(lines, _baseline(3, np.array([0.5]), np.zeros(1)), None, None, np.full((2, 2), 0.3))
    seen, none = [], np.zeros((1, 3, 2, 2), dtype=complex)

    class Stop(Exception):
        pass

    def law(found, *_):
        seen.append(found.inexact)
        raise Stop

    monkeypatch.setattr(held_out, "again", lambda *_: SimpleNamespace(lines=none[0]))
    monkeypatch.setattr(
        held_out, "Responses", lambda *_: SimpleNamespace(slopes=lambda *_: none, own=lambda *_: [none])
    )
    monkeypatch.setattr(held_out, "laws_of", law)
    fit: Any = SimpleNamespace(position=np.zeros(1), compared=SimpleNamespace(inexact=inexact), candidates=())
    fit.machine = lambda own: own
    predictor = SimpleNamespace(amplitudes=lambda _: none[0])
    problem: Any = SimpleNamespace(
        baseline=SimpleNamespace(machine=None), predictor=predictor, lines=lines, around=lambda *_: compared
    )
    with pytest.raises(Stop):
        held_out._given_fitted(fit, problem, [1])
    assert seen == [inexact]


@pytest.mark.parametrize("healthy", [True, False])
@pytest.mark.parametrize("left", [0.5, 1e-6])
def test_without_healthy_recordings_something_unknown_is_claimed_only_where_noise_does_not_do(
    monkeypatch, healthy, left
):
    shares = {UNKNOWN: 0.98, LEFT: 0.015, (): 0.005}
    monkeypatch.setattr(held_out, "chance_of_residual", lambda _: left)
    found, remarks = _after(monkeypatch, shares, {(): 0.0}, healthy=healthy)
    noise_does = not healthy and left > 0.1
    assert judged(found.probabilities)[0] == ("none" if noise_does else "unknown")
    assert [("Recordings of the healthy machine" in one) for one in remarks] == ([True] if noise_does else [])


@pytest.mark.parametrize(
    ("ahead", "left_by_nothing", "named"),
    [(9.0, 0.9, False), (11.0, 0.9, True), (9.0, 1e-3, True)],
    ids=["noise would do, told weakly", "told strongly", "nothing at all leaves more than noise"],
)
def test_without_a_condition_held_out_the_fitted_lines_must_tell_a_name_strongly(
    monkeypatch, ahead, left_by_nothing, named
):
    shares = {LEFT: 0.9, (): 0.09, UNKNOWN: 0.01}
    monkeypatch.setattr(held_out, "chance_of_residual", lambda _: left_by_nothing)
    # The evidence of nothing at all is 4 less than what is given here.
    found, remarks = _after(monkeypatch, shares, {}, evidences={LEFT: ahead - 4.0, (): 0.0}, witness=())
    assert next(iter(found.probabilities)) == (LEFT if named else ())
    assert bool(remarks) != named
    assert sum(found.probabilities.values()) == pytest.approx(1.0)
    if not named:
        assert "fourth speed" in remarks[0]
