"""Empirical stiffness: as a spring of the machine, and the closed form of a rotor on a cross-coupled support."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.empirical_stiffness import EmpiricalStiffness
from rotorwise.simulators.errors import RotorwiseError
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

from .jeffcott import CRITICAL, MASS, STIFFNESS, jeffcott

RIGID = find_machine("rigid_coupling")
RPM = 60 / (2 * math.pi)


def test_it_is_a_spring_and_damper_of_the_support():
    given = RIGID.values
    added = RIGID.with_effects(
        EmpiricalStiffness(at="bearing_1", stiffness_n_m=2e7, difference_n_m=0.0, cross_n_m=0.0, damping_n_s_m=3e3)
    )
    stiffer = RIGID.with_parameters(
        support_1_n_m=given["support_1_n_m"] + 2e7, support_damping_1_n_s_m=given["support_damping_1_n_s_m"] + 3e3
    )
    one, two = (harmonic_balance(m, speed_rpm=1700).amplitudes for m in (added, stiffer))
    assert one == pytest.approx(two, rel=1e-9, abs=1e-9 * np.abs(two).max())


@pytest.mark.parametrize(("power", "speed"), [(0.0, 0.6), (1.0, 0.6), (2.0, 0.8), (1.5, 1.3)])
def test_an_unbalanced_rotor_on_a_cross_coupled_support(power, speed, figure):
    machine, ratio, eccentricity = jeffcott(damping_ratio=0.05, eccentricity_m=1e-5), 0.05, 1e-5
    effect = EmpiricalStiffness(
        at="disc",
        stiffness_n_m=0.1 * STIFFNESS,
        difference_n_m=0.0,
        cross_n_m=0.07 * STIFFNESS,
        damping_n_s_m=40.0,
        speed_exponent=power,
        reference_speed_rpm=CRITICAL * RPM,
    )
    w, share = speed * CRITICAL, min(speed, 1.0) ** power
    damping = 2 * ratio * MASS * CRITICAL + 40.0 * share
    dynamic = (1 + 0.1 * share) * STIFFNESS - MASS * w**2 + 1j * (damping * w - 0.07 * share * STIFFNESS)
    expected = MASS * eccentricity * w**2 / dynamic
    motion = harmonic_balance(machine.with_effects(effect), speed_rpm=w * RPM)
    x, y = motion.amplitude("x", 1.0), motion.amplitude("y", 1.0)
    assert x == pytest.approx(expected, rel=1e-9)
    assert y == pytest.approx(-1j * expected, rel=1e-9)
    figure("Unbalanced rotor on a cross-coupled support", x, expected)


def test_unlike_in_x_and_y_it_parts_the_two():
    made = jeffcott(damping_ratio=0.05, eccentricity_m=1e-5)
    nothing = {"cross_n_m": 0.0, "damping_n_s_m": 0.0, "at": "disc"}
    unlike = EmpiricalStiffness(stiffness_n_m=2e4, difference_n_m=5e4, **nothing)
    for axis, stiffness in (("x", 7e4), ("y", -3e4)):
        alone = EmpiricalStiffness(stiffness_n_m=stiffness, difference_n_m=0.0, **nothing)
        one, two = (
            harmonic_balance(made.with_effects(e), speed_rpm=1500).amplitude(axis, 1.0) for e in (unlike, alone)
        )
        assert one == pytest.approx(two, rel=1e-9)


def test_more_of_it_than_the_damping_holds_is_unstable():
    holds = 2 * 0.05 * MASS * CRITICAL**2
    made = jeffcott(damping_ratio=0.05, eccentricity_m=1e-5)
    options = {"speed_rpm": 0.5 * CRITICAL * RPM, "duration_s": 4.0, "rate_hz": 2000.0}
    below, above = (EmpiricalStiffness(at="disc", stiffness_n_m=0.0, cross_n_m=f * holds) for f in (0.9, 1.1))
    assert np.isfinite(made.with_effects(below).simulate(**options).signals).all()
    with pytest.raises(RotorwiseError, match="unstable"):
        made.with_effects(above).simulate(**options)


def test_a_file_keeps_it_and_a_place_must_exist():
    machine = RIGID.with_effects(EmpiricalStiffness(at="bearing_2", stiffness_n_m=-1e6, speed_exponent=2.0))
    assert machine_from_toml(machine.to_toml()) == machine
    with pytest.raises(MissingPartError, match=r"'bearing_9'.*bearing_1"):
        RIGID.with_effects(EmpiricalStiffness(at="bearing_9")).system(speed_rpm=1000)
    with pytest.raises(RotorwiseError, match="stiffness_n_m"):
        EmpiricalStiffness(stiffness_n_m=2e9)
