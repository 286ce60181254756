"""Mesh error harmonics: static error rolls through, lines at the mesh order only, as large at twice the load."""

import numpy as np
import pytest
from rotorwise.simulators.effects.mesh_error_harmonics import MeshErrorHarmonics
from rotorwise.simulators.machine import find_machine

from .test_tooth_crack import mesh_of
from .test_wear import error

BOX = find_machine("gearbox")
SIZES = {"first_m": 2e-6, "second_m": 1e-6, "third_m": 5e-7}


def test_the_error_is_the_sum_of_the_three():
    effect = MeshErrorHarmonics(**SIZES, first_angle_rad=0.3, second_angle_rad=-1.0, third_angle_rad=2.0)
    pitches = np.linspace(0, 2, 60)
    angle = 2 * np.pi * pitches
    expected = 2e-6 * np.sin(angle + 0.3) + 1e-6 * np.sin(2 * angle - 1) + 5e-7 * np.sin(3 * angle + 2)
    assert error(mesh_of(effect), pitches) - error(mesh_of(), pitches) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("load", [20.0, 60.0])
def test_slow_gears_follow_the_error_whatever_the_load(load, figure):
    """Far below any resonance the approach follows the error one to one."""
    machine = BOX.with_parameters(load_torque_n_m=load)
    effect = MeshErrorHarmonics(first_m=2e-6, second_m=0.0, third_m=0.0, first_angle_rad=0.4)
    base, changed = (
        m.simulate(speed_rpm=30.0, duration_s=0.25, rate_hz=4000.0, settle_s=0.4).probe("transmission error")
        for m in (machine, machine.with_effects(effect))
    )
    phase = 23 * np.pi * np.arange(base.size) / 4000.0
    assert changed - base == pytest.approx(2e-6 * np.sin(phase + 0.4), abs=6e-8)
    expected = 2e-6 * np.sin(phase + 0.4)
    figure("Transmission error of slow gears against the teeth's error", changed - base, expected)


def test_signature_names_what_is_there():
    lines = [line.order for line in MeshErrorHarmonics(second_m=0.0).signature(BOX)]
    assert lines == [23.0, 69.0]
