"""Pitting: only the contact yields, for as many teeth as are pitted, in proportion to load."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects.pitting import Pitting
from rotorwise.simulators.effects.tooth_crack import ToothCrack
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.machines.gearbox import PINION_TEETH, tooth_pair

from .test_tooth_crack import mesh_of, stiffness

PAIR = tooth_pair()


def test_half_of_the_width_doubles_the_contacts_compliance_in_the_middle(figure):
    middle = PAIR.contact_ratio / 2
    assert PAIR.contact_ratio - 1 < middle < 1
    pitted = 1 / stiffness(mesh_of(Pitting(share=0.5, teeth=1)), middle)[0]
    assert pitted - 1 / PAIR.pair_stiffness_n_m(middle) == pytest.approx(PAIR.contact_compliance_m_n, rel=1e-4)
    added = pitted - 1 / PAIR.pair_stiffness_n_m(middle)
    figure("Contact pitted over half its width against twice as soft", added, PAIR.contact_compliance_m_n)


@pytest.mark.parametrize("teeth", [1, 3, 30])
def test_as_many_teeth_as_are_pitted_are_softer(teeth):
    middle = np.arange(2 * PINION_TEETH) + PAIR.contact_ratio / 2
    count = min(teeth, 20)
    change = stiffness(mesh_of(Pitting(share=0.3, teeth=count, angle_rad=math.pi)), middle)
    softer = change < 0.9999 * stiffness(mesh_of(), middle)
    assert np.count_nonzero(softer) == 2 * count
    first = round(PINION_TEETH / 2) % PINION_TEETH
    assert softer[first] or softer[first - 1]


def test_pits_change_nothing_where_contact_begins_and_ends():
    for phase in (1e-6, PAIR.contact_ratio - 1e-6):
        change = stiffness(mesh_of(Pitting(share=0.5, teeth=1)), phase) - stiffness(mesh_of(), phase)
        assert change == pytest.approx(0.0, abs=1.0)


def test_pits_of_everyday_size_are_weaker_than_a_crack():
    pitches = np.linspace(0, PAIR.contact_ratio, 50)[1:-1]
    loss = [np.max(stiffness(mesh_of(), pitches) - stiffness(mesh_of(e), pitches)) for e in (Pitting(), ToothCrack())]
    assert 0.2 < loss[0] / loss[1] < 1


def test_signature_follows_the_gear():
    box = find_machine("gearbox")
    assert Pitting(at="wheel").signature(box)[0].order == pytest.approx(23 / 81)
    assert Pitting().signature(box)[6].order == pytest.approx(24.0)
    assert all(line.load_exponent == 1 for line in Pitting().signature(box))
