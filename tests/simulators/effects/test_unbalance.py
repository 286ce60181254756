"""Unbalance: omega squared, phase, plane, sense of rotation; closed form of a rotor on its supports; run-up."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rotorwise.simulators.assembly import MissingPartError, Place, Probe
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.law import Timeline
from rotorwise.simulators.machine import Machine, MachineDefinition, Preset, find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

from .jeffcott import CRITICAL, CRITICAL_RPM, MASS, STIFFNESS, footed, jeffcott, orbit


def force(effect, *, phase_rad=0.0, speed_rad_s=100.0, acceleration_rad_s2=0.0, machine=None):
    """Return the force of the effect as x + i y."""
    forces = (machine or jeffcott()).with_effects(effect).assembly(speed_rpm=600).forces
    made = next(force for force in forces if force.name.startswith("unbalance at"))
    one = [np.array([[value]]) for value in (0.0, phase_rad, speed_rad_s, acceleration_rad_s2)]
    x, y = made.law.signals(Timeline(*one), np.array(made.parameters)[:, None])[:, 0, 0]
    return x + 1j * y


@settings(max_examples=30, deadline=None)
@given(st.floats(1.0, 1000.0), st.floats(-6, 6), st.floats(0.0, 0.1), st.floats(-3, 3))
def test_force_is_moment_times_speed_squared_and_turns_with_the_shaft(speed, phase, moment, angle):
    found = force(Unbalance(moment_kg_m=moment, angle_rad=angle), phase_rad=phase, speed_rad_s=speed)
    assert found == pytest.approx(moment * speed**2 * np.exp(1j * (phase + angle)), rel=1e-12, abs=1e-15)


def test_force_is_minus_the_mass_times_the_acceleration_of_its_centre():
    """On a run-up phi = w t + a t^2 / 2 too: - m e d2/dt2 exp(i phi), by differences."""
    speed, acceleration, step = 80.0, 500.0, 1e-5

    def centre(t):
        return 2e-4 * np.exp(1j * (speed * t + acceleration * t**2 / 2 + 0.3))

    expected = -(centre(step) - 2 * centre(0.0) + centre(-step)) / step**2
    effect = Unbalance(moment_kg_m=2e-4, angle_rad=0.3)
    found = force(effect, speed_rad_s=speed, acceleration_rad_s2=acceleration)
    assert found == pytest.approx(expected, rel=1e-5)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.floats(0.1, 3.0), st.floats(-3, 3), st.floats(0.01, 0.2))
def test_rotor_on_its_shaft(figure, ratio, angle, zeta):
    """z = m e w^2 exp(i psi) / (k - M w^2 + i w c): forward only, turned by 90 degrees at the critical speed."""
    speed = ratio * CRITICAL
    machine = jeffcott(damping_ratio=zeta).with_effects(Unbalance(moment_kg_m=1e-4, angle_rad=angle))
    motion = harmonic_balance(machine, speed_rpm=ratio * CRITICAL_RPM, harmonics=2)
    dynamic = STIFFNESS - MASS * speed**2 + 2j * zeta * MASS * CRITICAL * speed
    ahead, back = orbit(motion, 1.0)
    assert ahead == pytest.approx(1e-4 * speed**2 * np.exp(1j * angle) / dynamic, rel=1e-9)
    figure(
        "1X of an unbalanced rotor on its shaft against closed form",
        ahead,
        1e-4 * speed**2 * np.exp(1j * angle) / dynamic,
    )
    assert abs(back) < 1e-9 * abs(ahead)


def test_phase_lags_by_a_quarter_at_the_critical_speed_and_a_half_far_above():
    machine = jeffcott(damping_ratio=0.02).with_effects(Unbalance(moment_kg_m=1e-4, angle_rad=0.5))
    for ratio, lag in ((0.05, 0.0), (1.0, math.pi / 2), (20.0, math.pi)):
        ahead = orbit(harmonic_balance(machine, speed_rpm=ratio * CRITICAL_RPM, harmonics=2), 1.0)[0]
        # 2 zeta r / (1 - r^2) is 0.002 at both ends.
        assert np.angle(ahead * np.exp(-0.5j) * np.exp(1j * lag)) == pytest.approx(0.0, abs=3e-3)
    # Far above, the rotor turns about its mass centre: the orbit is the eccentricity.
    assert abs(ahead) == pytest.approx(1e-4 / MASS, rel=0.01)


def test_rotor_on_unequal_supports_answers_each_direction_by_itself():
    from rotorwise.simulators.effects.support_anisotropy import SupportAnisotropy

    effects = (Unbalance(moment_kg_m=1e-4, angle_rad=0.0), SupportAnisotropy(fraction=-0.4))
    machine = footed(damping_ratio=0.03).with_effects(*effects)
    speed = 0.5 * CRITICAL
    motion = harmonic_balance(machine, speed_rpm=0.5 * CRITICAL_RPM, harmonics=2)
    lag = 2j * 0.03 * MASS * CRITICAL * speed
    for axis, stiffness, ahead in (("x", 0.6 * STIFFNESS, 1.0), ("y", STIFFNESS, -1j)):
        expected = ahead * 1e-4 * speed**2 / (stiffness - MASS * speed**2 + lag)
        assert motion.amplitude(axis, 1.0) == pytest.approx(expected, rel=1e-9)


def test_far_below_every_natural_frequency_displacement_grows_as_speed_squared():
    rotor = find_machine("rigid_coupling").with_parameters(hole_circle_offset_m=0.0, axis_offset_m=0.0)
    machine = rotor.with_effects(Unbalance(at="rotor_2", moment_kg_m=1e-3))
    sizes = [abs(harmonic_balance(machine, speed_rpm=s).amplitude("rotor_2.x", 1.0)) for s in (60, 120)]
    # The lowest natural frequency is some 20 Hz: (2 / 20)^2 of it is missing.
    assert sizes[1] / sizes[0] == pytest.approx(4.0, rel=0.02)


def test_two_equal_weights_in_opposite_planes_are_a_couple():
    """Each plane pushes its own end of the rotor; opposite weights leave its middle, equal ones its tilt."""
    rotor = find_machine("amb_rotor").with_parameters(unbalance_kg_m=0.0)
    places = [name for name, place in rotor.bare_assembly().places.items() if "rotor" in place.roles]
    assert len(places) >= 2
    assembly = rotor.with_effects(*(Unbalance(at=name) for name in places)).assembly(speed_rpm=600)
    forces = [f for f in assembly.forces if f.name.startswith("unbalance at")]
    assert len({tuple(f.outputs[0].items()) for f in forces}) == len(places)
    ends = (places[0], places[-1])
    both, opposite = (
        harmonic_balance(
            rotor.with_effects(Unbalance(at=ends[0], angle_rad=0.0), Unbalance(at=ends[1], angle_rad=second)),
            speed_rpm=600,
        ).amplitudes
        for second in (0.0, math.pi)
    )
    one, two = (
        harmonic_balance(rotor.with_effects(Unbalance(at=end, angle_rad=0.0)), speed_rpm=600).amplitudes for end in ends
    )
    scale = np.abs(one).max()
    assert both == pytest.approx(one + two, abs=1e-10 * scale)
    assert opposite == pytest.approx(one - two, abs=1e-10 * scale)
    assert np.abs(one - two).max() > 0.1 * scale


def test_a_gear_on_another_shaft_shakes_at_its_own_speed():
    gearbox = find_machine("gearbox")
    wheel = gearbox.bare_assembly().place("gear", "wheel")
    effect = Unbalance(at="wheel", moment_kg_m=1e-4, angle_rad=0.0)
    (line,) = effect.signature(gearbox)
    assert (line.order, line.speed_exponent, line.load_exponent) == (wheel.shaft_ratio, 2.0, 0.0)
    turned = 2 * math.pi / wheel.shaft_ratio
    one, later = (force(effect, phase_rad=p, machine=gearbox) for p in (0.0, turned))
    assert one == pytest.approx(1e-4 * (wheel.shaft_ratio * 100.0) ** 2)
    assert later == pytest.approx(one, abs=1e-9 * abs(one))


def test_weights_at_one_place_add_as_vectors():
    machine = jeffcott(damping_ratio=0.05)
    pair = [Unbalance(moment_kg_m=3e-5, angle_rad=0.0), Unbalance(moment_kg_m=4e-5, angle_rad=math.pi / 2)]
    together, single = (
        harmonic_balance(machine.with_effects(*effects), speed_rpm=1000).amplitudes
        for effects in (pair, [Unbalance(moment_kg_m=5e-5, angle_rad=math.atan2(4, 3))])
    )
    assert together == pytest.approx(single, abs=1e-15)


def test_a_place_that_does_not_turn_is_refused():
    with pytest.raises(MissingPartError, match="no rotor"):
        find_machine("test_rig").with_effects(Unbalance(at="housing_a")).system(speed_rpm=900)


def _build_stiff_rotor(assembly, values, switches):
    """Put a rigid rotor of no polar inertia on four springs, two at each end."""
    directions = {name: {name: 1.0} for name in ("x", "y", "angle_x", "angle_y")}
    for name in directions:
        assembly.add_coordinate(name, mass=TILT if "angle" in name else MASS)
        stiffness = STIFFNESS * ARM**2 if "angle" in name else STIFFNESS
        assembly.add_spring({name: 1.0}, stiffness=stiffness)
        assembly.probes.append(Probe(name, "displacement", "m", "disc", name, {name: 1.0}))
    assembly.add_place(Place("disc", frozenset({"rotor", "disc"}), directions))


#: Inertia about a diameter (kg.m2), distance of the supports (m).
TILT, ARM = 0.01, 0.2


@pytest.mark.parametrize("offset", [0.0, 0.02, -0.05])
def test_a_weight_beside_the_middle_tilts_a_rigid_rotor(offset):
    """Forward slope a m e w^2 / (k L^2 - I w^2), beside z = m e w^2 / (k - M w^2)."""
    presets = {"plausible": Preset("")}
    machine = Machine(MachineDefinition("stiff", "test machine", (), presets, _build_stiff_rotor, 2e-4, 0.0))
    weight, speed = Unbalance(moment_kg_m=1e-3, angle_rad=0.7, axial_offset_m=offset), 100.0
    motion = harmonic_balance(machine.with_effects(weight), speed_rpm=speed * 30 / np.pi, harmonics=2)
    force = 1e-3 * speed**2 * np.exp(0.7j)
    assert orbit(motion, 1.0)[0] == pytest.approx(force / (STIFFNESS - MASS * speed**2), rel=1e-9)
    slopes = motion.amplitude("angle_y", 1.0), -motion.amplitude("angle_x", 1.0)
    forward = (slopes[0] + 1j * slopes[1]) / 2
    expected = offset * force / (STIFFNESS * ARM**2 - TILT * speed**2)
    assert forward == pytest.approx(expected, rel=1e-9, abs=1e-18)


def test_a_part_that_cannot_tilt_feels_no_couple():
    one, other = (Unbalance(moment_kg_m=1e-4, axial_offset_m=a) for a in (0.0, 0.03))
    assert (
        jeffcott().with_effects(one).assembly(speed_rpm=600).forces[1:]
        == (jeffcott().with_effects(other).assembly(speed_rpm=600).forces[1:])
    )
