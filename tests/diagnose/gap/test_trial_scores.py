"""Scores of blind trials in closed form, with engines that know the truth, say nothing, or guess; runs that go on."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.lines import OrderLines
from rotorwise.diagnose.gap.result import Cause, Estimate, Gain, GapResult
from rotorwise.diagnose.gap.trials import run
from rotorwise.diagnose.gap.trials.cases import Hidden, TrialCase
from rotorwise.diagnose.gap.trials.outcome import Named, Outcome, Truth, from_line, outcome_of, to_line
from rotorwise.diagnose.gap.trials.picture import confusion_svg, reliability_svg
from rotorwise.diagnose.gap.trials.run import TrialFileError, Trials, run_trials
from rotorwise.diagnose.gap.trials.scores import Scores, as_json, score
from rotorwise.simulators.effect import Effect, make_effect
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine

COMMAND = Path(sys.executable).with_name("rotorwise")
MACHINE = find_machine("amb_rotor")
TRIALS = Trials("amb_rotor", 1, 30.0)
#: Kind, hidden effects and their d2 of ten trials that take no time.
TEN = (
    ("none", (), ()),
    ("one", ("unbalance",), (10.0,)),
    ("one", ("unbalance",), (500.0,)),
    ("two", ("rub", "run_out"), (50.0, 700.0)),
    ("unknown", ("shaft_bow",), (900.0,)),
    ("none", (), ()),
    ("one", ("rub",), (60.0,)),
    ("one", ("run_out",), (800.0,)),
    ("two", ("unbalance", "shaft_bow"), (300.0, 400.0)),
    ("unknown", ("unbalance",), (300.0,)),
)
JSON_NAMES = {
    "n",
    "top1",
    "named_wrong",
    "null_false_alarm",
    "unknown_recall",
    "pair_exact",
    "pair_any",
    "calibration_error",
    "coverage90",
    "gain_db",
    "oracle_gain_db",
    "seconds_per_trial",
}


def made_case(
    machine: str,
    *,
    number: int,
    seed: int,
    snr_db: float,
    family: str,
    wrong_form: float = 0.0,
    anywhere: bool = False,
) -> TrialCase:
    kind, names, sizes = TEN[number % len(TEN)]
    hidden = tuple(Hidden(make_effect(name, {}), size) for name, size in zip(names, sizes, strict=True))
    left_out = frozenset(names) if kind == "unknown" else frozenset()
    campaign = Campaign((), name=str(number))
    return TrialCase(number, kind, find_machine(machine), campaign, hidden, left_out, sum(sizes), None, 0.0, True, 0)


def result(kind: str, effects: tuple[Effect, ...] = (), *, probability: float = 1.0, gain: float = 0.0) -> GapResult:
    """Return a result that states ``kind`` and names effects, each value in an interval of 1 % about it."""
    causes = tuple(Cause(e.NAME, e.at, probability, estimates(e), "") for e in effects)
    names = tuple(sorted(e.NAME for e in effects)) or (("unknown",) if kind == "unknown" else ())
    other = ("torque_ripple",)
    none = np.zeros((0, 0, 0), complex)
    return GapResult(
        kind=kind,
        causes=causes,
        probabilities={names: probability, other: 1 - probability},
        indistinguishable=(),
        next_measurement="",
        sentence="",
        residuals=(),
        gain=Gain(gain, 0.0, 0.0, 0.0, ()),
        detectability=0.0,
        misfit=1.0,
        measured=OrderLines((), (), (), none, none.real),
        before=none,
        after=none,
        machine=MACHINE,
        calibrated=MACHINE,
        extended=MACHINE,
        not_compared={},
    )


def estimates(effect: Effect) -> dict[str, Estimate]:
    width = {name: 0.01 * abs(value) + 1e-12 for name, value in effect.values().items()}
    return {name: Estimate(v, v - width[name], v + width[name], "") for name, v in effect.values().items()}


def hidden_in(campaign: Campaign) -> tuple[str, tuple[Effect, ...]]:
    kind, names, _ = TEN[int(campaign.name or 0) % len(TEN)]
    return kind, tuple(make_effect(name, {}) for name in names)


def knows(campaign: Campaign, machine: Any, *, without: Any = frozenset(), only: Any = None) -> GapResult:
    kind, effects = hidden_in(campaign)
    if kind == "unknown":
        assert without == {e.NAME for e in effects}
        return result("unknown")
    told = {"none": "none", "one": "one cause", "two": "several causes"}[kind]
    return result(told, effects, gain=14.0 if only else 12.0)


def says_none(campaign: Campaign, machine: Any, *, without: Any = frozenset()) -> GapResult:
    return result("none", probability=0.75)


def guesses(campaign: Campaign, machine: Any, *, without: Any = frozenset()) -> GapResult:
    return result("one cause", (make_effect("unbalance", {"moment_kg_m": 0.05}),), probability=0.6, gain=-3.0)


def fails(campaign: Campaign, machine: Any, *, without: Any = frozenset()) -> GapResult:
    raise ZeroDivisionError("a bug in the engine")


@pytest.fixture(autouse=True)
def quick_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "make_case", made_case)


def scores_of(engine: Any, count: int = 10) -> Scores:
    return score(run_trials(TRIALS, count, engine))


# ---- theory: engines whose scores are known ----


def test_an_engine_that_knows_the_truth_is_always_right() -> None:
    found = scores_of(knows)
    assert (found.n, found.top1, found.named_wrong, found.null_false_alarm) == (10, 1.0, 0.0, 0.0)
    assert (found.unknown_recall, found.pair_exact, found.pair_any, found.calibration_error) == (1.0, 1.0, 1.0, 0.0)
    assert (found.coverage90, found.gain_db, found.oracle_gain_db, found.errors) == (1.0, 12.0, 14.0, 0)
    assert found.top1_by_d2 == {"below 20": (1, 1.0), "20 to 100": (1, 1.0), "100 and more": (2, 1.0)}
    assert all(truth == answer for truth, answer in found.confusion)


def test_an_engine_that_always_says_none() -> None:
    found = scores_of(says_none)
    assert (found.top1, found.named_wrong, found.null_false_alarm, found.unknown_recall) == (0.0, 0.0, 0.0, 0.0)
    assert (found.pair_exact, found.pair_any) == (0.0, 0.0)
    # It states 0.75 and is right in two of ten.
    assert found.calibration_error == pytest.approx(0.75 - 0.2)
    assert math.isnan(found.coverage90)
    # It offers no way to consider the true effects only.
    assert math.isnan(found.oracle_gain_db)


def test_an_engine_that_guesses() -> None:
    found = scores_of(guesses)
    # Two of four single causes are unbalance; of the two pairs one holds it.
    assert found.top1 == 0.5
    assert found.top1_by_d2["100 and more"] == (2, 0.5)
    assert (found.null_false_alarm, found.unknown_recall, found.pair_exact, found.pair_any) == (1.0, 0.0, 0.0, 0.5)
    # Wrong in two singles, one pair and both unknowns (where unbalance was left out of one); of eight.
    assert found.named_wrong == pytest.approx(5 / 8)
    assert found.calibration_error == pytest.approx(0.6 - 0.2)
    # The intervals of angle and offset hold the truth, the moment's does not: two singles and a pair.
    assert found.coverage90 == pytest.approx(2 / 3)
    assert found.gain_db == -3.0
    assert found.by_effect["unbalance"]["top1"] == 1.0
    assert found.by_effect["rub"]["named_wrong"] == 1.0


def test_an_engine_that_fails_ends_no_run() -> None:
    found = scores_of(fails)
    assert (found.n, found.errors, found.top1, found.named_wrong, found.null_false_alarm) == (10, 10, 0.0, 0.0, 0.0)
    outcome = run_trials(TRIALS, 1, fails)[0]
    assert outcome.error == "ZeroDivisionError: a bug in the engine"


def test_a_wrong_form_and_angles_anywhere_reach_the_cases_and_as_given_the_engine(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shares, orders = [], []

    def noted(machine: str, *, wrong_form: float = 0.0, anywhere: bool = False, **draw: Any) -> TrialCase:
        shares.append((wrong_form, anywhere))
        return made_case(machine, **draw)

    def told(campaign: Campaign, machine: Any, *, as_given: bool = False, **how: Any) -> GapResult:
        orders.append(as_given)
        return says_none(campaign, machine, **how)

    monkeypatch.setattr(run, "make_case", noted)
    wrong = replace(TRIALS, wrong_form=0.15)
    for trials in (TRIALS, wrong, replace(wrong, as_given=True), replace(TRIALS, anywhere=True)):
        assert not run_trials(trials, 1, told)[0].error
    assert shares == [(0.0, False), (0.15, False), (0.15, False), (0.0, True)]
    assert orders == [False, False, True, False]


# ---- theory: single rules ----


def one_outcome(**changes: Any) -> Outcome:
    hidden = (Truth("unbalance", "disc", {"moment_kg_m": 1e-4, "angle_rad": 3.0}, 500.0),)
    plain = Outcome(0, "one", hidden, 500.0, None, 0.0, True, "one cause")
    return replace(plain, **changes)


def test_angles_count_modulo_a_full_turn() -> None:
    intervals = {"moment_kg_m": [1e-4, 9e-5, 1.1e-4], "angle_rad": [-3.2, -3.4, -3.0]}
    named = (Named("unbalance", "disc", 1.0, intervals),)
    assert score([one_outcome(named=named)]).coverage90 == 1.0
    shifted = (Named("unbalance", "disc", 1.0, {**intervals, "angle_rad": [-2.5, -2.7, -2.3]}),)
    assert score([one_outcome(named=shifted)]).coverage90 == 0.5
    elsewhere = (Named("unbalance", "coupling_hub", 1.0, intervals),)
    assert math.isnan(score([one_outcome(named=elsewhere)]).coverage90)


def test_what_the_waveform_shows_belongs_to_each_of_a_declared_set() -> None:
    case = made_case("amb_rotor", number=8, seed=1, snr_db=30.0, family="tune")
    clipping, unbalance = Hidden(make_effect("clipping", {}), 900.0), case.hidden[0]
    answer = replace(
        result("several causes", (make_effect("clipping", {}), make_effect("shaft_bow", {}))),
        indistinguishable=(("shaft_bow", "unbalance"),),
    )
    assert outcome_of(replace(case, hidden=(clipping, unbalance)), answer, seconds=1.0).is_right
    assert not outcome_of(replace(case, hidden=(unbalance,)), answer, seconds=1.0).is_right


def test_a_declared_set_that_holds_the_truth_is_right() -> None:
    named = (Named("shaft_bow", "shaft", 0.6, {}),)
    alone = one_outcome(named=named)
    assert score([alone]).top1 == 0.0
    assert score([alone]).named_wrong == 1.0
    declared = one_outcome(named=named, together=(("shaft_bow", "unbalance"),))
    assert score([declared]).top1 == 1.0
    assert score([declared]).named_wrong == 0.0
    foreign = one_outcome(named=named, together=(("rub", "unbalance"),))
    assert score([foreign]).top1 == 0.0


def test_an_imperfection_that_is_named_is_there() -> None:
    rub = Truth("rub", "", {}, 2.0)
    named = (Named("unbalance", "disc", 1.0, {}), Named("rub", "", 0.9, {}))
    assert score([one_outcome(named=named, verdict="several causes")]).named_wrong == 1.0
    assert score([one_outcome(named=named, verdict="several causes", imperfection=rub)]).named_wrong == 0.0


def test_a_wrong_name_below_one_half_is_not_firm() -> None:
    assert score([one_outcome(named=(Named("rub", "", 0.49, {}),))]).named_wrong == 0.0
    assert score([one_outcome(named=(Named("rub", "", 0.5, {}),))]).named_wrong == 1.0


def test_cannot_tell_is_neither_right_nor_wrong_nor_an_alarm() -> None:
    unsure = one_outcome(verdict="cannot tell")
    null = replace(unsure, kind="none", hidden=(), d2=0.0)
    found = score([unsure, null])
    assert (found.top1, found.named_wrong, found.null_false_alarm) == (0.0, 0.0, 0.0)


def test_unknown_is_an_alarm_where_nothing_is_hidden() -> None:
    null = one_outcome(verdict="unknown", kind="none", hidden=(), d2=0.0)
    assert score([null, replace(null, verdict="none")]).null_false_alarm == 0.5


def test_calibration_of_two_bins_in_closed_form() -> None:
    right = [one_outcome(probabilities={"unbalance": 0.95, "nothing": 0.05})] * 9
    wrong = [one_outcome(probabilities={"rub": 0.95, "nothing": 0.05})]
    half = [one_outcome(probabilities={name: 0.55, "nothing": 0.45}) for name in ("unbalance", "rub", "rub", "rub")]
    found = score([*right, *wrong, *half])
    assert found.calibration_error == pytest.approx((10 * 0.05 + 4 * 0.3) / 14)
    assert [(b.count, b.right) for b in found.reliability if b.count] == [(4, 0.25), (10, 0.9)]


def test_what_changes_nothing_may_be_called_nothing() -> None:
    silent = Truth("unbalance", "disc", {}, 0.2)
    says = {"nothing": 1.0}
    unseen = one_outcome(verdict="none", hidden=(silent,), d2=0.2, probabilities=says)
    assert score([unseen]).calibration_error == 0.0
    assert score([unseen]).top1 == 0.0
    assert score([one_outcome(verdict="none", probabilities=says)]).calibration_error == 1.0


def test_scores_of_nothing_are_null_in_json() -> None:
    data = as_json(score([]))
    assert data["n"] == 0
    assert data["top1"] is None
    assert set(data) >= JSON_NAMES
    json.dumps(data, allow_nan=False)


# ---- runs ----


def test_outcomes_survive_the_file_and_a_stopped_run_goes_on(tmp_path: Path) -> None:
    file, asked = tmp_path / "outcomes.jsonl", []

    def counted(campaign: Campaign, machine: Any, *, without: Any = frozenset()) -> GapResult:
        asked.append(int(campaign.name or 0))
        return guesses(campaign, machine)

    first = run_trials(TRIALS, 4, counted, file=file)
    # Killed while it wrote the last line.
    file.write_text(file.read_text()[:-25])
    again = run_trials(TRIALS, 6, counted, file=file)
    assert asked == [0, 1, 2, 3, 3, 4, 5]
    assert [one.number for one in again] == list(range(6))
    assert [to_line(one) for one in again[:3]] == [to_line(one) for one in first[:3]]
    shorter = run_trials(TRIALS, 2, counted, file=file)
    assert [to_line(one) for one in shorter] == [to_line(from_line(to_line(one))) for one in again[:2]]
    assert len(asked) == 7


def test_a_file_of_other_trials_is_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "outcomes.jsonl"
    run_trials(TRIALS, 1, says_none, file=file)
    before = file.read_text()
    with pytest.raises(TrialFileError, match="holds other trials"):
        run_trials(replace(TRIALS, seed=2), 1, says_none, file=file)
    assert file.read_text() == before
    file.write_text("my notes\n")
    with pytest.raises(TrialFileError, match="my notes"):
        run_trials(TRIALS, 1, says_none, file=file)
    assert file.read_text() == "my notes\n"


@pytest.mark.parametrize(("count", "jobs"), [(0, 1), (1, 0)])
def test_counts_below_one_are_refused(count: int, jobs: int) -> None:
    with pytest.raises(InvalidValueError, match="allowed: 1 or more"):
        run_trials(TRIALS, count, says_none, jobs=jobs)


# ---- pictures and command ----


def test_pictures_show_every_count() -> None:
    found = scores_of(guesses)
    drawn = ElementTree.fromstring(confusion_svg(found, title="a < b"))
    words = [element.text for element in drawn.iter() if element.text]
    assert "a < b" in words
    assert "two effects (2)" in words
    # All answers are unbalance: 2 nulls, 2 singles right, 1 rub, 1 run_out, 2 pairs, 2 unknown.
    assert sorted(word for word in words if word.isdigit()) == ["1", "1", "2", "2", "2", "2"]
    plot = ElementTree.fromstring(reliability_svg(found, title="t"))
    assert len(plot.findall("{http://www.w3.org/2000/svg}circle")) == 1


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("--machine", "toaster"), "toaster"),
        (("--n", "0"), "--n 0"),
        (("--jobs", "0"), "--jobs 0"),
        (("--seed", "-1"), "-1"),
        (("--snr-db", "nan"), "nan"),
        (("--snr-db", "30,5"), "30.5"),
        (("--family", "both"), "both"),
    ],
)
def test_command_refuses_bad_values(tmp_path: Path, words: tuple[str, str], named: str) -> None:
    options = {"--machine": "amb_rotor", "--n": "2", "--seed": "1", "--snr-db": "30", **dict([words])}
    told = [word for pair in options.items() for word in pair]
    done = subprocess.run(
        [str(COMMAND), "trials", *told], capture_output=True, text=True, timeout=60, check=False, cwd=tmp_path
    )
    assert done.returncode == 2
    assert named in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
