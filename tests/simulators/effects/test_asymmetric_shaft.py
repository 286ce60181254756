"""Asymmetric shaft: weight response and instability of the Jeffcott rotor in closed form, keyway, its lines."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rotorwise.simulators.effects.asymmetric_shaft import AsymmetricShaft
from rotorwise.simulators.effects.gravity import Gravity
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.floquet import floquet_multipliers
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

from .jeffcott import CRITICAL, CRITICAL_RPM, jeffcott, orbit

GRAVITY = 9.81


def effect(asymmetry, angle=0.0):
    return AsymmetricShaft(asymmetry=asymmetry, angle_rad=angle, position=0.5)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    ratio=st.floats(0.02, 0.9).filter(lambda r: abs(r - 0.5) > 0.03),
    asymmetry=st.floats(0.001, 0.3),
    angle=st.floats(-3, 3),
)
def test_weight_response(figure, ratio, asymmetry, angle):
    # z'' + w0^2 z - delta w0^2 exp(2 i (phi + angle)) z* = -i g has z = A + B exp(2 i phi).
    machine = jeffcott(gravity_m_s2=GRAVITY).with_effects(effect(asymmetry, angle))
    reduced = 1 - 4 * ratio**2
    mean = -1j * GRAVITY / CRITICAL**2 / (1 - asymmetry**2 / reduced)
    double = asymmetry * np.exp(2j * angle) * np.conj(mean) / reduced
    motion = harmonic_balance(machine, speed_rpm=ratio * CRITICAL_RPM, harmonics=4)
    assert orbit(motion, 2.0)[0] == pytest.approx(double, rel=1e-7)
    figure("2X from the weight of an asymmetric rotor against closed form", orbit(motion, 2.0)[0], double)
    assert orbit(motion, 2.0)[1] == pytest.approx(0, abs=1e-9 * abs(double))
    assert motion.amplitude("x", 0) + 1j * motion.amplitude("y", 0) == pytest.approx(mean, rel=1e-7)


def test_weight_critical_speed_is_half_the_critical_speed():
    machine = jeffcott(gravity_m_s2=GRAVITY, damping_ratio=0.01).with_effects(effect(0.03))
    ratios = np.linspace(0.3, 0.8, 101)
    size = [abs(orbit(harmonic_balance(machine, speed_rpm=r * CRITICAL_RPM, harmonics=4), 2.0)[0]) for r in ratios]
    assert ratios[np.argmax(size)] == pytest.approx(0.5, abs=0.006)
    sag = GRAVITY / CRITICAL**2
    assert max(size) == pytest.approx(sag * 0.03 / (2 * 0.01), rel=0.05)


@pytest.mark.parametrize("asymmetry", [0.02, 0.1, 0.3])
def test_unstable_between_the_two_critical_speeds(asymmetry):
    machine = jeffcott().with_effects(effect(asymmetry))

    def growth(ratio):
        return floquet_multipliers(machine, speed_rpm=ratio * CRITICAL_RPM, steps=256).growth_rate_1_s

    low, high = math.sqrt(1 - asymmetry), math.sqrt(1 + asymmetry)
    width = high - low
    for ratio in (low - 0.05 * width, high + 0.05 * width):
        assert abs(growth(ratio)) < 1e-3
    for ratio in (low + 0.05 * width, 1.0, high - 0.05 * width):
        # lambda^2 of the undamped rotor in the frame that turns.
        square = -(ratio**2 + 1) + math.sqrt(4 * ratio**2 + asymmetry**2)
        assert growth(ratio) == pytest.approx(CRITICAL * math.sqrt(square), rel=1e-3)


def test_damping_above_half_the_asymmetry_keeps_it_stable():
    for damping, stable in ((0.06, True), (0.04, False)):
        machine = jeffcott(damping_ratio=damping).with_effects(effect(0.1))
        speeds = np.linspace(0.94, 1.06, 13) * CRITICAL_RPM
        assert all(floquet_multipliers(machine, speed_rpm=s, steps=128).is_stable for s in speeds) == stable


def test_unbalance_alone_makes_no_double_line_in_equal_supports():
    machine = jeffcott(eccentricity_m=1e-4, damping_ratio=0.02).with_effects(effect(0.05))
    motion = harmonic_balance(machine, speed_rpm=0.4 * CRITICAL_RPM, harmonics=4)
    assert abs(motion.amplitude("x", 2.0)) < 1e-12 * abs(motion.amplitude("x", 1.0))


def test_signature_follows_the_static_load():
    rig, magnets = find_machine("test_rig"), find_machine("amb_rotor")
    assert AsymmetricShaft().signature(rig)[0].order == 2.0
    assert AsymmetricShaft().signature(rig.with_parameters(gravity_m_s2=0.0))[0].order == 1.0
    assert AsymmetricShaft().signature(magnets)[0].order == 1.0
    assert AsymmetricShaft().signature(magnets.with_effects(Gravity()))[0].order == 2.0


def test_2x_of_the_test_rig_grows_with_the_weight():
    rig = find_machine("test_rig").with_effects(AsymmetricShaft())
    half, full = (
        abs(harmonic_balance(rig.with_parameters(gravity_m_s2=g), speed_rpm=1800).amplitude("housing_a_y", 2.0))
        for g in (4.905, 9.81)
    )
    assert full == pytest.approx(2 * half, rel=1e-9)
