"""What a model may lack: a coupling is asked for forces at the orders that are missed, at no others."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import start
from rotorwise.diagnose.gap.lacking_terms import lacking_terms, missed_orders
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.simulators.effects.residual_coupling_harmonic import ResidualCouplingHarmonic
from rotorwise.simulators.machine import find_machine

ORDERS = (1.0, 2.0, 3.0)
CONDITIONS = tuple(Condition(speed) for speed in (900.0, 1200.0, 1500.0))


def _lines(away: np.ndarray) -> OrderLines:
    """Return lines of one probe that lie ``away`` (conditions, orders) deviations from nothing."""
    amplitudes = away[:, None, :] * (0.6 + 0.8j)
    return OrderLines(CONDITIONS, ("a",), ORDERS, amplitudes, np.ones(amplitudes.shape), (LineKind(),) * 3)


def test_an_order_is_missed_that_stands_out_in_two_conditions():
    nothing: Any = SimpleNamespace(lines=np.zeros((3, 1, 3), dtype=complex))
    away = np.array([[4.0, 6.0, 50.0], [4.0, 6.0, 0.0], [4.0, 0.0, 0.0]])
    assert missed_orders(nothing, _lines(away)) == {2.0}


@pytest.mark.parametrize(("name", "ways"), [("test_rig", 5), ("amb_rotor", 4), ("rigid_coupling", 2)])
def test_a_coupling_is_asked_for_forces_at_missed_orders_only(name: str, ways: int) -> None:
    machine = find_machine(name)
    probes = tuple(p.name for p in machine.bare_assembly().probes if p.quantity in ("displacement", "acceleration"))
    kinds, count = (LineKind(),) * len(ORDERS), len(CONDITIONS)
    predictor = Predictor(CONDITIONS, probes, ORDERS, (4e3,) * count, (16_000,) * count, kinds, (0,) * len(ORDERS))
    current = start(machine, predictor)
    for missed in (frozenset[float](), frozenset({2.0}), frozenset({2.0, 3.0, 4.0})):
        terms = lacking_terms(current, predictor, reference_rpm=1500.0, missed=missed)
        found = [one.effect.order for one in terms if isinstance(one.effect, ResidualCouplingHarmonic)]
        assert sorted(found) == sorted(
            [*(ways * [2.0] if 2.0 in missed else []), *(ways * [3.0] if 3.0 in missed else [])]
        )
