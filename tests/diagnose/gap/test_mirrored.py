"""A side load's direction: sizes of lines leave its mirror image as likely, and the interval says so."""

import math

import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.simulators.effects.load_fluctuation import LoadFluctuation
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import find_machine

from .made_campaigns import recorded


@pytest.mark.slow
def test_a_direction_and_its_mirror_image_are_both_in_the_interval():
    machine = find_machine("amb_rotor")
    hidden = LoadFluctuation(radial_n=30.0, torque_n_m=0.05, frequency_hz=29.3, direction_rad=0.5)
    options = {"rate_hz": 1000.0, "duration_s": 4.0}
    healthy, faulty = (
        recorded(one, (1500.0, 2100.0, 2400.0), seed=seed, **options)
        for one, seed in ((machine, 1), (machine.with_effects(hidden), 11))
    )
    answer = explain_gap(Campaign(faulty, healthy), machine, only=frozenset({"load_fluctuation", "unbalance"}))
    (cause,) = answer.causes
    assert cause.effect == "load_fluctuation"
    found = cause.parameters["direction_rad"]
    assert found.low < 0.5 < found.high
    assert found.low < math.pi - 0.5 < found.high
    # The ends near the axes are excluded: the direction is told but for the image.
    assert 0.2 < found.low < 0.5
    assert found.is_told


@pytest.mark.slow
def test_of_two_effects_as_well():
    machine = find_machine("amb_rotor")
    hidden = (
        LoadFluctuation(radial_n=30.0, torque_n_m=0.05, frequency_hz=29.3, direction_rad=0.5),
        Unbalance(moment_kg_m=2e-4, angle_rad=1.0),
    )
    options = {"rate_hz": 1000.0, "duration_s": 4.0}
    healthy, faulty = (
        recorded(one, (1500.0, 2100.0, 2400.0), seed=seed, **options)
        for one, seed in ((machine, 1), (machine.with_effects(*hidden), 11))
    )
    answer = explain_gap(Campaign(faulty, healthy), machine, only=frozenset({"load_fluctuation", "unbalance"}))
    causes = {cause.effect: cause.parameters for cause in answer.causes}
    assert set(causes) == {"load_fluctuation", "unbalance"}
    found = causes["load_fluctuation"]["direction_rad"]
    assert found.low < 0.5 < math.pi - 0.5 < found.high
