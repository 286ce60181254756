"""Healthy lines about a calibrated machine: what it hardly makes tells nothing of what it is made of."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.calibration import calibrated
from rotorwise.diagnose.gap.healthy_evidence import fitted
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.simulators import amb_rotor

from .made_campaigns import altered

SPEEDS_RPM, ORDERS, NOISE_M = (4796.0, 4803.0), (1.0, 2.0, 3.0, 4.0), 1e-9


def _healthy(run_out_m: float) -> tuple[OrderLines, Predictor]:
    """Return lines of a machine whose probes see four marks on its shaft, which is no motion, and the predictor."""
    probes = tuple(one.name for one in amb_rotor.bare_assembly().probes if one.quantity == "displacement")
    conditions, count = tuple(Condition(speed) for speed in SPEEDS_RPM), len(SPEEDS_RPM)
    kinds = (LineKind(),) * len(ORDERS)
    predictor = Predictor(conditions, probes, ORDERS, (1e4,) * count, (20_000,) * count, kinds, (0,) * len(ORDERS))
    lines, generator = predictor.amplitudes(altered(amb_rotor, share=0.02, seed=3)).copy(), np.random.default_rng(4)
    lines[:, :, 3] += run_out_m * np.exp(2j * np.pi * generator.random(len(probes)))
    lines += NOISE_M * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    return OrderLines(conditions, probes, ORDERS, lines, np.full(lines.shape, NOISE_M)), predictor


def _moved(run_out_m: float) -> np.ndarray:
    """Return by how many standard deviations of its prior each unknown still wants to move once calibrated."""
    healthy, predictor = _healthy(run_out_m)
    found = calibrated(amb_rotor, healthy, predictor)
    change, _ = fitted(found, healthy)
    return np.abs(change / found.prior)


def test_a_calibrated_machine_is_where_its_lines_put_it() -> None:
    assert _moved(0.0).max() < 0.3


@pytest.mark.parametrize("run_out_m", [2e-7, 5e-7])
def test_marks_on_the_shaft_do_not_move_the_machine(run_out_m: float) -> None:
    # Twenty times what the machine makes there.
    assert _moved(run_out_m).max() < 0.3
