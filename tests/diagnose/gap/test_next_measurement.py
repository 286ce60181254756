"""What these data cannot tell is a set with the measurement that would, never one confident name."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign, Recording
from rotorwise.datasets.simulated import record_machine
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.next_measurement import next_measurement
from rotorwise.diagnose.gap.words import sentence_of
from rotorwise.simulators import test_rig as rig
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import Machine
from rotorwise.simulators.sensor_chain import SensorChain

PLANE = ("housing_b_x", "housing_b_y")
CHAIN = SensorChain(pulses_per_revolution=1, noise={"m/s2": 1e-3, "rad/s": 1e-4})
ALIKE = frozenset(("unbalance", "shaft_bow", "coupling_misalignment"))


def _at_one_plane(machine: Machine, seed: int) -> Recording:
    found = record_machine(machine, speed_rpm=1500.0, duration_s=4.0, rate_hz=12800.0, chain=CHAIN, seed=seed).recording
    kept = [i for i, one in enumerate(found.channels) if one.name in PLANE or one.quantity == "tacho"]
    return dataclasses.replace(found, signals=found.signals[kept], channels=tuple(found.channels[i] for i in kept))


def test_unbalance_bow_and_misalignment_at_one_speed_and_one_plane_are_a_set():
    real = rig.with_parameters(
        disc_mass_kg=1.01 * rig.values["disc_mass_kg"], housing_x_hz=0.98 * rig.values["housing_x_hz"]
    )
    hidden = Unbalance(moment_kg_m=1e-4, angle_rad=0.8)
    campaign = Campaign((_at_one_plane(real.with_effects(hidden), 50),), (_at_one_plane(real, 10),))
    answer = explain_gap(campaign, rig, only=ALIKE)
    stated = max(answer.probabilities.values())
    assert stated < 0.9
    if answer.kind != "cannot tell":
        (together,) = answer.indistinguishable
        assert {"unbalance", "shaft_bow"} <= set(together)
        assert f"probability {stated:.2f}" in sentence_of(answer)
        assert "Not distinguishable here" in sentence_of(answer)
    assert "To tell: " in sentence_of(answer)
    # The rig runs below its bending critical speed: housings then feel a bow as an unbalance, at any such speed.
    assert "At these probes no speed from 900 to 1875 rpm separates" in answer.next_measurement
    assert "slow-roll vector" in answer.next_measurement


def _prepared(*speeds_rpm: float, tied: bool = True, healthy: bool = True) -> SimpleNamespace:
    conditions = tuple(Condition(speed, tied=tied) for speed in speeds_rpm)
    shape = (len(conditions), 1, 1)
    lines = OrderLines(conditions, ("a",), (1.0,), np.zeros(shape, dtype=complex), np.ones(shape))
    return SimpleNamespace(measured=lines, healthy=lines if healthy else None)


@pytest.mark.parametrize(
    ("prepared", "says"),
    [
        (_prepared(1500.0, 1503.0), "One speed was recorded, at which different causes look alike: record at 1879 rpm"),
        (_prepared(1000.0, 2000.0), "2 speeds were recorded, at which different causes look alike: record at 1500 rpm"),
        (_prepared(900.0, 1300.0, 2000.0, tied=False), "record a tacho with one pulse a turn"),
        (_prepared(900.0, 1300.0, 2000.0, healthy=False), "give recordings of it as baseline"),
        (_prepared(900.0, 1300.0, 2000.0), "small beside its uncertainty: record at 1650 rpm too, and longer"),
    ],
)
def test_cannot_tell_says_what_to_record_and_why(prepared, says):
    assert says in next_measurement("cannot tell", SimpleNamespace(candidates=()), [], prepared)
