"""Gear eccentricity: the error itself, first-order sidebands of a held mesh in closed form, own shaft, load."""

import dataclasses
import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.gear_eccentricity import GearEccentricity
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.machines.gearbox import PINION_TEETH, RATIO, WHEEL_TEETH, tooth_pair
from rotorwise.simulators.rotor_dynamics.gear_mesh import GEAR_MESH

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
def test_the_stiffness_breathes_with_the_centre_distance(at, turns):
    """Where the centre stands follows from the error, and the distance from that; the wheel turns the other way."""
    phase = np.linspace(0, 20, 200)
    growth, lost = centre_growth(at, turns * phase + (0.7 if at == "pinion" else -0.7))
    sound, bent = (signals(m, phase) for m in (mesh_of(), mesh_of(effect(at, 0.7))))
    assert bent[1] - sound[1] == pytest.approx(lost, abs=1e-15)
    share = bent[0] / sound[0] - 1
    # To first order in the run-out over the distance.
    softer = mesh_of().pair.stiffness_growth_per_m
    assert softer < 0
    assert share == pytest.approx(softer * growth, abs=1e-3 * abs(softer) * RUN_OUT)
    pair = mesh_of().pair
    far = dataclasses.replace(pair, centre_growth_m=RUN_OUT).mean_stiffness_n_m / pair.mean_stiffness_n_m - 1
    assert share.min() == pytest.approx(far, rel=0.02)


def effect(at="pinion", angle=0.0):
    return GearEccentricity(at=at, run_out_m=RUN_OUT, angle_rad=angle)


def held(mesh, phase_rad, push_m):
    """Return the force of teeth held at an approach, mean stiffness included."""
    own = signals(mesh, phase_rad)
    return own[0] * (push_m - own[1])


@pytest.mark.parametrize("deep", [0.0, 1e-3])
@pytest.mark.parametrize("at", ["pinion", "wheel"])
def test_first_order_sidebands_of_a_held_mesh(at, deep, figure):
    """F = k(phi) (1 + s(phi)) (d - e): half the product of the stiffness's harmonic and of r i + s d exp(-+ i alpha).

    Over 81 turns of the pinion every line falls on a bin.
    """
    turns, per_turn = WHEEL_TEETH, 8192
    phase = 2 * np.pi * np.arange(turns * per_turn) / per_turn
    pair, way = mesh_of().pair, 1 if at == "pinion" else -1
    held_m = deep - mesh_of().mean_error_m
    breath = way * pair.stiffness_growth_per_m * held_m * np.exp(-1j * way * pair.working_angle_rad)
    size_of_both = RUN_OUT * abs(1j + breath)
    change = held(mesh_of(effect(at)), phase, deep) - held(mesh_of(), phase, deep)
    found = 2 * np.abs(np.fft.rfft(change)) / change.size
    pitch = (np.arange(4096) + 0.5) / 4096
    course = stiffness(mesh_of(), pitch)
    harmonic = [2 * np.mean(course * np.exp(-2j * np.pi * k * pitch)) for k in (1, 2, 3)]
    own = turns if at == "pinion" else PINION_TEETH
    # The jumps of the stiffness are sampled, 356 times a pitch.
    assert found[own] == pytest.approx(np.mean(course) * size_of_both, rel=5e-4)
    for k, size in enumerate(harmonic, start=1):
        centre = k * PINION_TEETH * turns
        for side in (centre - own, centre + own):
            assert found[side] == pytest.approx(size_of_both * abs(size) / 2, rel=5e-3)
            figure("Sidebands of a held mesh against closed form", found[side], size_of_both * abs(size) / 2)
        # The mesh line itself does not change, nor do the other gear's sidebands.
        other = turns + PINION_TEETH - own
        assert max(found[centre], found[centre + other], found[centre - other]) < 1e-3 * RUN_OUT * abs(harmonic[0])


def test_load_adds_what_the_breathing_stiffness_makes_of_it():
    phase = np.linspace(0, 30, 3000)
    one, two = (held(mesh_of(effect()), phase, push) - held(mesh_of(), phase, push) for push in (5e-5, 1e-4))
    softer = signals(mesh_of(effect()), phase)[0] - signals(mesh_of(), phase)[0]
    assert two - one == pytest.approx(5e-5 * softer, rel=1e-9, abs=1e-9 * np.abs(one).max())


@pytest.mark.parametrize("at", ["pinion", "wheel"])
def test_slow_gears_roll_along_with_the_error(at):
    """Far below any resonance the approach follows the error one to one, whatever the load."""
    found = []
    for load in (20.0, 60.0):
        machine = BOX.with_parameters(load_torque_n_m=load)
        base, bent = (
            m.simulate(speed_rpm=60.0, duration_s=0.2, rate_hz=4000.0, settle_s=0.3).probe("transmission error")
            for m in (machine, machine.with_effects(effect(at)))
        )
        phase = 2 * np.pi * np.arange(base.size) / 4000.0 * (RATIO if at == "wheel" else 1.0)
        assert bent - base == pytest.approx(RUN_OUT * np.sin(phase), abs=0.02 * RUN_OUT)
        found.append(bent - base)
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


def test_sidebands_of_slow_gears_are_those_of_the_breathing_stiffness():
    """The approach is F / k(phi) (1 + s(phi)): at mesh -+ 1 half of s times the first harmonic of F / k."""
    load = 40.0
    pitch = (np.arange(4096) + 0.5) / 4096
    softness = 1 / stiffness(mesh_of(), pitch)
    pair = mesh_of().pair
    first = 2 * abs(np.mean(softness * np.exp(-2j * np.pi * pitch))) * load / pair.wheel.base_radius_m
    expected = abs(pair.stiffness_growth_per_m) * RUN_OUT * first / 2
    found = np.abs(slow_sidebands(150.0, load))
    assert found == pytest.approx(expected, rel=0.05)


def test_what_inertia_holds_back_makes_sidebands_that_grow_as_speed_squared(monkeypatch):
    """Of teeth whose stiffness does not breathe."""
    monkeypatch.setitem(tooth_pair().__dict__, "stiffness_growth_per_m", 0.0)
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


def test_the_stiffness_swings_in_proportion():
    phase = np.linspace(0, 20, 200)
    sound = signals(mesh_of(), phase)
    one, ten = (
        signals(mesh_of(GearEccentricity(at="wheel", run_out_m=RUN_OUT, angle_rad=0.4, stiffness_swing=swing)), phase)
        for swing in (1.0, 10.0)
    )
    assert ten[1] == pytest.approx(one[1])
    assert ten[0] / sound[0] - 1 == pytest.approx(10 * (one[0] / sound[0] - 1), abs=1e-12)


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
