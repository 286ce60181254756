"""Gravity: weight and static sag, the same for finite elements, lines that the sag makes at an offset flange."""

import numpy as np
import pytest
from rotorwise.simulators.assembly import Assembly, MissingPartError
from rotorwise.simulators.effects.coupling_stiffness_harmonics import CouplingStiffnessHarmonics
from rotorwise.simulators.effects.gravity import Gravity
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

MACHINE = find_machine("rigid_coupling")
ALIGNED = MACHINE.with_parameters(hole_circle_offset_m=0.0, axis_offset_m=0.0, load_torque_n_m=0.0)


def weight_of(machine):
    """Return the generalised force of gravity by coordinate."""
    force = machine.with_effects(Gravity()).assembly(speed_rpm=600).forces[-1]
    return {name: force.parameters[2] * share for name, share in force.outputs[0].items()}


def test_force_is_the_weight():
    assert weight_of(MACHINE) == pytest.approx({"rotor_1.y": -9810.0, "rotor_2.y": -981.0})


def test_finite_element_shaft_weighs_what_its_mass_says():
    machine = find_machine("amb_rotor")
    system = machine.system(speed_rpm=1200)
    vertical = np.array([name.endswith(".y") for name in system.coordinates], float)
    mass = vertical @ system.mass_matrix @ vertical
    total = sum(value for name, value in weight_of(machine).items() if name.endswith(".y"))
    assert total == pytest.approx(-9.81 * mass, rel=1e-12)


def test_sag_is_the_static_solution(figure):
    motion = harmonic_balance(ALIGNED.with_effects(Gravity()), speed_rpm=600)
    values, coupling = MACHINE.values, 4 * MACHINE.values["bolt_stiffness_n_m"]
    stiffness = np.array(
        [
            [values["support_1_n_m"] + coupling, -coupling],
            [-coupling, values["support_2_n_m"] + coupling],
        ]
    )
    sag = np.linalg.solve(stiffness, [-9810.0, -981.0])
    assert motion.amplitude("rotor_1.y", 0.0) == pytest.approx(sag[0], rel=1e-9)
    assert motion.amplitude("rotor_2.y", 0.0) == pytest.approx(sag[1], rel=1e-9)
    found = [motion.amplitude(f"rotor_{i}.y", 0.0) for i in (1, 2)]
    figure("Sag of two coupled rotors against statics", found, sag)
    assert np.abs(motion.amplitudes[:, 1:]).max() < 1e-15


@pytest.mark.parametrize("speed_rpm", [600, 1320])
def test_its_lines_rise_at_an_offset_flange(speed_rpm):
    # The torque at 1X goes with the static distance of the axes, which the sag of rotor 2 makes larger.
    effect = Gravity()
    base, heavy = (harmonic_balance(m, speed_rpm=speed_rpm) for m in (MACHINE, MACHINE.with_effects(effect)))
    apart, further = (
        -5e-4 + (m.amplitude("rotor_2.y", 0.0) - m.amplitude("rotor_1.y", 0.0)).real for m in (base, heavy)
    )
    for line in effect.signature(MACHINE):
        probe = "twist" if line.direction == "torsion" else "rotor_2.x"
        ratio = abs(heavy.amplitude(probe, line.order)) / abs(base.amplitude(probe, line.order))
        assert ratio == pytest.approx(further / apart, rel=2e-3)
        assert ratio > 1.1


def test_lines_announced_follow_a_coupling_that_another_effect_makes_uneven():
    rotor = find_machine("amb_rotor").with_parameters(harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0)
    uneven = rotor.with_effects(CouplingStiffnessHarmonics().at_zero().with_values(y_2=0.1))
    assert [line.order for line in Gravity().signature(rotor)] == [0.0]
    assert [line.order for line in Gravity().signature(uneven)] == [2.0]
    sag = [
        abs(
            harmonic_balance(m.with_effects(Gravity()), speed_rpm=1500).amplitude("path_2", 2.0)
            - harmonic_balance(m, speed_rpm=1500).amplitude("path_2", 2.0)
        )
        for m in (rotor, uneven)
    ]
    assert sag[1] > 1e3 * sag[0]


def test_two_halves_are_the_whole_and_zero_is_nothing():
    half = Gravity(gravity_m_s2=4.905)
    both, whole = (
        harmonic_balance(m, speed_rpm=600) for m in (ALIGNED.with_effects(half, half), ALIGNED.with_effects(Gravity()))
    )
    assert both.amplitudes == pytest.approx(whole.amplitudes, abs=1e-18)
    zero = harmonic_balance(ALIGNED.with_effects(Gravity().at_zero()), speed_rpm=600)
    assert np.abs(zero.amplitudes).max() == 0.0


def test_machine_without_vertical_motion_is_refused():
    with pytest.raises(MissingPartError, match="has weight"):
        Gravity().contribute(Assembly(speed_rad_s=1.0))
