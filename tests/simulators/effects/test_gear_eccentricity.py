"""Gear eccentricity: the error itself, first-order sidebands of a held mesh in closed form, own shaft, load."""

import dataclasses
import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.gear_eccentricity import GearEccentricity
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.machines.gearbox import PINION_TEETH, RATIO, WHEEL_TEETH
from rotorwise.simulators.rotor_dynamics.gear_mesh_law import GEAR_MESH
from rotorwise.simulators.rotor_dynamics.gear_mesh_stiffness import SpurPair

from .test_tooth_crack import mesh_of, stiffness

BOX = find_machine("gearbox")
RUN_OUT = 1e-5


def signals(mesh, phase_rad, *, speed_rad_s=1.0):
    """Return stiffness, error and rate of error at shaft angles."""
    phase = np.asarray(phase_rad, float)[:, None]
    timeline = Timeline(phase, phase, np.full_like(phase, speed_rad_s), np.zeros_like(phase))
    return GEAR_MESH.signals(timeline, np.array(mesh.interface_force().parameters)[:, None])[:, :, 0]


@pytest.mark.parametrize(("at", "order"), [("pinion", 1.0), ("wheel", PINION_TEETH / WHEEL_TEETH)])
def test_error_is_a_sine_of_the_gears_own_turns(at, order):
    assert pytest.approx(RATIO if at == "wheel" else 1.0) == order
    phase = np.linspace(0, 20, 200)
    sound, bent = (signals(m, phase, speed_rad_s=50.0) for m in (mesh_of(), mesh_of(effect(at, 0.7))))
    assert bent[1] - sound[1] == pytest.approx(RUN_OUT * np.sin(order * phase + 0.7), abs=1e-15)
    rate = RUN_OUT * order * 50.0 * np.cos(order * phase + 0.7)
    assert bent[2] - sound[2] == pytest.approx(rate, abs=1e-12)


def centre_growth(at, own_rad):
    """Return by how much the centres move apart, and the approach lost, with a gear's centre at these angles.

    The line of action is y; the mesh lies at the pinion's -x side, as its teeth there move down and push the wheel.
    """
    pair = mesh_of().pair
    apart = pair.pinion.pitch_radius_m + pair.wheel.pitch_radius_m
    towards = -apart * np.array([math.cos(pair.working_angle_rad), math.sin(pair.working_angle_rad)])
    moved = RUN_OUT * np.stack([np.cos(own_rad), np.sin(own_rad)], axis=-1)
    between = towards - moved if at == "pinion" else towards + moved
    return np.linalg.norm(between, axis=-1) - apart, moved[:, 1] if at == "pinion" else -moved[:, 1]


@pytest.mark.parametrize(("at", "turns"), [("pinion", 1.0), ("wheel", -RATIO)])
def test_pairs_enter_later_where_the_centres_are_further_apart(at, turns):
    """Where the centre stands follows from the error, and the distance from that; the wheel turns the other way."""
    phase = np.linspace(0, 20, 200)
    growth, lost = centre_growth(at, turns * phase + (0.7 if at == "pinion" else -0.7))
    bent = mesh_of(effect(at, 0.7))
    assert signals(bent, phase)[1] - signals(mesh_of(), phase)[1] == pytest.approx(lost, abs=1e-15)
    sound, moved = jumps(mesh_of()), jumps(bent)
    enters = stiffness(mesh_of(), sound + 1e-4) > stiffness(mesh_of(), sound - 1e-4)
    # Out at the pinion's tip, which stays where it is.
    assert moved[~enters] == pytest.approx(sound[~enters], abs=1e-12)
    pair = mesh_of().pair
    further = np.interp(moved[enters] * 2 * np.pi / PINION_TEETH, phase, growth)
    pitches_later = further / math.sin(pair.working_angle_rad) / pair.base_pitch_m
    assert moved[enters] - sound[enters] == pytest.approx(pitches_later, abs=0.02 * RUN_OUT / pair.base_pitch_m)
    # The stiffness follows: it is that of two pairs from there on.
    for way, other in ((-1, sound), (1, sound)):
        beside = moved[enters] + way * 1e-6
        expected = stiffness(mesh_of(), other[enters] + way * 1e-6)
        assert stiffness(bent, beside) == pytest.approx(expected, rel=0.02)


def jumps(mesh):
    """Return the phases, in pitches, at which pairs enter and leave within three turns of the pinion."""
    pitch = 2 * np.pi / PINION_TEETH
    found = GEAR_MESH.jumps(np.array(mesh.interface_force().parameters), 0.5 * pitch, 69.5 * pitch)
    return found / pitch


@pytest.mark.parametrize("growth_m", [2e-5, -2e-5, 8e-5])
def test_harmonics_change_as_those_of_gears_at_another_distance(growth_m):
    """A gear pair computed anew, set so that pairs leave where they did: its tooth forms count as well."""
    pair, phase = mesh_of().pair, (np.arange(20000) + 0.5) / 20000
    far = dataclasses.replace(pair, centre_growth_m=growth_m)
    later = growth_m * pair.later_entry_per_m
    assert pair.contact_ratio - far.contact_ratio == pytest.approx(later, rel=0.02)
    entered = (phase < pair.contact_ratio - 1) & (phase >= max(later, 0.0)) | (phase >= 1 + min(later, 0.0))
    two, one = pair.branches
    law = np.where(entered, two.stiffness_n_m(phase - (phase >= 1 + min(later, 0.0))), one.stiffness_n_m(phase))
    law = np.where(phase < max(later, 0.0), one.stiffness_n_m(phase + 1), law)
    course = [pair.mesh_stiffness_n_m(phase), law, far.mesh_stiffness_n_m(phase - later)]
    harmonics = np.array([[np.mean(k * np.exp(-2j * np.pi * n * phase)) for n in (1, 2, 3)] for k in course])
    change, expected = harmonics[1:] - harmonics[0]
    assert np.abs(change - expected).max() < 0.15 * np.abs(expected).min()


def effect(at="pinion", angle=0.0):
    return GearEccentricity(at=at, run_out_m=RUN_OUT, angle_rad=angle)


def held(mesh, phase_rad, push_m):
    """Return the force of teeth held at an approach, mean stiffness included."""
    own = signals(mesh, phase_rad)
    return own[0] * (push_m - own[1])


@pytest.mark.parametrize("deep", [0.0, 1e-3])
@pytest.mark.parametrize("at", ["pinion", "wheel"])
def test_first_order_sidebands_of_a_held_mesh(at, deep, figure):
    """F = k(phi) (d - e), the jump J of k at each entry later by Re(L exp(i n phi)) pitches.

    To first order |d J L - K_m E| at m mesh + n, all being complex amplitudes; with their conjugates at m mesh - n.
    Over 81 turns of the pinion every line falls on a bin, and no two turns are sampled alike.
    """
    turns, count, run_out = WHEEL_TEETH, WHEEL_TEETH * 32768 + 1, 2e-6
    phase = 2 * np.pi * turns * np.arange(count) / count
    mesh, way = mesh_of(), 1 if at == "pinion" else -1
    error = -1j * run_out
    later = way * mesh.pair.later_entry_per_m * run_out * np.exp(-1j * way * mesh.pair.working_angle_rad)
    pushed = (deep - mesh.mean_error_m) * entry_jump(mesh) * later
    bent = mesh_of(dataclasses.replace(effect(at), run_out_m=run_out))
    change = held(bent, phase, deep) - held(mesh, phase, deep)
    found = 2 * np.abs(np.fft.rfft(change)) / change.size
    pitch = (np.arange(4096) + 0.5) / 4096
    course = stiffness(mesh, pitch + entry_phase(mesh))
    own = turns if at == "pinion" else PINION_TEETH
    for m in range(4):
        harmonic = np.mean(course * np.exp(-2j * np.pi * m * pitch))
        centre = m * PINION_TEETH * turns
        sides = [(centre + own, pushed - harmonic * error)]
        if m:
            sides.append((centre - own, pushed.conjugate() - harmonic * error.conjugate()))
        for side, expected in sides:
            # The jumps are sampled, 1425 times a pitch, and move by 1.4 samples.
            assert found[side] == pytest.approx(abs(expected), rel=0.01)
            figure("Sidebands of a held mesh against closed form", found[side], abs(expected))
        if m:
            # The mesh line itself does not change, nor do the other gear's sidebands.
            other = turns + PINION_TEETH - own
            rest = max(found[centre], found[centre + other], found[centre - other])
            assert rest < 0.02 * max(abs(expected) for _, expected in sides)


def entry_phase(mesh):
    """Return a phase in pitches at which a pair enters."""
    at = jumps(mesh)
    return at[stiffness(mesh, at + 1e-4) > stiffness(mesh, at - 1e-4)][0]


def entry_jump(mesh, of=lambda stiff: stiff):
    """Return by how much the stiffness falls short there until the pair enters; ``of`` it."""
    at = entry_phase(mesh)
    before, after = of(stiffness(mesh, np.array([at - 1e-7, at + 1e-7])))
    return before - after


def test_load_adds_what_the_breathing_stiffness_makes_of_it():
    phase = np.linspace(0, 30, 3000)
    one, two = (held(mesh_of(effect()), phase, push) - held(mesh_of(), phase, push) for push in (5e-5, 1e-4))
    softer = signals(mesh_of(effect()), phase)[0] - signals(mesh_of(), phase)[0]
    assert two - one == pytest.approx(5e-5 * softer, rel=1e-9, abs=1e-9 * np.abs(one).max())


@pytest.mark.parametrize("at", ["pinion", "wheel"])
def test_slow_gears_roll_along_with_the_error(at):
    """Far below any resonance the approach follows the error one to one, whatever the load, where no pair enters."""
    found = []
    pitches = np.arange(800) / 4000.0 * PINION_TEETH
    entering = np.abs(pitches - np.round(pitches)) < 0.02
    for load in (20.0, 60.0):
        machine = BOX.with_parameters(load_torque_n_m=load)
        base, bent = (
            m.simulate(speed_rpm=60.0, duration_s=0.2, rate_hz=4000.0, settle_s=0.3).probe("transmission error")
            for m in (machine, machine.with_effects(effect(at)))
        )
        phase = 2 * np.pi * np.arange(base.size) / 4000.0 * (RATIO if at == "wheel" else 1.0)
        added = (bent - base)[~entering]
        assert added == pytest.approx(RUN_OUT * np.sin(phase)[~entering], abs=0.02 * RUN_OUT)
        found.append(added)
    assert found[0] == pytest.approx(found[1], abs=0.02 * RUN_OUT)


def slow_sidebands(speed_rpm, load_n_m):
    """Return what the run-out adds to the approach at mesh -+ 1, complex; gears alone: a motor brakes the slow wave."""
    gears = BOX.with_parameters(motor_slope_n_m_s_rad=0.0, load_torque_n_m=load_n_m)
    runs = [
        m.simulate(speed_rpm=speed_rpm, duration_s=240 / speed_rpm, rate_hz=8192.0, settle_s=0.4)
        for m in (gears, gears.with_effects(effect()))
    ]
    base, bent = (run.probe("transmission error") for run in runs)
    window = np.hanning(base.size)
    waves = np.exp(-1j * np.outer([PINION_TEETH - 1, PINION_TEETH + 1], runs[0].phase_rad))
    return 2 * waves @ ((bent - base) * window) / window.sum()


def test_sidebands_of_slow_gears_are_those_of_later_entries():
    """The approach is F / k(phi): at mesh -+ 1 the jump of 1 / k where a pair enters, times by how much it is later."""
    load = 40.0
    pair = mesh_of().pair
    jump = abs(entry_jump(mesh_of(), lambda stiff: 1 / stiff))
    expected = jump * load / pair.wheel.base_radius_m * pair.later_entry_per_m * RUN_OUT
    found = np.abs(slow_sidebands(150.0, load))
    assert found == pytest.approx(expected, rel=0.05)


def test_what_inertia_holds_back_makes_sidebands_that_grow_as_speed_squared(monkeypatch):
    """Of teeth that enter where they did."""
    monkeypatch.setattr(SpurPair, "later_entry_per_m", 0.0)
    sizes = [np.abs(slow_sidebands(rpm, 30.0)) for rpm in (300.0, 600.0)]
    assert sizes[1] / sizes[0] == pytest.approx(4.0, rel=0.03)


def acceleration(*effects, turns):
    """Return orders and amplitudes of the vertical acceleration of the first bearing's housing at 1800 rpm."""
    rate = 16384.0
    run = BOX.with_effects(*effects).simulate(speed_rpm=1800.0, duration_s=turns / 30, rate_hz=rate)
    names = [p.name for p in run.probes if p.quantity == "acceleration" and p.direction == "y"]
    signal = run.probe(names[0]) * np.hanning(run.phase_rad.size)
    return np.fft.rfftfreq(signal.size, 1 / rate) / 30, 4 * np.abs(np.fft.rfft(signal)) / signal.size


def test_sidebands_stand_at_the_own_shaft_in_the_running_gearbox():
    turns = 24
    orders, base = acceleration(turns=turns)
    width = 2 / turns

    def near(spectrum, order):
        return spectrum[np.abs(orders - order) < 0.5 * width].max()

    for at, own, other in (("pinion", 1.0, RATIO), ("wheel", RATIO, 1.0)):
        bent = acceleration(GearEccentricity(at=at, run_out_m=2e-5), turns=turns)[1]
        for side in (PINION_TEETH - own, PINION_TEETH + own):
            assert near(bent, side) > 3 * near(base, side)
        announced = [line.order for line in GearEccentricity(at=at).signature(BOX)]
        assert announced == pytest.approx([PINION_TEETH + own, PINION_TEETH - own, own, own])
        assert near(bent, PINION_TEETH + other) < 0.3 * near(bent, PINION_TEETH + own)


def test_run_outs_of_one_gear_add_as_vectors_and_of_two_stand_side_by_side():
    a, b = effect(angle=0.0), effect(angle=2 * math.pi / 3)
    assert mesh_of(a, b).errors[1.0] - mesh_of().errors.get(1.0, 0) == pytest.approx(
        mesh_of(effect(angle=math.pi / 3)).errors[1.0] - mesh_of().errors.get(1.0, 0)
    )
    both = mesh_of(effect("pinion"), effect("wheel")).errors
    assert {1.0, RATIO} <= set(both)


@pytest.mark.parametrize(("at", "ratio", "way"), [("pinion", 1.0, 1), ("wheel", RATIO, -1)])
def test_the_mass_centre_pulls_where_the_pitch_circle_is_off(at, ratio, way):
    """m r (n w)^2 along (cos, sin) of the gear's own angle; the pinion that stands up (y) has less approach."""
    share, angle, speed = 0.4, 0.7, 60.0
    machine = BOX.with_effects(GearEccentricity(at=at, run_out_m=RUN_OUT, angle_rad=angle, mass_share=share))
    (force,) = (one for one in machine.assembly(speed_rpm=600.0).forces if one.name.startswith("mass beside"))
    phase = np.linspace(0, 20, 50)[:, None]
    timeline = Timeline(phase, phase, np.full_like(phase, speed), np.zeros_like(phase))
    found = force.law.signals(timeline, np.array(force.parameters)[:, None])[:, :, 0]
    own = way * (ratio * phase[:, 0] + angle)
    size = share * RUN_OUT * BOX.values[f"{at}_mass_kg"] * (ratio * speed) ** 2
    expected = size * np.stack([np.cos(own), np.sin(own)])
    across = np.array([[direction.get(f"{at}.{axis}", 0.0) for direction in force.outputs] for axis in "xy"])
    assert across @ found == pytest.approx(expected, rel=1e-9, abs=1e-12 * size)


def test_machine_without_gears_is_refused():
    with pytest.raises(MissingPartError, match="gear"):
        find_machine("amb_rotor").with_effects(GearEccentricity()).system(speed_rpm=1200)
