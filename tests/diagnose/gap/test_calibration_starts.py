"""Calibration from other starts: a resonance that lies at another speed than the model has it hides the way."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.gap import calibration_starts
from rotorwise.diagnose.gap.baseline import start
from rotorwise.diagnose.gap.calibration import calibrated
from rotorwise.diagnose.gap.calibration_starts import from_other_starts
from rotorwise.diagnose.gap.healthy_evidence import is_explained
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.simulators.effects.residual_coupling_harmonic import ResidualCouplingHarmonic
from rotorwise.simulators.machine import Machine, find_machine

from .made_campaigns import altered

#: 3X along the shaft passes a resonance of the rig on its mounts.
PUSHED = find_machine("test_rig").with_effects(
    ResidualCouplingHarmonic(order=3.0, x_cosine_n=0.0, axial_cosine_n=0.05, y_sine_n=0.05)
)
ORDERS, NOISE = (1.0, 2.0, 3.0), 1e-4


def _predictor() -> Predictor:
    conditions = tuple(Condition(speed) for speed in (1080.0, 1380.0, 1740.0, 2190.0, 2670.0, 3060.0))
    probes = tuple(one.name for one in PUSHED.bare_assembly().probes if one.quantity == "acceleration")
    return Predictor(conditions, probes, ORDERS, (5e3,) * 6, (25_000,) * 6, (LineKind(),) * 3, (0,) * 3)


def _lines(machine: Machine, predictor: Predictor) -> OrderLines:
    generator, lines = np.random.default_rng(3), predictor.amplitudes(machine)
    noise = NOISE * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    return OrderLines(predictor.conditions, predictor.probes, ORDERS, lines + noise, np.full(lines.shape, NOISE))


@pytest.mark.slow
def test_a_machine_on_another_hill_is_found() -> None:
    predictor = _predictor()
    healthy = _lines(altered(PUSHED, share=0.06, seed=4), predictor)
    first = calibrated(PUSHED, healthy, predictor)
    assert not is_explained(first, healthy)
    assert is_explained(from_other_starts(first, PUSHED, healthy, predictor), healthy)


@pytest.mark.parametrize(("explains", "missed", "settled"), [(True, 1.0, 2), (False, 0.9, 6), (False, 0.01, 7)])
def test_where_no_start_explains_the_lines_the_calibration_stays_as_it_was(
    monkeypatch, explains, missed, settled
) -> None:
    # One that comes far closer goes on, and counts for nothing if that explains nothing.
    predictor, machine = _predictor(), find_machine("test_rig")
    given = start(machine, replace(predictor, conditions=predictor.conditions[:2]))
    other: Any = SimpleNamespace(machine=machine)
    monkeypatch.setattr(calibration_starts, "_nearest", lambda *_: [given] * 5)
    monkeypatch.setattr(calibration_starts, "again", lambda *_: given)
    tried = []
    monkeypatch.setattr(calibration_starts, "settled", lambda *_, **__: tried.append(1) or other)
    monkeypatch.setattr(calibration_starts, "is_explained", lambda one, _: one is other and explains)
    monkeypatch.setattr(calibration_starts, "_missed", lambda one, _: missed if one is other else 1.0)
    lines: Any = None
    assert from_other_starts(given, machine, lines, predictor) is (other if explains else given)
    assert len(tried) == settled
