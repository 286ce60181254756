"""Axis misalignment: each harmonic of the coupling's stiffness pulses in a fixed direction, at every speed the same."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.axis_misalignment import AxisMisalignment
from rotorwise.simulators.effects.coupling_stiffness_harmonics import CouplingStiffnessHarmonics
from rotorwise.simulators.effects.residual_coupling_harmonic import ResidualCouplingHarmonic
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

AMB = find_machine("amb_rotor")
#: So soft a coupling that its ends do not give way to it, and nothing else that moves.
SOFT = AMB.with_parameters(unbalance_kg_m=0.0, coupling_stiffness_n_m=80.0, coupling_rotational_stiffness_n_m_rad=0.1)
SHARES = [AMB.values[f"harmonic_{n}"] for n in (1, 2, 3)]
OFFSET_M, TILT_RAD = 2e-4, 3e-3


def amplitudes(machine, *effects, speed_rpm=2100.0):
    return harmonic_balance(machine.with_effects(*effects), speed_rpm=speed_rpm).amplitudes


@pytest.mark.parametrize("direction_rad", [0.0, 0.9])
def test_each_harmonic_pulses_with_its_share_of_the_force(direction_rad, figure):
    along, across = math.cos(direction_rad), math.sin(direction_rad)
    force, moment = 80.0 * OFFSET_M, 0.1 * TILT_RAD
    pulses = [
        ResidualCouplingHarmonic(
            order=float(n),
            x_cosine_n=-force * share * along,
            y_cosine_n=-force * share * across,
            angle_x_cosine_n_m=moment * share * across,
            angle_y_cosine_n_m=-moment * share * along,
        )
        for n, share in enumerate(SHARES, start=1)
    ]
    found = amplitudes(
        SOFT,
        AxisMisalignment(
            offset_m=OFFSET_M,
            angle_rad=TILT_RAD,
            offset_direction_rad=direction_rad,
            angle_direction_rad=direction_rad + math.pi / 2,
        ),
    )
    expected = amplitudes(SOFT, *pulses)
    moving = slice(1, 4)
    scale = np.abs(expected[:, moving]).max()
    assert found[:, moving] == pytest.approx(expected[:, moving], abs=2e-3 * scale)
    figure("Against forces of k a_n s at n X, the coupling soft", found[:, moving], expected[:, moving])


def test_lines_are_those_that_it_declares_and_a_file_keeps_it():
    machine = SOFT.with_effects(AxisMisalignment(offset_direction_rad=0.4, angle_direction_rad=-1.0))
    lines = [line.order for line in machine.effects[0].signature(SOFT)]
    assert sorted(lines) == [1.0, 2.0, 3.0]
    size = np.abs(harmonic_balance(machine, speed_rpm=1200.0).amplitudes).max(axis=0)
    assert size[4:].max() < 1e-2 * size[1:4].min()
    assert machine_from_toml(machine.to_toml()) == machine


def test_an_even_coupling_shows_nothing_and_says_so():
    rig = find_machine("test_rig")
    with pytest.raises(MissingPartError, match=r"equally stiff.*coupling_stiffness_harmonics"):
        rig.with_effects(AxisMisalignment()).system(speed_rpm=1000)
    uneven = CouplingStiffnessHarmonics(x_2=0.2, y_2=0.2)
    change = amplitudes(rig, uneven, AxisMisalignment()) - amplitudes(rig, uneven)
    assert np.abs(change[:, 2]).max() > 0
