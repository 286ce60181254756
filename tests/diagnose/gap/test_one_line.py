"""A re-mounted sensor that one line tells comes with a warning; one that several lines tell does not."""

from types import SimpleNamespace

import numpy as np
import pytest
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.lines import LineKind
from rotorwise.diagnose.gap.one_line import one_line_words
from rotorwise.simulators.effects import RemountedSensor, Unbalance


def _fit(response, effect=RemountedSensor, *, beside=frozenset()):
    """Return a fit of one effect that adds these lines, (conditions, probes, orders), in unit noise."""
    response = np.array(response, dtype=complex)
    seen = np.ones(response.shape, dtype=bool)
    seen[0, 1, 2] = False
    lines = SimpleNamespace(
        seen=seen,
        deviations=np.where(seen, 1.0, np.inf),
        kinds=(LineKind(),) * 3,
        orders=(0.5, 1.0, 2.0),
        probes=("rotor.x", "rotor.y"),
    )
    one = Candidate(effect(at="rotor.y"), ())
    return SimpleNamespace(
        candidates=(one,), unknown_beside=beside, response=response, compared=SimpleNamespace(lines=lines)
    )


ONE = [[[0.1, 0.2, 0.0], [0.0, 20.0 + 5j, 900.0]], [[0.0, 0.3j, 0.0], [0.0, 30.0, 4.0]]]


def test_the_line_is_said_where_it_tells_nearly_alone():
    (said,) = one_line_words(_fit(ONE))  # type: ignore[arg-type]
    assert said.startswith("Remounted sensor is told by 1X at rotor.y nearly alone")


@pytest.mark.parametrize(
    "fit",
    [
        _fit([[[0.1, 0.2, 0.0], [0.0, 20.0, 0.0]], [[0.0, 0.3, 0.0], [0.0, 30.0, 15.0]]]),
        _fit([[[0.1, 20.0, 0.0], [0.0, 20.0, 0.0]], [[0.0, 30.0, 0.0], [0.0, 30.0, 4.0]]]),
        _fit(ONE, Unbalance),
        _fit(ONE, beside=frozenset({2})),
    ],
    ids=["two orders", "two probes", "on the machine", "beside something unknown"],
)
def test_nothing_is_said_where_more_tells_it_or_the_machine_is_meant(fit):
    assert one_line_words(fit) == ()
