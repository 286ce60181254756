"""Beside something unknown an effect is named for what several probes show in several conditions."""

from types import SimpleNamespace

import numpy as np
import pytest
from rotorwise.diagnose.gap.beside_unknown import shows_widely
from rotorwise.diagnose.gap.judged import judged
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.posterior import posterior_of


@pytest.mark.parametrize(
    ("sizes", "widely"),
    [
        ([[9.0, 9.0, 0.0], [9.0, 0.0, 0.0]], True),
        ([[9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], True),
        ([[9.0, 9.0, 9.0], [5.0, 5.0, 5.0]], False),
        ([[9.0, 0.0, 0.0], [9.0, 0.0, 0.0]], False),
        # The third probe is not seen.
        ([[9.0, 0.0, 9.0], [9.0, 0.0, 9.0]], False),
    ],
)
def test_several_probes_and_conditions_show_it(sizes, widely):
    deviations = np.ones((2, 3, 2))
    deviations[:, 2] = np.inf
    conditions = (Condition(600.0), Condition(900.0))
    lines = OrderLines(conditions, ("a", "b", "c"), (1.0, 2.0), np.zeros((2, 3, 2), dtype=complex), deviations)
    response = np.full((2, 3, 2), 20.0 + 0j)
    response[:, :, 0] = 1j * np.array(sizes)
    assert shows_widely(response, lines, 0) is widely


def test_a_single_probe_may_be_all_there_is():
    lines = OrderLines((Condition(600.0), Condition(900.0)), ("a",), (1.0,), np.zeros((2, 1, 1)), np.ones((2, 1, 1)))
    assert shows_widely(np.full((2, 1, 1), 9.0), lines, 0)


@pytest.mark.parametrize(("ahead", "named"), [(20.0, True), (0.0, False)])
def test_what_contradicts_its_law_elsewhere_makes_what_does_make_the_order_less_sure(ahead, named):
    def fit(*names, evidence):
        candidates = tuple(SimpleNamespace(name=name) for name in names)
        beside = frozenset({1}) if names else frozenset()
        return SimpleNamespace(
            names=(*names, "unknown")[: 2 * len(names)],
            candidates=candidates,
            log_evidence=evidence,
            unknown_beside=beside,
        )

    none, best = fit(evidence=-900.0), fit("unbalance", evidence=100.0)
    unknown, unlike = SimpleNamespace(log_evidence=70.0), [fit("rub", evidence=100.0 - ahead)]
    found = posterior_of(None, none, (best,), unknown, 30, [], unlike)  # type: ignore[arg-type]
    kind, names, _ = judged(found.probabilities)
    assert (kind, names) == ("unknown", ("unbalance", "unknown") if named else ("unknown",))
    usual = posterior_of(None, none, (best,), unknown, 30, [])  # type: ignore[arg-type]
    assert judged(usual.probabilities)[1] == ("unbalance", "unknown")
