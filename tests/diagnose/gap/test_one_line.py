"""A re-mounted sensor that one line tells comes with a warning; one that several lines tell does not."""

from types import SimpleNamespace

import numpy as np
import pytest
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.lines import LineKind
from rotorwise.diagnose.gap.one_line import one_line_words, told_by_one_line
from rotorwise.diagnose.gap.result import Cause
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
        names=(one.name,),
        candidates=(one,),
        unknown_beside=beside,
        response=response,
        compared=SimpleNamespace(lines=lines),
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


def test_what_one_line_tells_is_as_likely_something_outside_the_catalogue():
    causes = (Cause("remounted_sensor", "rotor.y", 0.97, {}, ""),)
    stated = {("remounted_sensor",): 0.96, ("remounted_sensor", "unbalance"): 0.01, ("unknown",): 0.03}
    (less,), told, other, to_tell = told_by_one_line(_fit(ONE), causes, stated)  # type: ignore[arg-type]
    assert less.probability == pytest.approx(0.49)
    assert sum(told.values()) == pytest.approx(1.0)
    assert told["remounted_sensor",] == pytest.approx(0.48)
    assert told["unknown",] == pytest.approx(0.51)
    assert other == ("unknown",)
    assert to_tell.startswith("Swap that sensor")


def test_what_several_lines_tell_stays_as_it_is():
    causes = (Cause("unbalance", "rotor.y", 1.0, {}, ""),)
    stated = {("unbalance",): 1.0}
    assert told_by_one_line(_fit(ONE, Unbalance), causes, stated) == (causes, stated, (), "")  # type: ignore[arg-type]
