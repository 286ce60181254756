"""Two causes that cancel most of what each makes are said to work against each other."""

from types import SimpleNamespace

import numpy as np
import pytest
from rotorwise.diagnose.gap import opposing
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines, stacked
from rotorwise.diagnose.gap.opposing import not_named_words, opposing_words, rest_of_both, undoes

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


@pytest.mark.parametrize(
    ("first", "second", "undone"),
    [
        # The second takes back from 1X what the first puts there, where nothing was missed.
        ([9.0, 5.0], [0.0, -5.0], True),
        # It makes 1X, which was missed.
        ([9.0, 0.0], [0.0, 8.0], False),
        # What it makes is too small to be seen: that tells nothing.
        ([9.0, 0.0], [0.0, -2.0], False),
    ],
)
def test_a_second_cause_that_only_undoes_what_the_first_makes_is_none(first, second, undone):
    made = [np.array([[own]], dtype=complex) for own in (first, second)]
    missed = np.array([[[9.0, 8.0 if second[1] > 0 else 0.0]]], dtype=complex)
    kinds, seen = (LineKind(),) * 2, np.ones((1, 1, 2))
    lines = OrderLines((Condition(900.0),), ("rotor.x",), (3.0, 1.0), missed, seen, kinds)
    reals = [stacked(own, lines.parts) for own in (missed, missed - made[0] - made[1])]
    plain, pair = (SimpleNamespace(lines=lines, factor=np.eye(4), residual=own) for own in reals)
    fit = SimpleNamespace(candidates=[None, None], compared=pair, residual=pair.residual)
    assert undoes(fit, made, plain) == undone  # type: ignore[arg-type]
    fit.candidates = [None]
    assert not undoes(fit, made[:1], plain)  # type: ignore[arg-type]
