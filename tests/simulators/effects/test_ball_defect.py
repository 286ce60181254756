"""Ball defect: twice the ball spin with sidebands of the cage; nothing while the ball is without load."""

import dataclasses

import numpy as np
import pytest
from rotorwise.simulators.effects.ball_defect import BallDefect
from rotorwise.simulators.machine import find_machine

from .held_bearings import KINDS, force_over_turns, part_of


def change(machine, at, phase, *, push_m=2e-5, geometry=None):
    parts = [part_of(machine, BallDefect(at=at, size_m=s, slip=0.0, slip_wander=0.0), at) for s in (1e-3, 0.0)]
    for part in parts:
        part.geometry = geometry or part.geometry
    # A trace of slip makes the sound bearing's balls carry one by one too.
    parts[1].damage.slip = 1e-15
    both = [force_over_turns(part, phase, push_m=push_m) for part in parts]
    return both[0] - both[1], parts[0]


def test_lines_are_k_ball_spin_and_m_cage(figure):
    """d / D = 1/4: cage 3/8, ball spin 15/8, so that every line falls on a bin of eight turns."""
    part = part_of("test_rig", BallDefect())
    geometry = dataclasses.replace(part.geometry, balls=8, ball_diameter_m=7e-3, pitch_diameter_m=28e-3)
    assert geometry.defect_orders().ball_spin == pytest.approx(15 / 8)
    turns, per_turn = 8, 4096
    phase = 2 * np.pi * np.arange(turns * per_turn) / per_turn
    force, _ = change("test_rig", "", phase, geometry=geometry)
    size = np.abs(np.fft.rfft(force[1]))
    size /= size[1:].max()
    bins = {round(8 * (k * 15 / 8 + m * 3 / 8)) for k in range(-60, 61) for m in range(-25, 26)}
    stray = [i / 8 for i, s in enumerate(size[:800]) if s > 2e-3 and i not in bins]
    assert not stray
    largest = max(s for i, s in enumerate(size[:800]) if i not in bins)
    figure("Lines off multiples of the cage, 2 x ball spin among them", reads=f"at most {largest:.0e} of the strongest")

    def band(k):
        centre = round(k * 15)
        return size[[centre - 3, centre, centre + 3]]

    for k in (2, 4, 6):
        # Sidebands of the cage, from the way through the load zone.
        assert band(k)[[0, 2]].min() > 0.3 * band(k)[1]
    # Both races in turn: odd multiples of the spin are weak.
    assert max(band(3).max(), band(5).max()) < 0.2 * min(band(2).max(), band(4).max())


@pytest.mark.parametrize(("machine", "at"), KINDS)
def test_it_is_felt_only_while_the_ball_carries_load(machine, at):
    phase = np.linspace(0, 2 * np.pi * 30, 120_001)
    force, part = change(machine, at, phase)
    cage = part.geometry.defect_orders().cage * phase + getattr(part, "first_ball_rad", 0.0)
    loaded = np.cos(cage - part.load_angle_rad)
    push = force[0] * np.cos(part.load_angle_rad) + force[1] * np.sin(part.load_angle_rad)
    # To the rounding of a linear bearing's contact.
    assert np.abs(push[loaded < -0.1]).max() < 0.01 * push.max()
    assert push.min() > -0.01 * push.max()
    assert push[loaded > 0.9].max() == push.max()


def test_signature_is_twice_the_spin_and_the_cage():
    lines = [line.order for line in BallDefect(slip=0.0).signature(find_machine("test_rig"))]
    orders = part_of("test_rig", BallDefect()).geometry.defect_orders()
    assert lines[:3] == pytest.approx(
        [2 * orders.ball_spin, 2 * orders.ball_spin + orders.cage, 2 * orders.ball_spin - orders.cage]
    )
    assert lines[3:6] == pytest.approx([orders.cage, 2 * orders.cage, 3 * orders.cage])
