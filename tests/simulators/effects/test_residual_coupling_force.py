"""Residual coupling force: as a rotating coupling force of that size and angle, through zero without a jump."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.residual_coupling_force import ResidualCouplingForce
from rotorwise.simulators.effects.rotating_coupling_force import RotatingCouplingForce
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

RIG = find_machine("test_rig")


def amplitudes(effect):
    return harmonic_balance(RIG.with_effects(effect), speed_rpm=2100).amplitudes


@pytest.mark.parametrize(("along_x", "along_y"), [(3.0, 0.0), (-2.0, 4.0), (0.0, -1.0)])
def test_it_is_a_turning_force_by_components(along_x, along_y, figure):
    one = amplitudes(ResidualCouplingForce(force_x_n=along_x, force_y_n=along_y))
    two = amplitudes(
        RotatingCouplingForce(force_n=math.hypot(along_x, along_y), angle_rad=math.atan2(along_y, along_x))
    )
    assert one == pytest.approx(two, rel=1e-9, abs=1e-9 * np.abs(two).max())
    assert np.abs(one - amplitudes(ResidualCouplingForce())).max() > 1e-3 * np.abs(one).max()
    figure("Against a turning force of that size and angle", one, two)


def test_it_goes_through_zero_evenly():
    lines = [amplitudes(ResidualCouplingForce(force_x_n=x, force_y_n=0.1)) for x in (-1.0, 0.0, 1.0)]
    middle = (lines[0] + lines[2]) / 2
    assert lines[1] == pytest.approx(middle, rel=1e-9, abs=1e-9 * np.abs(middle).max())


def test_a_file_keeps_it_and_a_coupling_must_exist():
    machine = RIG.with_effects(ResidualCouplingForce(force_x_n=-1.0, force_y_n=2.0))
    assert machine_from_toml(machine.to_toml()) == machine
    with pytest.raises(MissingPartError, match="coupling"):
        RIG.with_effects(ResidualCouplingForce(at="nowhere")).system(speed_rpm=1000)
