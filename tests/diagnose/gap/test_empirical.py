"""What no effect explains is added as a force with its law: place, exponent and gain against a hidden truth.

Recordings are stepped in time on a machine whose support is 6 % stiffer than the model's.
"""

import dataclasses
import json
import math

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign, Recording
from rotorwise.datasets.simulated import record_machine
from rotorwise.diagnose.gap.empirical import as_effect
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.extended_file import extended_text
from rotorwise.diagnose.gap.json_form import as_json
from rotorwise.diagnose.gap.line_noise import weighted_amplitudes
from rotorwise.diagnose.gap.result import GapResult
from rotorwise.diagnose.gap.words import sentence_of
from rotorwise.diagnose.report.gap_page import render_gap
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effect import Effect
from rotorwise.simulators.effects.empirical_force import EmpiricalForce
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import Machine, machine_from_toml
from rotorwise.simulators.sensor_chain import SensorChain

#: No whole number of samples to a turn, where all pulses of the tacho would come late by the same part of a sample.
SPEEDS_RPM = (607.0, 911.0, 1307.0, 1693.0)
CHAIN = SensorChain(pulses_per_revolution=1, noise={"m": 2e-8, "rad": 2e-7})
REAL = rigid_coupling.with_parameters(support_2_n_m=1.06 * rigid_coupling.values["support_2_n_m"])
HIDDEN = Unbalance(at="rotor_2", moment_kg_m=8e-3, angle_rad=0.8)
#: What competes: nothing that could stand for a force of the shaft's order.
OTHERS = frozenset(("gravity", "soft_foot", "load_fluctuation"))
RUN = {"rate_hz": 500.0, "settle_s": 40.0}


def _recorded(machine: Machine, seed: int) -> tuple[Recording, ...]:
    return tuple(
        record_machine(machine, speed_rpm=rpm, duration_s=6.0, chain=CHAIN, seed=seed + i, **RUN).recording
        for i, rpm in enumerate(SPEEDS_RPM)
    )


@pytest.fixture(scope="module")
def healthy() -> tuple[Recording, ...]:
    return _recorded(REAL, 1)


def _explained(effect: Effect, healthy: tuple[Recording, ...], *, tacho: bool = True) -> GapResult:
    recordings = _recorded(REAL.with_effects(effect), 11)
    if not tacho:
        recordings, healthy = ([_without_tacho(one) for one in part] for part in (recordings, healthy))
    return explain_gap(Campaign(tuple(recordings), tuple(healthy)), rigid_coupling, only=OTHERS)


def _without_tacho(recording: Recording) -> Recording:
    kept = [i for i, channel in enumerate(recording.channels) if channel.quantity != "tacho"]
    channels = tuple(recording.channels[i] for i in kept)
    return dataclasses.replace(recording, signals=recording.signals[kept], channels=channels)


@pytest.fixture(scope="module")
def answer(healthy) -> GapResult:
    return _explained(HIDDEN, healthy)


def _line(machine: Machine, *, speed_rpm: float, probe: str) -> complex:
    run = machine.simulate(speed_rpm=speed_rpm, duration_s=2.0, **RUN)
    found = weighted_amplitudes(run.probe(probe)[None], turns=run.phase_rad / (2 * math.pi), orders=np.array([1.0]))
    return complex(found[0, 0])


def test_a_hidden_unbalance_is_an_unknown_force_that_turns_and_grows_as_speed_squared(answer):
    assert answer.kind == "unknown"
    assert not answer.causes
    assert [(one.order, one.at, one.direction) for one in answer.empirical] == [
        (1.0, "rotor_2", "x"),
        (1.0, "rotor_2", "y"),
    ]
    truth = HIDDEN.moment_kg_m * (2 * math.pi * answer.empirical[0].reference_speed_rpm / 60) ** 2
    for one, turned in zip(answer.empirical, (0.0, -math.pi / 2), strict=True):
        assert one.speed_exponent.low < 2.0 < one.speed_exponent.high
        assert one.speed_exponent.value == pytest.approx(2.0, abs=0.2)
        assert one.amplitude.low < truth < one.amplitude.high
        assert one.phase.low < HIDDEN.angle_rad + turned < one.phase.high
        assert one.share > 0.99


@pytest.mark.slow
def test_forces_that_spoil_what_was_not_fitted_are_not_added(healthy):
    # The unbalance acts at all speeds but the one that is held out.
    recordings = list(_recorded(REAL.with_effects(HIDDEN), 11))
    recordings[2] = _recorded(REAL, 31)[2]
    found = explain_gap(Campaign(tuple(recordings), tuple(healthy)), rigid_coupling, only=OTHERS)
    assert found.kind == "unknown"
    assert found.gain.held_out == (2,)
    assert not found.empirical
    assert any("would make the held-out error" in remark for remark in found.remarks)
    assert found.gain.held_out_db == pytest.approx(found.gain.calibration_only_db)


def test_the_gain_is_that_of_the_added_forces_on_a_speed_that_was_not_fitted(answer):
    gain = answer.gain
    assert gain.held_out
    assert gain.held_out_db > max(6.0, gain.calibration_only_db + 6.0)
    first = answer.measured.orders.index(1.0)
    held_out = answer.measured.amplitudes[gain.held_out[0], :4, first]
    before, after = (lines[gain.held_out[0], :4, first] for lines in (answer.before, answer.after))
    assert np.abs(after - held_out).max() < 0.1 * np.abs(before - held_out).max()


def test_the_extended_machine_shows_the_measured_line_in_time(answer):
    written = machine_from_toml(extended_text(answer))
    assert [effect.NAME for effect in written.effects] == ["empirical_force"] * 2
    for probe in ("rotor_2.x", "rotor_2.y"):
        wanted = _line(REAL.with_effects(HIDDEN), speed_rpm=1500.0, probe=probe)
        assert abs(_line(written, speed_rpm=1500.0, probe=probe) - wanted) < 0.1 * abs(wanted)
        # The machine without the force does not.
        assert abs(_line(answer.calibrated, speed_rpm=1500.0, probe=probe) - wanted) > 0.1 * abs(wanted)


def test_words_file_json_and_page_say_what_was_added(answer):
    words = sentence_of(answer)
    assert "Added, without a cause: force at 1X on rotor_2" in words
    assert "growing as speed^2.0 (" in words
    text = extended_text(answer)
    assert text.count('effect = "empirical_force"  # its cause is unknown') == 2
    assert "No effect was added" not in text
    formed = json.loads(json.dumps(as_json(answer), allow_nan=False))
    assert [one["direction"] for one in formed["empirical"]] == ["x", "y"]
    assert formed["empirical"][0]["speed_exponent"]["low"] == answer.empirical[0].speed_exponent.low
    assert "Added: empirical forces" in render_gap(answer)


@pytest.mark.slow
def test_a_force_of_one_direction_and_another_law_is_found_as_such(healthy):
    hidden = EmpiricalForce(
        at="rotor_2", force_n=60.0, direction_rad=math.pi / 2, phase_rad=-1.0, order=2.0, speed_exponent=0.0
    )
    answer = _explained(hidden, healthy)
    assert answer.kind == "unknown"
    assert [(one.order, one.at, one.direction) for one in answer.empirical] == [(2.0, "rotor_2", "y")]
    (one,) = answer.empirical
    assert one.speed_exponent.low < 0.0 < one.speed_exponent.high
    assert one.amplitude.low < 60.0 < one.amplitude.high
    assert one.phase.low < -1.0 < one.phase.high
    made = as_effect(one)
    assert (made.order, made.direction_rad) == (2.0, pytest.approx(math.pi / 2))


@pytest.mark.slow
def test_without_a_tacho_nothing_is_added_and_it_says_why(healthy):
    answer = _explained(HIDDEN, healthy, tacho=False)
    assert answer.kind == "unknown"
    assert not answer.empirical
    assert answer.extended == answer.calibrated
    assert any("without one tacho pulse a turn" in remark for remark in answer.remarks)
