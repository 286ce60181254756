"""The gain of an extended model: its statistics, its phase reference, what differs between the machines."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rotorwise.simulators.effects.empirical_force import EmpiricalForce
from scipy.stats import binomtest

sys.path.insert(0, str(Path(__file__).resolve().parent))
import extension_rows
from cases import cases
from extension_gain import gained, kinds, was_seen, wilson
from extension_machines import pulses_of_first_order
from extension_rows import table_of_machine, with_forces
from rig_calibration import bench


@pytest.mark.parametrize(("right", "count"), [(0, 4), (3, 4), (17, 17)])
def test_wilsons_interval_is_scipys(right: int, count: int) -> None:
    expected = binomtest(right, count).proportion_ci(method="wilson")
    assert wilson(right, count) == pytest.approx((expected.low, expected.high), abs=1e-4)


def test_a_gain_is_one_of_pairs() -> None:
    before = np.array([False] * 10)
    assert gained(before, before) == (0.0, 0.0, 0.0)
    assert gained(before, ~before) == (1.0, 1.0, 1.0)
    mean, low, high = gained(before, np.arange(10) < 5)
    assert mean == 0.5
    assert 0.1 <= low < 0.5 < high <= 0.9


def test_pulses_stand_where_the_first_order_has_its_maxima() -> None:
    rate_hz, speed_hz = 20000.0, 20.3
    time = np.arange(40000) / rate_hz
    noise = np.random.default_rng(0).normal(0.0, 0.5, time.size)
    signal = np.cos(2 * np.pi * speed_hz * time - 0.7) + 0.8 * np.cos(2 * np.pi * 3 * speed_hz * time) + noise
    pulses = pulses_of_first_order(signal, rate_hz, 1200.0)
    at = np.flatnonzero((pulses[1:-1] > pulses[:-2]) & (pulses[1:-1] >= pulses[2:]) & (pulses[1:-1] > 0.9)) + 1
    turns = speed_hz * at / rate_hz - 0.7 / (2 * np.pi)
    assert abs(at.size - 2 * speed_hz) <= 1
    assert np.abs(turns - np.round(turns)).max() < 0.03


def test_forces_take_the_place_of_unbalance_and_of_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extension_rows, "STATES", (("healthy", 2), ("unbalance", 1)))
    monkeypatch.setattr(extension_rows, "DURATION_S", 0.6)
    plain = table_of_machine(bench(), draws=1, seed=3)
    force = EmpiricalForce(at="disc", force_n=500.0, order=3.0)
    forced = with_forces(plain, bench(), [force], draws=1, seed=3)
    other = forced.labels == "unbalance"
    assert np.array_equal(forced.values[~other], plain.values[~other], equal_nan=True)
    third = plain.names.index("3x_level")
    assert (forced.values[other, third] > plain.values[other, third] + 0.5).all()


def test_nothing_is_judged_that_the_engine_saw() -> None:
    names = {one.name for one in cases() if was_seen(SimpleNamespace(case=one))}
    assert names == {f"ADI {speed} {what}" for speed in (1200, 2400) for what in ("healthy", "imbalance VHIL")}
    rows = kinds(
        [SimpleNamespace(case=SimpleNamespace(name="ADI 1800 imbalance VHIL"), truth="unbalance", visible=True)]
    )
    assert [name for name, chosen in rows.items() if chosen.any()] == ["unbalance at 1800 rpm"]
