"""Breathing crack: flexibility from fracture mechanics, exact hinge, quasi-static limit, peaks and phases."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects.breathing_crack import BreathingCrack
from rotorwise.simulators.effects.gravity import Gravity
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.rotor_dynamics.bending_shaft import BendingShaft
from rotorwise.simulators.rotor_dynamics.crack_flexibility import crack_flexibility
from rotorwise.simulators.rotor_dynamics.shaft_elements import assemble_rotor
from rotorwise.simulators.rotor_dynamics.shaft_parts import ShaftElement
from rotorwise.simulators.rotor_dynamics.turning_stiffness import turning_stiffness
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance, harmonic_balances

from .jeffcott import CRITICAL_RPM, MASS, STEEL, STIFFNESS, jeffcott

GRAVITY = 9.81


def crack(depth=0.3, angle=0.0):
    return BreathingCrack(depth_ratio=depth, angle_rad=angle, position=0.5)


def at(machine, ratio, harmonics=8):
    return harmonic_balance(machine, speed_rpm=ratio * CRITICAL_RPM, harmonics=harmonics)


def test_shallow_crack_in_closed_form():
    # K_I = 1.122 (4 M / pi R^3) sqrt(pi z) over a segment of depth a: int z dz dw = 8/15 a^2 sqrt(2 R a).
    depth, radius = 1e-4, 0.01
    front, across = crack_flexibility(depth_ratio=depth, diameter_m=2 * radius, material=STEEL)
    a = depth * 2 * radius
    stress = 4 / (math.pi * radius**3)
    area = 8 / 15 * a**2 * math.sqrt(2 * radius * a)
    expected = 2 * (1 - 0.3**2) / 2.1e11 * (1.122 * stress) ** 2 * math.pi * area
    assert front == pytest.approx(expected, rel=0.005)
    assert across < 1e-3 * front


def test_flexibility_scales_and_grows():
    values = [
        crack_flexibility(depth_ratio=d, diameter_m=0.02, material=STEEL) for d in (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5)
    ]
    assert values[0] == (0.0, 0.0)
    assert np.all(np.diff(np.array(values), axis=0) > 0)
    assert all(front > across for front, across in values[1:])
    half = crack_flexibility(depth_ratio=0.3, diameter_m=0.01, material=STEEL)
    assert np.array(half) == pytest.approx(8 * np.array(values[4]), rel=1e-12)
    with pytest.raises(InvalidValueError, match=r"0\.6"):
        crack_flexibility(depth_ratio=0.6, diameter_m=0.02, material=STEEL)


@pytest.mark.parametrize("position", [0.5, 0.44, 0.7])
def test_the_hinge_is_exact(position):
    # Kink c M in a simply supported beam: the load's point moves by c M(1) M(F) / F more, shear or not.
    span, kink, elements = 0.4, 1e-3, [ShaftElement(0.05, 0.02)] * 8
    shaft = BendingShaft("s", prefix="s", elements=elements, material=STEEL, bearing_nodes=(0, 8))
    moment = shaft.bending_moment(position)
    lost = kink / (1 + kink * moment.kink_stiffness_n_m_rad)
    names = [f"s_{n}.{c}" for n in range(9) for c in ("x", "y", "angle_x", "angle_y")]
    sound = assemble_rotor(elements, material=STEEL).stiffness
    for row, load in ((moment.x, "x"), (moment.y, "y")):
        m = np.array([row.get(name, 0.0) for name in names])
        held = [names.index(f"s_{n}.{c}") for n in (0, 8) for c in "xy"]
        free = [i for i in range(len(names)) if i not in held]
        push = np.zeros(len(names))
        push[names.index(f"s_4.{load}")] = 1.0
        yields = [
            push[free] @ np.linalg.solve((sound - s * np.outer(m, m))[np.ix_(free, free)], push[free])
            for s in (0.0, lost)
        ]
        carried = span / 2 * min(position, 1 - position)
        assert yields[1] - yields[0] == pytest.approx(kink * carried**2, rel=1e-6)


def test_slow_rotation_is_a_row_of_static_sags(figure):
    angle, depth = 0.7, 0.4
    machine = jeffcott(gravity_m_s2=GRAVITY).with_effects(crack(depth, angle))
    shaft = machine.bare_assembly().components["shaft"]
    moment = shaft.bending_moment(0.5)
    front, across = crack_flexibility(depth_ratio=depth, diameter_m=0.02, material=STEEL)
    soft = [c / (1 + c * moment.kink_stiffness_n_m_rad) * moment.x["x"] ** 2 for c in (front, across)]
    phases = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    expected = []
    for phase in phases:
        normal = np.array([math.cos(phase + angle), math.sin(phase + angle)])
        beside = np.array([-normal[1], normal[0]])
        # The lower side is in tension.
        open_ = (1 - normal[1]) / 2
        stiffness = STIFFNESS * np.eye(2) - open_ * (
            soft[0] * np.outer(normal, normal) + soft[1] * np.outer(beside, beside)
        )
        expected.append(np.linalg.solve(stiffness, [0.0, -MASS * GRAVITY]))
    found = harmonic_balance(machine, speed_rpm=1e-3 * CRITICAL_RPM, harmonics=16).waveform(phases)
    assert np.abs(found.T - np.array(expected)).max() < 1e-5 * MASS * GRAVITY / STIFFNESS
    figure("Sag over a turn, the crack breathing, against statics", found.T, expected)
    sound = MASS * GRAVITY / STIFFNESS
    # The sag is largest with the crack below, and that of the sound shaft with it above.
    assert found[1].min() < -1.02 * sound
    assert harmonic_balance(machine, speed_rpm=1e-3 * CRITICAL_RPM, harmonics=16).waveform(
        np.array([math.pi / 2 - angle])
    )[1, 0] == pytest.approx(-sound, rel=1e-5)


def test_an_abrupt_crack_switches_between_sound_and_open():
    """Gasch's hinge at slow roll: the sag of the sound shaft, and of the shaft with an open hinge."""
    depth = 0.4
    machine = jeffcott(gravity_m_s2=GRAVITY).with_effects(
        BreathingCrack(depth_ratio=depth, angle_rad=0.0, position=0.5, abruptness=10.0)
    )
    moment = machine.bare_assembly().components["shaft"].bending_moment(0.5)
    front, _ = crack_flexibility(depth_ratio=depth, diameter_m=0.02, material=STEEL)
    soft = front / (1 + front * moment.kink_stiffness_n_m_rad) * moment.x["x"] ** 2
    # Within 40 degrees of up and of down: tanh(10 cos 40) is 1 to 4e-7.
    turned = np.radians([-40.0, -10.0, 0.0, 25.0])
    slow = harmonic_balance(machine, speed_rpm=1e-3 * CRITICAL_RPM, harmonics=80)
    closed, opened = (slow.waveform(turned + where)[1] for where in (math.pi / 2, -math.pi / 2))
    sound = -MASS * GRAVITY / STIFFNESS
    assert closed == pytest.approx(sound, rel=1e-3)
    assert opened[2] == pytest.approx(-MASS * GRAVITY / (STIFFNESS - soft), rel=1e-3)


def test_abruptness_is_the_cosine_at_first_and_adds_higher_lines():
    machine = jeffcott(gravity_m_s2=GRAVITY, damping_ratio=0.02)
    values = [
        at(machine.with_effects(BreathingCrack(depth_ratio=0.3, abruptness=k)), 0.1, harmonics=24).amplitudes[1]
        for k in (0.0, 1e-4, 3.0, -1e-4, -3.0)
    ]
    assert values[1] == pytest.approx(values[0], abs=1e-8 * np.abs(values[0]).max())
    assert abs(values[0][5]) < 1e-3 * abs(values[0][3])
    assert values[3] == pytest.approx(values[0], abs=1e-8 * np.abs(values[0]).max())
    assert all(abs(values[i][5]) > 1e-2 * abs(values[i][3]) for i in (2, 4))


def test_cracks_of_any_abruptness_side_by_side():
    machines = [
        jeffcott(gravity_m_s2=GRAVITY).with_effects(BreathingCrack(depth_ratio=0.3, abruptness=k))
        for k in (0.0, 2.0, -1.0)
    ]
    for machine, (found,) in zip(machines, harmonic_balances([(m, [300.0]) for m in machines]), strict=True):
        alone = harmonic_balance(machine, speed_rpm=300.0).amplitudes
        assert found.amplitudes == pytest.approx(alone, abs=1e-12 * np.abs(alone).max())


@pytest.mark.parametrize("abruptness", [0.5, 4.0])
def test_below_zero_it_opens_by_the_inverse_function(abruptness):
    angles = np.linspace(0.1, 3.0, 7)[:, None]

    def opening(k, theta):
        one = turning_stiffness("t", ({}, {}), shaft_ratio=1.0, angle_rad=0.0, even=1.0, abruptness=k)
        timeline = Timeline(np.zeros_like(theta), theta, np.ones_like(theta), np.zeros_like(theta))
        return one.law.signals(timeline, np.array(one.parameters)[:, None])[2]

    there = opening(-abruptness, angles)
    assert opening(abruptness, np.arccos(there)) == pytest.approx(np.cos(angles), rel=1e-9)


@pytest.mark.parametrize(("order", "fraction"), [(2, 1 / 2), (3, 1 / 3)])
def test_peaks_at_fractions_of_the_critical_speed(order, fraction):
    machine = jeffcott(gravity_m_s2=GRAVITY, damping_ratio=0.01).with_effects(crack(0.25))
    ratios = np.linspace(0.8, 1.2, 81) * fraction
    size = [np.hypot(*(abs(at(machine, r).amplitude(axis, order)) for axis in "xy")) for r in ratios]
    assert 0 < np.argmax(size) < 80
    # A little lower than of the sound shaft, as the crack softens it.
    assert ratios[np.argmax(size)] == pytest.approx(fraction, rel=0.04)
    assert max(size) > 5 * size[0]


def test_phases_are_locked_to_the_weight():
    machine = jeffcott(gravity_m_s2=GRAVITY, damping_ratio=0.01)
    first, second = (at(machine.with_effects(crack(0.3, angle)), 0.1) for angle in (0.2, 0.9))
    for n in (1, 2, 3):
        turned = second.amplitude("y", n) / first.amplitude("y", n)
        assert turned == pytest.approx(np.exp(1j * n * 0.7), rel=1e-9)
    slow, slower = (at(machine.with_effects(crack()), ratio) for ratio in (0.02, 0.01))
    for n in (1, 2, 3):
        assert slow.amplitude("y", n) == pytest.approx(slower.amplitude("y", n), rel=0.01)


def test_lines_grow_with_the_weight_and_not_with_unbalance():
    half, full = (at(jeffcott(gravity_m_s2=g).with_effects(crack()), 0.2).amplitudes for g in (4.905, 9.81))
    assert full == pytest.approx(2 * half, rel=1e-9)
    shaken = at(jeffcott(gravity_m_s2=9.81, eccentricity_m=1e-5).with_effects(crack()), 0.2)
    assert abs(shaken.amplitude("y", 3.0)) == pytest.approx(abs(full[1, 3]), rel=0.1)


def test_without_static_load_it_stays_open_and_says_so():
    machine = jeffcott(eccentricity_m=1e-5, damping_ratio=0.02).with_effects(crack())
    assert any("stays open" in note for note in machine.system(speed_rpm=1000).notes)
    motion = at(machine, 0.4)
    assert abs(motion.amplitude("y", 2.0)) < 1e-9 * abs(motion.amplitude("y", 1.0))
    assert [line.order for line in crack().signature(jeffcott())] == [1.0]


def test_gravity_may_come_after_the_crack():
    rotor = find_machine("amb_rotor")
    effects = [BreathingCrack(), Gravity(), Unbalance(moment_kg_m=2e-4)]
    one, two = (
        harmonic_balance(rotor.with_effects(*order), speed_rpm=1200).amplitudes for order in (effects, effects[::-1])
    )
    assert one == pytest.approx(two, abs=1e-9 * np.abs(one).max())
    assert not rotor.with_effects(*effects).system(speed_rpm=1200).notes


def test_the_gear_force_opens_a_crack_too():
    gearbox = find_machine("gearbox")
    lines = BreathingCrack(at="output shaft").signature(gearbox)
    assert [line.order for line in lines] == pytest.approx([n * 23 / 81 for n in (1, 2, 3)])


def test_the_deepest_crack_leaves_the_test_rig_stable():
    rig = find_machine("test_rig").with_effects(crack(0.5))
    assert np.linalg.eigvals(rig.system(speed_rpm=1800).core).real.max() < 1e-6
