"""Two causes that cancel most of what each makes are said to work against each other."""

from types import SimpleNamespace

import numpy as np
import pytest
from rotorwise.diagnose.gap import opposing
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.opposing import not_named_words, opposing_words, rest_of_both, same_orders_at_one_speed

FIRST = np.array([[[3.0 + 1j, 2.0, -1.0j]]])


def _made(monkeypatch, *each: np.ndarray):
    """Return a fit of causes that make these lines, in lines of unit noise, and its problem."""
    compared = SimpleNamespace(whitened=lambda lines: np.concatenate([np.real(lines).ravel(), np.imag(lines).ravel()]))
    effects = [SimpleNamespace(NAME=name, at=at) for name, at in (("shaft_bow", "shaft"), ("unbalance", "disc"))]
    fit = SimpleNamespace(
        candidates=[Candidate(effect, ()) for effect in effects[: len(each)]],  # type: ignore[arg-type]
        compared=compared,
        position=np.zeros(0),
        response=sum(each),
        problem=None,
    )
    problem = SimpleNamespace(baseline=SimpleNamespace(machine=None), predictor=None)
    responses = SimpleNamespace(own=lambda position, added: list(each))
    monkeypatch.setattr(opposing, "Responses", lambda *_: responses)
    return fit, problem


def _said(monkeypatch, *each: np.ndarray) -> tuple[str, ...]:
    return opposing_words(*_made(monkeypatch, *each))


def test_what_cancels_is_told_with_what_is_left(monkeypatch):
    (said,) = _said(monkeypatch, FIRST, -0.8 * FIRST)
    # (1 - 0.8)^2 / (1 + 0.8^2)
    assert said.startswith("Shaft bow and unbalance work against each other: together they make 2% of")


@pytest.mark.parametrize("share", [-0.3, 0.0, 0.5, 1.0, 1j])
def test_what_adds_up_or_is_a_small_part_is_not_told(monkeypatch, share):
    assert _said(monkeypatch, FIRST, share * FIRST) == ()


def test_one_cause_has_nothing_to_work_against(monkeypatch):
    assert _said(monkeypatch, FIRST) == ()


@pytest.mark.parametrize(("share", "rest"), [(-1.0, 0.0), (-0.5, 0.2), (0.0, 1.0), (1.0, 2.0), (1j, 1.0)])
def test_the_rest_of_both_in_closed_form(monkeypatch, share, rest):
    assert rest_of_both(*_made(monkeypatch, FIRST, share * FIRST)) == pytest.approx(rest)


def test_why_two_causes_are_not_named(monkeypatch):
    said = not_named_words(*_made(monkeypatch, FIRST, -0.8 * FIRST))
    assert said.startswith("Shaft bow at shaft and unbalance at disc would explain it, but only against each other, as")
    assert "2.4% of the power" in said


def _at(monkeypatch, speeds_rpm: tuple[float, ...], *each: np.ndarray):
    fit, problem = _made(monkeypatch, *(np.repeat(own, len(speeds_rpm), axis=0) for own in each))
    conditions = tuple(Condition(speed) for speed in speeds_rpm)
    shape = fit.response.shape
    problem.lines = OrderLines(conditions, ("a",), (1.0, 2.0, 3.0), np.zeros(shape, dtype=complex), np.ones(shape))
    return fit, problem


@pytest.mark.parametrize(
    ("speeds_rpm", "second", "is_one"),
    [
        ((1480.0, 1482.0), [2.0, 0.5, 0.0], True),
        ((1480.0, 1482.0), [0.5, 3.0, 0.0], False),
        ((1480.0, 1800.0), [2.0, 0.5, 0.0], False),
    ],
)
def test_two_that_make_the_same_orders_at_one_speed_may_be_one(monkeypatch, speeds_rpm, second, is_one):
    first, other = np.array([[[2j, 0.3, 0.0]]]), np.array([[second]])
    fit, problem = _at(monkeypatch, speeds_rpm, first, other)
    assert same_orders_at_one_speed(fit, problem) == is_one
    if is_one:
        said = not_named_words(fit, problem)
        assert "all recordings are of one speed" in said
        assert said.endswith("Record at another speed.")


def test_one_cause_at_one_speed_is_one(monkeypatch):
    assert not same_orders_at_one_speed(*_at(monkeypatch, (1480.0,), FIRST))
