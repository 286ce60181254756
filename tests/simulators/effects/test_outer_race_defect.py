"""Outer race defect: sagitta of a pit, a ball over its middle, lines at k BPFO, growth with load, slip, convergence."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.simulators.effects.outer_race_defect import OuterRaceDefect
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.machines.gearbox import BEARING_6304
from rotorwise.simulators.rotor_dynamics.bearing_damage import BearingDamage, pit_half_angle_rad, relief_m
from rotorwise.simulators.solvers.stepper import LaneGroup, Stepper
from rotorwise.simulators.speed_profile import steady

from .held_bearings import KINDS, core_stiffness, force_over_turns, part_of

PURE = {"slip": 0.0, "slip_wander": 0.0}
kinds = pytest.mark.parametrize(("machine", "at"), KINDS)


@pytest.mark.parametrize("inner", [False, True])
def test_relief_is_the_difference_of_two_sagittas(inner):
    ball, pitch, size = BEARING_6304.ball_diameter_m, BEARING_6304.pitch_diameter_m, 1e-3
    race = (pitch - ball if inner else pitch + ball) / 2

    def sagitta(radius):
        return radius - math.sqrt(radius**2 - size**2 / 4)

    exact = sagitta(ball / 2) + (sagitta(race) if inner else -sagitta(race))
    assert relief_m(BEARING_6304, size_m=size, inner=inner) == pytest.approx(exact, rel=0.01)
    assert 2 * race * pit_half_angle_rad(BEARING_6304, size_m=size, inner=inner) == pytest.approx(size)


def test_a_ball_over_the_middle_is_relieved_by_the_depth():
    """One ball is pressed, by 2 um beyond the clearance; a pit 1 um deep leaves 1 um of approach."""
    size = 1e-3 * math.sqrt(1e-6 / relief_m(BEARING_6304, size_m=1e-3, inner=False))
    part = part_of("gearbox", OuterRaceDefect(size_m=size, angle_rad=-math.pi / 2, **PURE), "bearing 1")
    # The first ball stands at the angle 0, where the pit is too, since the load points along y.
    force = force_over_turns(part, [0.0], push_m=part.clearance_m + 2e-6, angle_rad=0.0)
    assert force[0, 0] == pytest.approx(-part.contact_stiffness * 1e-6**1.5, rel=1e-9)


@settings(max_examples=30, deadline=None)
@given(angle=st.floats(0, 7), push=st.floats(1e-6, 1e-4))
def test_a_ball_of_a_linear_bearing_loses_its_share_of_the_spring(angle, push):
    """4 k / Z a, less a / (h0 + a) of it: the shares of all balls under a push add up to k times it."""
    part = part_of("test_rig", OuterRaceDefect(size_m=3e-3, slip=0.0, slip_wander=0.0))
    balls, cage = part.geometry.balls, part.geometry.defect_orders().cage
    # The pit is at the load; turn the cage until a ball is over its middle.
    phase = (part.load_angle_rad % (2 * math.pi / balls)) / cage
    lost = force_over_turns(part, [phase], push_m=push, angle_rad=angle)[:, 0] + core_stiffness(part) * push * np.array(
        [np.cos(angle), np.sin(angle)]
    )
    approach = push * max(math.cos(angle - part.load_angle_rad), 0.0)
    deep = relief_m(part.geometry, size_m=3e-3, inner=False)
    expected = 4 * core_stiffness(part) / balls * approach * deep / (deep + approach)
    size = lost @ [math.cos(part.load_angle_rad), math.sin(part.load_angle_rad)]
    # The rounding of the contact, 0.05 um, adds at most half of itself.
    assert size == pytest.approx(expected, abs=4 * core_stiffness(part) / balls * 2.6e-8)
    spaced = 2 * np.pi * np.arange(balls) / balls
    shares = np.maximum(np.cos(spaced - angle), 0.0)
    assert 4 / balls * np.sum(shares * np.cos(spaced - angle)) == pytest.approx(1.0)


@kinds
@pytest.mark.parametrize("slip", [0.0, 0.02])
def test_it_repeats_at_the_ball_pass_order_and_nowhere_else(machine, at, slip, figure):
    part = part_of(machine, OuterRaceDefect(at=at, slip=slip, slip_wander=0.0), at)
    order = part.geometry.balls * part.geometry.defect_orders().cage * (1 - slip)
    angles = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    one, later = (force_over_turns(part, angles + k * 2 * np.pi / order, push_m=1e-5) for k in (0, 7))
    assert later == pytest.approx(one, abs=1e-6 * np.abs(one).max())
    figure("Force of the passing balls repeats at Z times the cage's order", later, one)
    half = force_over_turns(part, angles + np.pi / order, push_m=1e-5)
    assert np.abs(half - one).max() > 0.1 * np.abs(one).max()


@kinds
def test_pulses_take_load_away_where_the_pit_is(machine, at):
    part, sound = (
        part_of(machine, OuterRaceDefect(at=at, size_m=s, slip=1e-9, slip_wander=0.0), at) for s in (1e-3, 0)
    )
    phase = np.linspace(0, 2 * np.pi * 10, 20000)
    change = force_over_turns(part, phase, push_m=1e-5) - force_over_turns(sound, phase, push_m=1e-5)
    load = np.array([np.cos(part.load_angle_rad), np.sin(part.load_angle_rad)])
    # The ring is pushed back less: the change points along the load, and only along it.
    assert (load @ change).min() > -1e-9 * np.abs(change).max()
    across = np.abs(load[::-1] * [-1, 1] @ change).max()
    assert across < 0.05 * (load @ change).max()
    # The share of time that a ball spends in the pit.
    half = pit_half_angle_rad(part.geometry, size_m=1e-3, inner=False)
    inside = np.mean(load @ change > 1e-6 * (load @ change).max())
    assert inside == pytest.approx(part.geometry.balls * 2 * half / (2 * np.pi), rel=0.1)


def test_outside_the_load_zone_it_does_nothing():
    away, sound = (
        part_of("gearbox", OuterRaceDefect(size_m=s, angle_rad=math.pi, slip=1e-9, slip_wander=0.0)) for s in (2e-3, 0)
    )
    phase = np.linspace(0, 60, 3000)
    found, expected = (force_over_turns(part, phase, push_m=1e-5) for part in (away, sound))
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_what_a_deep_pit_takes_away_grows_as_the_load():
    part, sound = (part_of("test_rig", OuterRaceDefect(size_m=s, slip=1e-9, slip_wander=0.0)) for s in (4e-3, 0))
    phase = np.linspace(0, 20, 4000)
    lost = [
        np.ptp(force_over_turns(part, phase, push_m=push)[1] - force_over_turns(sound, phase, push_m=push)[1])
        for push in (2e-6, 4e-6)
    ]
    # To the rounding of the contact, 0.05 um against an approach of 2 um, and to approach over depth.
    assert lost[1] / lost[0] == pytest.approx(2.0, rel=0.02)


def test_wander_has_the_deviation_asked_for_and_comes_from_the_seed():
    from rotorwise.simulators.rotor_dynamics.bearing_damage import _wander_rows

    cage, phase = 0.38, np.linspace(0, 2e5, 400001)

    def rate(seed, wander=0.01):
        rows = np.array(_wander_rows(cage, wander, seed)).reshape(-1, 3)
        return sum(order * amplitude * np.cos(order * phase + angle) for order, amplitude, angle in rows)

    for seed in (1, 2):
        assert rate(seed).std() / cage == pytest.approx(0.01, rel=0.02)
    assert _wander_rows(cage, 0.01, 1) == _wander_rows(cage, 0.01, 1)
    assert abs(np.corrcoef(rate(1), rate(2))[0, 1]) < 0.1


def test_slip_of_several_defects_is_the_largest():
    damage = BearingDamage()
    damage.add_slip(slip=0.01, wander=0.0, seed=0)
    damage.add_slip(slip=0.02, wander=0.0, seed=0)
    damage.add_slip(slip=0.015, wander=0.0, seed=0)
    assert damage.slip == 0.02


@pytest.mark.parametrize("machine", ["gearbox", "test_rig"])
def test_halving_the_step_converges_over_several_passes(machine):
    """Contact is lost and found again at every pass, nearly a turn holds two or three of them.

    Each loss is a kink of the force at an instant that no step meets: second order is what is left of the fourth.
    """
    made = find_machine(machine).with_effects(OuterRaceDefect(size_m=1e-3, **PURE))
    profile, step = steady(speed_rpm=1800.0), made.definition.step_s
    group = LaneGroup([made], [profile], [made.system(speed_rpm=profile)])
    runs = []
    # The first quarter of a second is the same for all, so that the start is not what is compared.
    first = Stepper(group, step_s=step / 2, start_s=-0.25)
    total = round(0.25 / (step / 2))
    while first.done < total:
        first.advance(min(first.block, total - first.done))
    for finer in (1, 2, 8):
        run = Stepper(group, step_s=step / finer, start_s=first.start_s + total * step / 2)
        run.states[:] = first.states
        steps, parts = round(0.03 / step) * finer, []
        while run.done < steps:
            parts.append(run.advance(min(run.block, steps - run.done)))
        runs.append(np.concatenate(parts)[::finer, :, 0])
    scale = np.std(runs[-1], axis=0) + 1e-300
    lateral = [i for i, p in enumerate(made.system(speed_rpm=1800.0).probes) if p.direction in ("x", "y")]
    errors = [np.sqrt(np.mean(((run - runs[-1]) / scale)[:, lateral] ** 2)) for run in runs[:-1]]
    assert errors[0] < 1e-2
    assert math.log2(errors[0] / errors[1]) > 1.7
