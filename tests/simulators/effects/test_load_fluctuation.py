"""Load fluctuation: closed form of the swing, sidebands of a gear mesh, frequency that stays."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.load_fluctuation import LoadFluctuation
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

FLANGE = find_machine("rigid_coupling").preset("paper_reduction")
ALIGNED = FLANGE.with_parameters(hole_circle_offset_m=0.0, axis_offset_m=0.0)
ROTOR = find_machine("amb_rotor")
TORQUE = LoadFluctuation(torque_n_m=1.0, radial_n=0.0, frequency_hz=5.0, phase_rad=0.7)


@pytest.mark.parametrize("speed_rpm", [300, 600])
def test_twist_of_a_single_inertia_has_its_closed_form(speed_rpm, figure):
    # Rotor 1 immovable: T / (K r^2 - I w^2 + i w c) at the process's frequency, whatever the speed.
    motion = harmonic_balance(ALIGNED.with_effects(TORQUE), speed_rpm=speed_rpm, revolutions=2)
    values, omega = ALIGNED.values, 2 * math.pi * 5
    dynamic = 4 * values["bolt_stiffness_n_m"] * 0.09 - 9.0 * omega**2 + 1j * omega * 2 * 0.001 * 9 * 40 * math.pi
    found = motion.amplitude("twist", 5 * 60 / speed_rpm)
    assert found == pytest.approx(np.exp(0.7j) / dynamic, rel=2e-3)
    figure("Twist at the frequency of the process against closed form", found, np.exp(0.7j) / dynamic)


def test_side_load_on_a_machine_without_torsion():
    effect = LoadFluctuation(torque_n_m=5.0, radial_n=10.0, frequency_hz=15.0, direction_rad=math.pi / 2)
    base, changed = (harmonic_balance(m, speed_rpm=900) for m in (ROTOR, ROTOR.with_effects(effect)))
    twice = harmonic_balance(ROTOR.with_effects(effect.with_values(radial_n=20.0)), speed_rpm=900)
    added = changed.amplitudes - base.amplitudes
    assert np.abs(added).max() > 1e-7
    # Linear machine: twice the load, twice the motion.
    assert twice.amplitudes - base.amplitudes == pytest.approx(2 * added, rel=1e-6, abs=1e-15)
    assert {line.direction for line in effect.signature(ROTOR)} == {"lateral"}


def test_frequency_stays_when_the_speed_changes():
    lines = TORQUE.signature(FLANGE)
    assert [line.frequency_hz for line in lines] == [5.0]
    assert lines[0].order_at(300.0) == pytest.approx(1.0)
    assert lines[0].order_at(600.0) == pytest.approx(0.5)
    with pytest.raises(InvalidValueError, match="does not repeat"):
        harmonic_balance(ALIGNED.with_effects(TORQUE), speed_rpm=700)


def test_gear_mesh_gets_sidebands_of_the_process():
    gearbox = find_machine("gearbox")
    effect = LoadFluctuation(torque_n_m=10.0, frequency_hz=20.0)
    assert effect.signature(gearbox)[0].frequency_hz == 20.0
    options = {"speed_rpm": 1800, "duration_s": 1.0, "rate_hz": 8192.0}
    plain, loaded = gearbox.simulate(**options), gearbox.with_effects(effect).simulate(**options)
    window = np.hanning(plain.time_s.size)
    mesh = 23 * 30
    for side in (mesh - 20, mesh + 20):
        turn = window * np.exp(-2j * np.pi * side * plain.time_s)
        row = [p.name for p in plain.probes].index("transmission error")
        before, after = (abs(np.sum(run.signals[row] * turn)) for run in (plain, loaded))
        assert after > 2 * before


def test_unknown_place():
    with pytest.raises(MissingPartError, match="nowhere"):
        ROTOR.with_effects(LoadFluctuation(at="nowhere")).system(speed_rpm=900)
