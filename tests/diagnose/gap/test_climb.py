"""The way to the best values: to the least squares where the law is narrow, and not to where it excuses anything."""

from types import SimpleNamespace

import numpy as np
import pytest
from rotorwise.diagnose.gap import climb as climbing
from rotorwise.diagnose.gap.climb import climb
from rotorwise.diagnose.gap.evidence import Widened

#: What is to be explained: 4 deviations of one real, and 3 of another that the effect does not make.
WANTED = np.array([4.0, 3.0])


class _Straight:
    """An effect whose only line is as large as its coordinate."""

    chosen = ()

    def __call__(self, position):
        return np.array([position[0], 0.0])

    def slopes(self, position, added, alive):
        return np.array([[1.0, 0.0]])

    def own(self, position, added):
        return [added]

    def prepare(self, positions, *, near):
        return [True]

    def steps(self, position):
        return False


def _climbed(monkeypatch, excuse):
    """Return where a climb from 0 ends, its law allowing for ``excuse`` of the other real where the line exceeds 2."""

    def laws_of(compared, chosen, responses):
        wide = responses[0][0] > 2.0
        return Widened(np.array([[0.0, excuse]]) if wide else np.zeros((0, 2)))

    monkeypatch.setattr(climbing, "laws_of", laws_of)
    compared = SimpleNamespace(residual=WANTED, whitened=lambda lines: lines)
    return climb(_Straight(), np.zeros(1), np.full(1, 1e-6), compared, 12)


def test_it_ends_where_the_squares_are_least(monkeypatch):
    found = _climbed(monkeypatch, 1e-3)
    assert found.position[0] == pytest.approx(4.0, rel=1e-3)
    assert found.objective == pytest.approx(0.5 * 3.0**2, rel=1e-3)


def test_a_wider_law_on_the_way_is_no_hindrance(monkeypatch):
    assert _climbed(monkeypatch, 1e3).position[0] == pytest.approx(4.0, rel=1e-3)


def test_it_does_not_go_where_the_law_excuses_anything(monkeypatch):
    assert _climbed(monkeypatch, 1e12).position[0] <= 2.0
