"""Residual unbalance: the same as an unbalance of that size and angle, through zero without a jump."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.residual_unbalance import ResidualUnbalance
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

AMB = find_machine("amb_rotor")


def amplitudes(effect):
    return harmonic_balance(AMB.with_effects(effect), speed_rpm=2100).amplitudes


@pytest.mark.parametrize(("along_x", "along_y"), [(3e-5, 0.0), (-2e-5, 4e-5), (0.0, -1e-5)])
def test_it_is_an_unbalance_by_components(along_x, along_y, figure):
    one = amplitudes(ResidualUnbalance(at="coupling_hub", moment_x_kg_m=along_x, moment_y_kg_m=along_y))
    size, angle = math.hypot(along_x, along_y), math.atan2(along_y, along_x)
    two = amplitudes(Unbalance(at="coupling_hub", moment_kg_m=size, angle_rad=angle))
    assert one == pytest.approx(two, rel=1e-9, abs=1e-9 * np.abs(two).max())
    figure("Against an unbalance of that size and angle", one, two)


def test_it_goes_through_zero_evenly():
    lines = [amplitudes(ResidualUnbalance(at="disc", moment_x_kg_m=x, moment_y_kg_m=1e-7)) for x in (-1e-6, 0.0, 1e-6)]
    middle = (lines[0] + lines[2]) / 2
    assert lines[1] == pytest.approx(middle, rel=1e-9, abs=1e-9 * np.abs(middle).max())


def test_a_file_keeps_it_and_a_place_must_exist():
    machine = AMB.with_effects(ResidualUnbalance(at="disc", moment_x_kg_m=-1e-5, moment_y_kg_m=2e-5))
    assert machine_from_toml(machine.to_toml()) == machine
    with pytest.raises(MissingPartError, match="disc"):
        AMB.with_effects(ResidualUnbalance(at="nowhere")).system(speed_rpm=1000)
