"""Residual gear run-out: as an eccentricity of that size and angle, through zero without a jump."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.gear_eccentricity import GearEccentricity
from rotorwise.simulators.effects.residual_gear_run_out import ResidualGearRunOut
from rotorwise.simulators.machine import find_machine, machine_from_toml

from .test_gear_eccentricity import signals
from .test_tooth_crack import mesh_of

BOX = find_machine("gearbox")
PHASE = np.linspace(0, 20, 200)


def error(effect):
    return signals(mesh_of(effect), PHASE)[1] - signals(mesh_of(), PHASE)[1]


@pytest.mark.parametrize(("sine", "cosine"), [(3e-6, 0.0), (-2e-6, 4e-6), (0.0, -1e-6)])
@pytest.mark.parametrize("at", ["pinion", "wheel"])
def test_it_is_an_eccentricity_by_components(at, sine, cosine, figure):
    one = error(ResidualGearRunOut(at=at, sine_m=sine, cosine_m=cosine))
    two = error(GearEccentricity(at=at, run_out_m=math.hypot(sine, cosine), angle_rad=math.atan2(cosine, sine)))
    assert one == pytest.approx(two, abs=1e-18)
    figure("Against an eccentricity of that size and angle", one, two)


def test_it_goes_through_zero_evenly():
    below, none, above = (error(ResidualGearRunOut(sine_m=x, cosine_m=1e-7)) for x in (-1e-6, 0.0, 1e-6))
    assert none == pytest.approx((below + above) / 2, abs=1e-18)


def test_a_file_keeps_it_and_a_gear_must_exist():
    machine = BOX.with_effects(ResidualGearRunOut(at="wheel", sine_m=-1e-6, cosine_m=2e-6))
    assert machine_from_toml(machine.to_toml()) == machine
    with pytest.raises(MissingPartError, match="gear"):
        find_machine("amb_rotor").with_effects(ResidualGearRunOut()).system(speed_rpm=1200)
