"""Runs of the gearbox for the claims: a run is made once, whoever asks for it and beside whatever else."""

import dataclasses

import numpy as np
import pytest
from rotorwise.simulators.assembly import Probe
from rotorwise.simulators.papers import gearbox_runs, paper_001
from rotorwise.simulators.papers.gearbox_runs import (
    ORDERS,
    PLAUSIBLE_RECORD,
    PRINTED_RECORD,
    Case,
    line_amplitude,
    simulate_cases,
)
from rotorwise.simulators.solvers.simulate import Simulation

_SHORT = {"duration_s": 0.05, "settle_s": 0.02, "step_s": 1 / 60000}


def test_a_run_is_made_once_and_does_not_depend_on_its_company(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gearbox_runs, "_made", {})
    one, two = Case(rotor_hz=25.0), Case(rotor_hz=25.0, unbalance_kg_m=1e-4)
    together = simulate_cases("plausible", [one, two, one], **_SHORT)
    asked: list[int] = []
    real = gearbox_runs.simulate_batch
    monkeypatch.setattr(
        gearbox_runs, "simulate_batch", lambda cases, **how: asked.append(len(cases)) or real(cases, **how)
    )
    again = simulate_cases("plausible", [one], **_SHORT)
    assert asked == []
    assert again[one] is together[one]
    # Another record, preset or case is another run.
    other = simulate_cases("plausible", [one], **{**_SHORT, "settle_s": 0.01})
    assert asked == [1]
    assert not np.array_equal(other[one].probe("accelerometer"), together[one].probe("accelerometer"))
    gearbox_runs._made.clear()
    alone = simulate_cases("plausible", [one], **_SHORT)
    np.testing.assert_array_equal(alone[one].signals, together[one].signals)
    assert not np.array_equal(together[one].signals, together[two].signals)


@pytest.mark.parametrize("record", [PLAUSIBLE_RECORD, PRINTED_RECORD], ids=["plausible", "as_printed"])
def test_records_are_long_enough_to_part_the_closest_lines(record: dict[str, float]) -> None:
    """7 f_o1 + 4 f_r1 lies 0.54 Hz above f_m - f_r1 at 30 Hz: a line of 1 there reads below 2 % here."""
    count = round(record["duration_s"] * gearbox_runs.RATE_HZ)
    wanted, beside = ORDERS["f_m-f_r1"], 7 * ORDERS["f_o1"] + 4
    assert 0 < (beside - wanted) * 30 < 1
    time = np.arange(count) / gearbox_runs.RATE_HZ
    signal = np.cos(2 * np.pi * 30 * beside * time)
    read = line_amplitude(signal, frequency_hz=30 * wanted, rate_hz=gearbox_runs.RATE_HZ)
    assert read < 0.02
    half = line_amplitude(signal[: count // 2], frequency_hz=30 * wanted, rate_hz=gearbox_runs.RATE_HZ)
    assert half > 0.4


def test_every_condition_of_a_case_is_in_its_identity() -> None:
    base = Case()
    for field in dataclasses.fields(Case):
        assert dataclasses.replace(base, **{field.name: 0.0123}) != base


def fake_runs(monkeypatch: pytest.MonkeyPatch, **signals: np.ndarray) -> None:
    rows = [name.replace("_", " ") for name in signals]
    probes = tuple(Probe(name, "displacement", "m", "", "", {}) for name in rows)
    time = np.zeros(next(iter(signals.values())).size)
    run = Simulation(np.array(list(signals.values())), gearbox_runs.RATE_HZ, probes, time, time, 1e-5)
    monkeypatch.setattr(paper_001, "simulate_cases", lambda preset, cases, **how: dict.fromkeys(cases, run))


def test_a_wheel_beyond_its_play_is_pressed_into_its_bearings(monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(40000) / gearbox_runs.RATE_HZ
    swing = 8e-6 * np.sin(2 * np.pi * 385 * time)
    for rest_m, verdict in ((-6e-6, "reproduced"), (4e-6, "not reproduced")):
        fake_runs(monkeypatch, wheel_x=swing, wheel_y=swing + rest_m)
        claim = paper_001._floating_wheel()
        assert claim.verdict == verdict
        assert "swings by 8 um, most at 385 Hz" in claim.as_printed


def test_a_motion_whose_halves_differ_is_irregular(monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(40000) / gearbox_runs.RATE_HZ
    wave = np.sin(2 * np.pi * 30 * ORDERS["f_o1"] * time)
    fake_runs(monkeypatch, accelerometer=wave)
    assert paper_001._steadiness().endswith("rms 0.707 and 0.707, f_o1 1 and 1 m/s2")
    fake_runs(monkeypatch, accelerometer=wave * np.where(time < 2, 1.0, 1.1))
    assert paper_001._steadiness().endswith("f_o1 1 and 1.1 m/s2: an irregular motion")
