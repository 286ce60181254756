"""Hunting tooth: which pairs are damaged, the hunting period, size of the pulses."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects.hunting_tooth import HuntingTooth
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.machines.gearbox import PINION_TEETH, WHEEL_TEETH, tooth_pair

from .test_tooth_crack import mesh_of
from .test_wear import error

MIDDLE = tooth_pair().contact_ratio / 2
PERIOD = PINION_TEETH * WHEEL_TEETH


def heights(effect):
    """Return by how much each pair of one hunting period stands proud in the middle of its contact."""
    pitches = np.arange(PERIOD) + MIDDLE
    return error(mesh_of(), pitches) - error(mesh_of(effect), pitches)


def test_the_teeth_meet_once_in_a_hunting_period(figure):
    found = heights(HuntingTooth(error_m=1e-5, alone=0.0, meeting=0.37))
    peaks = np.flatnonzero(found > 1e-9)
    # Of two neighbouring pairs at most one is in the middle of its contact.
    assert peaks.tolist() == [math.floor(0.37 * PERIOD)]
    assert found[peaks] == pytest.approx(1e-5, rel=1e-9)
    figure(f"Height of the knock, {peaks.size} in {PERIOD} tooth engagements", found[peaks], 1e-5)


def test_alone_each_makes_its_share_once_a_turn_of_its_gear():
    found = heights(HuntingTooth(error_m=1e-5, alone=0.3, meeting=0.0))
    both, pinion, wheel = found[0], found[PINION_TEETH], found[WHEEL_TEETH]
    assert both == pytest.approx(1e-5, rel=1e-9)
    assert (pinion, wheel) == pytest.approx((3e-6, 3e-6), rel=1e-9)
    assert np.count_nonzero(found > 1e-9) == PINION_TEETH + WHEEL_TEETH - 1


def test_signature_holds_the_hunting_order():
    """mesh gcd(z1, z2) / (z1 z2): once in 81 turns of the pinion."""
    lines = HuntingTooth().signature(find_machine("gearbox"))
    assert lines[-1].order == pytest.approx(23 * math.gcd(23, 81) / (23 * 81))
    assert lines[-1].order == pytest.approx(1 / 81)


def test_the_pulse_comes_once_in_81_turns_and_with_both_gears_speeds():
    """Spectrum of the error over one hunting period: all multiples of 1/81; the sum of three pulse trains."""
    samples = 8 * PERIOD
    pitches = np.arange(samples) / 8
    train = error(mesh_of(), pitches) - error(mesh_of(HuntingTooth(error_m=1e-5, alone=0.2)), pitches)
    size = np.abs(np.fft.rfft(train))[1:400]
    # Bin n is the order n / 81; multiples of 81 belong to the pinion, of 23 to the wheel, all others to the meeting.
    numbers = np.arange(1, 400)
    only = size[(numbers % 81 != 0) & (numbers % 23 != 0)]
    assert only.max() / only.min() < 1.5
    assert size[81 - 1] == pytest.approx(only[0] + 0.2 / 0.6 * 81 * only[0], rel=0.1)
