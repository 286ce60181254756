"""Inner race defect: lines at k BPFI +- m, pulses only while the pit is in the load zone."""

import numpy as np
import pytest
from rotorwise.simulators.effects.inner_race_defect import InnerRaceDefect
from rotorwise.simulators.effects.outer_race_defect import OuterRaceDefect
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.rotor_dynamics.bearing_damage import pit_half_angle_rad

from .held_bearings import KINDS, force_over_turns, part_of

kinds = pytest.mark.parametrize(("machine", "at"), KINDS)


def lost_along_load(machine, at, phase, push_m=2e-5, **options):
    """Return what the pit takes away along the load."""
    changed, sound = (
        part_of(machine, InnerRaceDefect(at=at, size_m=s, slip=1e-9, slip_wander=0.0, **options), at)
        for s in (1e-3, 0.0)
    )
    load = np.array([np.cos(changed.load_angle_rad), np.sin(changed.load_angle_rad)])
    both = [force_over_turns(part, phase, push_m=push_m) for part in (changed, sound)]
    return load @ (both[0] - both[1]), changed


@kinds
def test_balls_pass_the_pit_at_the_inner_order(machine, at, figure):
    """Every pass lies at the angle that pure rolling gives: (shaft - cage) turns by one ball spacing between passes."""
    phase = np.linspace(0, 2 * np.pi * 20, 200_001)
    lost, part = lost_along_load(machine, at, phase)
    orders = part.geometry.defect_orders()
    assert orders.inner_race == pytest.approx(part.geometry.balls * (1 - orders.cage))
    inside = lost > 0.02 * lost.max()
    starts, stops = (np.flatnonzero(np.diff(inside.astype(int)) == step) for step in (1, -1))
    count = min(starts.size, stops.size)
    middle = (phase[starts[:count]] + phase[stops[:count]]) / 2 if starts[0] < stops[0] else phase[starts]
    gaps = np.diff(middle) * orders.inner_race / (2 * np.pi)
    # Passes outside the load zone leave no mark: whole numbers, not all of them one.
    assert np.abs(gaps - np.round(gaps)).max() < 0.1
    figure("Angles between passes against pure rolling", gaps, np.round(gaps), off="ball spacings")
    assert gaps.max() > 1.5
    half = pit_half_angle_rad(part.geometry, size_m=1e-3, inner=True)
    assert np.mean(inside) < part.geometry.balls * 2 * half / (2 * np.pi)


def test_lines_are_k_inner_order_and_m_shaft():
    """A geometry whose inner order is whole makes every line fall on a whole order, one bin of eight."""
    import dataclasses

    changed, sound = (part_of("test_rig", InnerRaceDefect(size_m=s, slip=0.0, slip_wander=0.0)) for s in (1e-3, 0.0))
    # d / D = 1/4 and eight balls: cage 3/8, outer 3, inner 5. A line of the cage would lie between whole orders.
    geometry = dataclasses.replace(changed.geometry, balls=8, ball_diameter_m=7e-3, pitch_diameter_m=28e-3)
    changed.geometry = sound.geometry = geometry
    sound.damage.slip = 1e-15
    turns, per_turn = 8, 4096
    phase = 2 * np.pi * np.arange(turns * per_turn) / per_turn
    change = force_over_turns(changed, phase, push_m=1e-5)[1] - force_over_turns(sound, phase, push_m=1e-5)[1]
    size = np.abs(np.fft.rfft(change)) / size_of(change)
    inner = geometry.defect_orders().inner_race
    assert inner == pytest.approx(5.0)
    strong = np.flatnonzero(size > 1e-3)
    assert strong.size > 50
    assert not np.any(strong % turns)
    for k in (1, 2, 3):
        centre, upper, lower = (size[round((k * inner + m) * turns)] for m in (0, 1, -1))
        assert min(upper, lower) > 0.3 * centre


def size_of(signal):
    return np.abs(np.fft.rfft(signal)[1:]).max()


def test_inner_and_outer_orders_add_up_to_the_number_of_balls_with_slip():
    rig = find_machine("test_rig")
    inner, outer = (kind(slip=0.02).signature(rig)[0].order for kind in (InnerRaceDefect, OuterRaceDefect))
    assert inner + outer == pytest.approx(8.0)
    assert outer == pytest.approx(0.98 * 2.998, abs=2e-3)


def test_orders_follow_the_slip_that_another_defect_brings():
    rig = find_machine("test_rig")
    inner, outer = InnerRaceDefect(slip=0.0), OuterRaceDefect(slip=0.02)
    with_both = inner.signature(rig.with_effects(outer))[0].order + outer.signature(rig.with_effects(inner))[0].order
    assert with_both == pytest.approx(8.0)
    assert inner.signature(rig.with_effects(outer)) != inner.signature(rig)


def test_signature_names_sidebands_of_the_shaft_that_turns():
    box = find_machine("gearbox")
    lines = InnerRaceDefect(at="bearing 3", slip=0.0).signature(box)
    ratio = 23 / 81
    assert lines[1].order - lines[0].order == pytest.approx(ratio)
    assert lines[0].order - lines[2].order == pytest.approx(ratio)
