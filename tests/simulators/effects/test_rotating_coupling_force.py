"""A force of constant size turning at the coupling, on the magnetic-bearing rotor."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects import RotatingCouplingForce, Unbalance
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

MACHINE = find_machine("amb_rotor").with_parameters(unbalance_kg_m=0.0)


def amplitudes(effect, rpm, machine=MACHINE):
    return harmonic_balance(machine.with_effects(effect), speed_rpm=rpm).amplitudes


def test_zero_strength_changes_nothing():
    base = find_machine("amb_rotor")
    zero = amplitudes(RotatingCouplingForce().at_zero(), 4000.0, base)
    without = harmonic_balance(base, speed_rpm=4000.0).amplitudes
    # A force more, of nothing, is summed in another order on some processors: the same but for rounding.
    np.testing.assert_allclose(zero, without, rtol=0, atol=1e-13 * np.abs(without).max())


@pytest.mark.parametrize("rpm", [600.0, 2580.0, 4000.0])
def test_it_equals_an_unbalance_of_force_over_speed_squared(rpm, figure):
    speed = rpm * 2 * math.pi / 60
    force = amplitudes(RotatingCouplingForce(force_n=8.0, angle_rad=0.4), rpm)
    unbalance = amplitudes(Unbalance(at="coupling_hub", moment_kg_m=8.0 / speed**2, angle_rad=0.4), rpm)
    np.testing.assert_allclose(force, unbalance, atol=1e-10 * np.abs(force).max())
    figure("Response against that to an unbalance of force / speed^2", force, unbalance)


def test_static_limit():
    """Far below every mode the hub moves by force over static stiffness; the integral action holds the bearings."""
    slow = amplitudes(RotatingCouplingForce(force_n=8.0), 0.5)
    fast = amplitudes(RotatingCouplingForce(force_n=8.0), 300.0)
    assert np.abs(slow[:, 1]).max() < 0.2 * np.abs(fast[:, 1]).max()


def test_signature_is_1x_and_rises():
    effect = RotatingCouplingForce()
    (line,) = effect.signature(MACHINE)
    assert (line.order, line.speed_exponent) == (1.0, 0.0)
    found = np.abs(amplitudes(effect, 4000.0)[0])
    assert found.argmax() == 1
    assert found[1] > 1e-6
