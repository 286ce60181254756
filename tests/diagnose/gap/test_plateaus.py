"""Angles that choose a bolt or a tooth: the arc in which the same one is meant, and no slope."""

import math

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.plateaus import PLACES, arc_of
from rotorwise.simulators.effects.bolt_loss import BoltLoss
from rotorwise.simulators.machine import find_machine

from .made_campaigns import recorded


def test_an_arc_is_what_does_the_same():
    densities = np.full(PLACES, -50.0)
    densities[10:28] = 0.0
    assert arc_of(densities) == (10, 27)


def test_an_arc_may_lie_across_the_beginning_of_the_circle():
    densities = np.full(PLACES, -50.0)
    densities[:9] = densities[-9:] = -3.0
    first, last = arc_of(densities)
    assert (first % PLACES, last % PLACES, last - first + 1) == (PLACES - 9, 8, 18)


def test_an_arc_holds_all_that_is_as_probable():
    # Three parts of a quarter each: two alike, one that stays possible.
    densities = np.repeat([0.0, -0.1, -1.0, -40.0], PLACES // 4)
    first, last = arc_of(densities)
    assert last - first + 1 == 3 * PLACES // 4


def test_of_what_is_equal_everywhere_all_is_possible():
    first, last = arc_of(np.zeros(PLACES))
    assert last - first + 1 == PLACES


@pytest.mark.parametrize("bolt", [0, pytest.param(3, marks=pytest.mark.slow)])
def test_a_lost_bolt_is_told_to_its_neighbours(bolt):
    machine = find_machine("rigid_coupling")
    angle = bolt * math.pi / 2 + 0.2
    lost = machine.with_effects(BoltLoss(loss=0.5, angle_rad=angle))
    options = {"rate_hz": 500.0, "duration_s": 6.0, "settle_s": 40.0}
    healthy, faulty = (
        recorded(one, (900.0, 1300.0, 1700.0), seed=seed, **options) for one, seed in ((machine, 1), (lost, 11))
    )
    answer = explain_gap(Campaign(faulty, healthy), machine, only=frozenset({"bolt_loss", "unbalance"}))
    (cause,) = answer.causes
    assert cause.effect == "bolt_loss"
    found = cause.parameters["angle_rad"]
    assert math.remainder(found.value - bolt * math.pi / 2, 2 * math.pi) == pytest.approx(0.0, abs=math.radians(10))
    assert (angle - found.low) % (2 * math.pi) <= found.high - found.low
    # To half the distance of two bolts to each side, and a place further.
    assert found.high - found.low == pytest.approx(math.pi / 2, abs=math.radians(20))
