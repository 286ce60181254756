"""Residual coupling harmonic: what turns between the ends is a misaligned coupling's force, at its order alone."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.coupling_misalignment import CouplingMisalignment
from rotorwise.simulators.effects.residual_coupling_harmonic import ResidualCouplingHarmonic
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

# Without damping of the coupling a misalignment that turns pulls with stiffness times offset, and no more.
RIG = find_machine("test_rig").with_parameters(coupling_loss_s=0.0)
STIFFNESS = RIG.values["coupling_radial_stiffness_n_m"]
TILTING = RIG.values["coupling_angular_stiffness_n_m_rad"]


def amplitudes(effect):
    return harmonic_balance(RIG.with_effects(effect), speed_rpm=2100).amplitudes


@pytest.mark.parametrize("angle_rad", [0.0, 0.7])
def test_a_turning_force_is_that_of_an_offset_that_turns(angle_rad, figure):
    along, across = (STIFFNESS * 2e-5 * part for part in (math.cos(angle_rad), math.sin(angle_rad)))
    # On the driven end -F cos(phi + angle) along x, -F sin(phi + angle) along y.
    parts = {"x_cosine_n": -along, "x_sine_n": across, "y_cosine_n": -across, "y_sine_n": -along}
    one = amplitudes(ResidualCouplingHarmonic(order=1.0, **parts))
    two = amplitudes(CouplingMisalignment(offset_m=2e-5, angle_rad=0.0, offset_phase_rad=angle_rad))
    assert one == pytest.approx(two, rel=1e-9, abs=1e-9 * np.abs(two).max())
    assert np.abs(one - amplitudes(ResidualCouplingHarmonic(x_cosine_n=0.0))).max() > 1e-4 * np.abs(one).max()
    figure("Against a misaligned coupling that pulls with that force", one, two)


def test_a_turning_moment_is_that_of_a_tilt_that_turns():
    size = TILTING * 1e-3
    pushes = ResidualCouplingHarmonic(order=1.0, x_cosine_n=0.0, angle_x_cosine_n_m=-size, angle_y_sine_n_m=-size)
    two = amplitudes(CouplingMisalignment(offset_m=0.0, angle_rad=1e-3, angle_phase_rad=0.0))
    assert amplitudes(pushes) == pytest.approx(two, rel=1e-9, abs=1e-9 * np.abs(two).max())


@pytest.mark.parametrize("order", [2.0, 3.0])
def test_it_lies_at_its_order_only_and_goes_through_zero_evenly(order):
    none = amplitudes(ResidualCouplingHarmonic(order=order, x_cosine_n=0.0))
    plus, minus = (
        amplitudes(ResidualCouplingHarmonic(order=order, x_cosine_n=0.0, axial_cosine_n=n, y_sine_n=2 * n))
        for n in (1.0, -1.0)
    )
    change, scale = plus - none, np.abs(plus - none).max()
    assert plus + minus == pytest.approx(2 * none, abs=1e-9 * scale)
    elsewhere = np.delete(change, int(order), axis=1)
    assert np.abs(change[:, int(order)]).max() == pytest.approx(scale)
    assert np.abs(elsewhere).max() < 1e-9 * scale


def test_a_file_keeps_it_and_a_coupling_of_two_halves_must_exist():
    machine = RIG.with_effects(ResidualCouplingHarmonic(order=3.0, x_cosine_n=-1.0, angle_y_sine_n_m=2.0))
    assert machine_from_toml(machine.to_toml()) == machine
    with pytest.raises(MissingPartError, match="coupling"):
        find_machine("gearbox").with_effects(ResidualCouplingHarmonic(x_sine_n=1.0)).system(speed_rpm=1000)
