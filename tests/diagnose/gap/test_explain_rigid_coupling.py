"""A hidden effect must be found, nothing must be called nothing, and what is not in the catalogue unknown.

Recordings are stepped in time on machines whose own parameters differ from the model's; the engine balances harmonics.
"""

import dataclasses

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign, Recording
from rotorwise.diagnose.gap import explain as module
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.words import verdict_words
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effects.looseness import Looseness
from rotorwise.simulators.effects.torque_ripple import TorqueRipple
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import Machine

from .made_campaigns import recorded

SPEEDS_RPM = (600.0, 900.0, 1300.0, 1700.0)
#: A part of the catalogue, where all of it would take a minute more.
RIVALS = frozenset(
    ("looseness", "rub", "soft_foot", "support_anisotropy", "unbalance", "bolt_loss", "run_out", "remounted_sensor")
)
HIDDEN = Unbalance(at="rotor_2", moment_kg_m=8e-3, angle_rad=0.8)
RIPPLE = TorqueRipple(at="rotor_2", torque_n_m=8.0, order=3.0, angle_rad=0.4)


def _recorded(machine: Machine, seed: int) -> tuple[Recording, ...]:
    return recorded(machine, SPEEDS_RPM, rate_hz=500.0, duration_s=6.0, seed=seed, settle_s=40.0)


@pytest.fixture(scope="session")
def real() -> Machine:
    return rigid_coupling.with_parameters(support_2_n_m=1.06 * rigid_coupling.values["support_2_n_m"])


@pytest.fixture(scope="session")
def healthy(real) -> tuple[Recording, ...]:
    return _recorded(real, 1)


@pytest.fixture(scope="session")
def unbalanced(real, healthy) -> Campaign:
    return Campaign(_recorded(real.with_effects(HIDDEN), 11), healthy)


def test_the_hidden_unbalance_is_found_and_the_extended_machine_is_closer(unbalanced, real):
    # One test, as the search takes half a minute and test processes do not share it.
    answer = explain_gap(unbalanced, rigid_coupling)
    assert answer.kind == "one cause"
    cause = answer.causes[0]
    assert (cause.effect, cause.at) == ("unbalance", "rotor_2")
    assert cause.probability > 0.95
    moment, angle = cause.parameters["moment_kg_m"], cause.parameters["angle_rad"]
    assert moment.value == pytest.approx(HIDDEN.moment_kg_m, rel=0.03)
    assert moment.low < HIDDEN.moment_kg_m < moment.high
    assert angle.low < HIDDEN.angle_rad < angle.high
    assert answer.residuals[0].order == 1.0

    # On a condition that was not fitted.
    gain = answer.gain
    assert gain.held_out
    assert gain.held_out_db > gain.calibration_only_db + 6
    assert gain.held_out_db > gain.smooth_function_db

    # The machine that is written back simulates what was measured, at a speed that was not.
    truth = real.with_effects(HIDDEN)
    options = {"speed_rpm": 1100.0, "duration_s": 2.0, "rate_hz": 500.0, "settle_s": 40.0}
    wanted, found = truth.simulate(**options), answer.extended.simulate(**options)
    away = found.probe("rotor_2.x") - wanted.probe("rotor_2.x")
    assert np.std(away) < 0.05 * np.std(wanted.probe("rotor_2.x"))


def test_nothing_is_called_nothing(real, healthy):
    found = explain_gap(Campaign(_recorded(real, 21), healthy), rigid_coupling)
    assert found.kind == "none"
    assert not found.causes


def test_what_is_not_in_the_catalogue_is_unknown(unbalanced):
    # Whatever can stand for an unbalance at one rotor is left out.
    rivals = frozenset(("support_anisotropy", "soft_foot", "gravity", "remounted_sensor"))
    found = explain_gap(unbalanced, rigid_coupling, only=rivals)
    assert found.kind == "unknown"
    assert not found.causes


def test_what_acts_on_the_healthy_machine_as_well_is_no_cause_of_a_change(unbalanced):
    found = explain_gap(unbalanced, rigid_coupling, only=frozenset({"gravity", "unbalance"}))
    assert [cause.effect for cause in found.causes] == ["unbalance"]
    assert found.not_compared["gravity"] == "acts on the healthy machine as well"
    alone = Campaign(unbalanced.recordings[:2])
    other = explain_gap(alone, rigid_coupling, only=frozenset({"gravity"})).not_compared
    assert other["gravity"] == "adds nothing to the lines that are compared here"


@pytest.mark.slow
def test_a_torque_that_only_torsion_shows_is_found():
    # Torque ripple turns the shafts against each other and bends nothing: the proximity probes see nothing of it.
    healthy, later = (
        recorded(machine, SPEEDS_RPM, rate_hz=500.0, duration_s=6.0, seed=seed, torsion=True, settle_s=40.0)
        for machine, seed in ((rigid_coupling, 41), (rigid_coupling.with_effects(RIPPLE), 51))
    )
    found = explain_gap(
        Campaign(later, healthy), rigid_coupling, only=frozenset({"torque_ripple", "unbalance", "gravity", "run_out"})
    )
    assert [cause.effect for cause in found.causes] == ["torque_ripple"]


@pytest.mark.slow
def test_a_defect_of_the_waveform_does_not_stand_for_lines_that_nothing_explains(unbalanced):
    def coarse(record: Recording) -> Recording:
        step = record.signals[0].std() / 8
        signals = np.concatenate([np.round(record.signals[:1] / step) * step, record.signals[1:]])
        return dataclasses.replace(record, signals=signals)

    campaign = Campaign(tuple(coarse(one) for one in unbalanced.recordings), unbalanced.baseline)
    found = explain_gap(campaign, rigid_coupling, only=frozenset({"gravity"}))
    assert found.kind == "unknown"
    assert [cause.effect for cause in found.causes] == ["quantisation"]
    assert "The waveform shows quantisation at" in verdict_words(found)
    # Left out of the catalogue, it is not looked for.
    assert not explain_gap(
        campaign, rigid_coupling, only=frozenset({"gravity"}), without=frozenset({"quantisation"})
    ).causes


@pytest.mark.slow
def test_samples_lost_at_every_probe_do_not_hide_the_cause(unbalanced):
    def lossy(record: Recording) -> Recording:
        lost = np.random.default_rng(record.samples).random(record.signals.shape) < 0.03
        lost[[channel.quantity == "tacho" for channel in record.channels]] = False
        return dataclasses.replace(record, signals=np.where(lost, np.nan, record.signals))

    campaign = Campaign(tuple(lossy(one) for one in unbalanced.recordings), unbalanced.baseline)
    found = explain_gap(campaign, rigid_coupling, only=frozenset({"unbalance", "support_anisotropy", "gravity"}))
    assert [cause.effect for cause in found.causes] == ["dropped_samples", "unbalance"]
    moment = found.causes[1].parameters["moment_kg_m"]
    assert moment.low < HIDDEN.moment_kg_m < moment.high
    assert found.gain.held_out_db > found.gain.calibration_only_db + 6


def test_without_hypotheses_the_effect_is_not_found(unbalanced, monkeypatch):
    monkeypatch.setattr(module, "candidates", lambda machine, **which: ())
    found = explain_gap(unbalanced, rigid_coupling)
    assert found.kind == "unknown"
    assert not found.causes


def test_channels_that_are_no_probes_are_refused(unbalanced):
    from rotorwise.simulators.errors import InvalidValueError

    other = dataclasses.replace(
        unbalanced.recordings[0],
        channels=tuple(dataclasses.replace(c, name=f"{c.name}?") for c in unbalanced.recordings[0].channels),
    )
    with pytest.raises(InvalidValueError, match="No channel is a probe"):
        explain_gap(Campaign((other,)), rigid_coupling)


@pytest.mark.slow
def test_a_cause_that_grew_in_the_condition_held_out_is_not_named(unbalanced, real):
    grown = dataclasses.replace(HIDDEN, moment_kg_m=2 * HIDDEN.moment_kg_m)
    later = recorded(real.with_effects(grown), SPEEDS_RPM[2:3], rate_hz=500.0, duration_s=6.0, seed=31, settle_s=40.0)
    recordings = (*unbalanced.recordings[:2], *later, *unbalanced.recordings[3:])
    found = explain_gap(Campaign(recordings, unbalanced.baseline), rigid_coupling, only=RIVALS)
    assert found.gain.held_out == (2,)
    assert found.kind == "unknown"
    assert "misses the held-out conditions by more than noise" in found.remarks[1]


@pytest.mark.slow
def test_a_loose_support_is_found(real, healthy):
    # It lifts off at some of the speeds only: from most starts the search ends on a hill between.
    loose = Looseness(at="support_2", loss=0.984, hold=0.053, rounding=0.2)
    found = explain_gap(Campaign(_recorded(real.with_effects(loose), 41), healthy), rigid_coupling, only=RIVALS)
    assert (found.kind, [cause.effect for cause in found.causes]) == ("one cause", ["looseness"])
    # How much exactly is another matter: the hold trades for it, and the interval is too narrow (README, limits).
    assert found.causes[0].at == "support_2"
    assert found.causes[0].parameters["loss"].value > 0.95
