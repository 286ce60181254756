"""Harmonic balance, Floquet multipliers and Lyapunov exponents against theory and against time stepping."""

import numpy as np
import pytest
from rotorwise.simulators.effects import Unbalance
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.law import InterfaceForce, Law, compiled_force, no_signals
from rotorwise.simulators.solvers.floquet import floquet_multipliers
from rotorwise.simulators.solvers.harmonic_balance import (
    NoPeriodicMotionError,
    harmonic_balance,
    harmonic_balances,
)
from rotorwise.simulators.solvers.lyapunov import lyapunov_exponent
from scipy.special import mathieu_a, mathieu_b

from .small_machines import add_probes, define, duffing, rotor, switching

RPM = 60.0 / (2 * np.pi)


def parametric_rotor():
    return rotor(parametric=4000.0, damping=2e-3).with_effects(Unbalance(moment_kg_m=1e-4, angle_rad=0.3))


def test_harmonic_balance_agrees_with_time_stepping_to_1e_6():
    machine, speed = parametric_rotor(), 1200.0
    balance = harmonic_balance(machine, speed_rpm=speed, harmonics=12)
    assert abs(balance.amplitude("x displacement", 3)) > 1e-6 * abs(balance.amplitude("x displacement", 1))
    # 20 turns a second: whole turns in the record; the filter's ripple is taken out by comparing at its output rate
    # far below its edge.
    run = machine.simulate(speed_rpm=speed, duration_s=0.5, rate_hz=20_000.0, settle_s=15.0)
    turns = np.exp(-1j * np.outer(balance.orders[:6], run.phase_rad))
    found = 2 * run.signals @ turns.T / run.phase_rad.size
    for probe in range(len(run.probes)):
        scale = np.abs(balance.amplitudes[probe]).max()
        # The pass band of the decimation filter is flat to 1e-5 of a line; its ripple is the same for all, so the
        # first order calibrates it.
        ripple = found[probe, 1] / balance.amplitudes[probe, 1]
        assert abs(ripple - 1) < 2e-5
        assert np.abs(found[probe, 1:] - ripple * balance.amplitudes[probe, 1:6]).max() < 1e-6 * scale


def test_harmonic_balance_is_exactly_linear_in_the_force():
    base = rotor(parametric=4000.0)
    speed = 1500.0
    one, two, both = (
        harmonic_balance(base.with_effects(*effects), speed_rpm=speed).amplitudes
        for effects in (
            [Unbalance(moment_kg_m=1e-4)],
            [Unbalance(moment_kg_m=3e-4, angle_rad=1.0)],
            [Unbalance(moment_kg_m=1e-4), Unbalance(moment_kg_m=3e-4, angle_rad=1.0)],
        )
    )
    assert np.abs(one + two - both).max() < 1e-13 * np.abs(both).max()


def test_harmonic_balance_converges_with_the_number_of_harmonics():
    machine = parametric_rotor().with_parameters(parametric=15_000.0)
    best = harmonic_balance(machine, speed_rpm=2100.0, harmonics=16).amplitudes
    errors = []
    for harmonics in (2, 3, 4):
        found = harmonic_balance(machine, speed_rpm=2100.0, harmonics=harmonics).amplitudes
        errors.append(np.abs(found[:, :3] - best[:, :3]).max() / np.abs(best).max())
    assert errors[0] > 10 * errors[1] > 100 * errors[2] > 0


def test_nonlinear_balance_is_the_duffing_closed_form_for_small_drive():
    # One-term harmonic balance of Duffing's equation is exact to first order in the cubic term; a stiff linear spring
    # keeps the third harmonic at 1e-5.
    machine = duffing(stiffness=100.0, cubic=50.0, drive=10.0, damping=0.5)
    w = 6.0
    found = harmonic_balance(machine, speed_rpm=w * RPM, harmonics=7)
    amplitude = abs(found.amplitude("a displacement", 1))
    force = np.hypot((100.0 - w**2) * amplitude + 0.75 * 50.0 * amplitude**3, 0.5 * w * amplitude)
    assert force == pytest.approx(10.0, rel=1e-3)
    run = machine.simulate(speed_rpm=w * RPM, duration_s=4 * np.pi / w, rate_hz=64 * w / (2 * np.pi), settle_s=120.0,
                           step_s=0.002)  # fmt: skip
    assert np.abs(run.probe("a displacement") - found.waveform(run.phase_rad)[0]).max() < 3e-5 * amplitude


def test_of_two_motions_the_one_close_by_is_found():
    # Duffing's hardening spring is driven at a speed at which a large and a small motion are both possible; the large
    # one is reached from lower speeds, step by step.
    machine = duffing(stiffness=100.0, cubic=50.0, drive=10.0, damping=0.5)
    (near,) = harmonic_balances([(machine, [9.0 * RPM])], harmonics=7)
    for w in np.linspace(9.0, 12.5, 15):
        (near,) = harmonic_balances([(machine, [w * RPM])], harmonics=7, near=[near])
    (beside,) = harmonic_balances([(machine.with_parameters(drive=10.01), [w * RPM])], harmonics=7, near=[near])
    (rest,) = harmonic_balances([(machine, [w * RPM])], harmonics=7)
    large, larger, small = (abs(one[0].amplitude("a displacement", 1)) for one in (near, beside, rest))
    assert large > 3 * small
    assert larger == pytest.approx(large, rel=1e-2)
    for amplitude in (large, small):
        cubic = 0.75 * 50.0 * amplitude**3
        force = np.hypot((100.0 - w**2) * amplitude + cubic, 0.5 * w * amplitude)
        # One term leaves out what the third harmonic, a hundredth of the first, adds to the cubic force.
        assert force == pytest.approx(10.0, rel=1e-3, abs=0.02 * cubic)


def test_balance_of_a_switching_spring_agrees_with_time_stepping():
    # Two revolutions are the period: three switches in two turns. Jumps make the harmonics fall slowly.
    machine, w = switching(), 1.1
    found = harmonic_balance(machine, speed_rpm=w * RPM, harmonics=120, revolutions=2)
    run = machine.simulate(speed_rpm=w * RPM, duration_s=4 * np.pi / w * 2, rate_hz=20.0, settle_s=400.0)
    wave = found.waveform(run.phase_rad)
    scale = np.ptp(wave[0])
    assert np.abs(run.signals[0] - wave[0]).max() < 2e-3 * scale


def test_forces_that_do_not_repeat_are_refused():
    with pytest.raises(InvalidValueError, match="revolutions"):
        harmonic_balance(switching(), speed_rpm=10.0)


@compiled_force
def _runaway(signals, parameters, x, inputs, outputs, u):
    for lane in range(x.shape[1]):
        u[outputs[0], lane] += 1.0 + x[inputs[0], lane] ** 2


def test_no_periodic_motion_is_said():
    # A unit spring against 1 + x^2, which is larger than x everywhere: there is no equilibrium, let alone a motion.
    def build(assembly, values, switches):
        assembly.add_coordinate("a", mass=1.0)
        assembly.add_spring({"a": 1.0}, stiffness=1.0, damping=0.1)
        x = ({"a": 1.0},)
        assembly.forces.append(InterfaceForce("runaway", Law("runaway", no_signals, _runaway), (), x, x))
        add_probes(assembly, "a")

    with pytest.raises(NoPeriodicMotionError, match="simulate it in time"):
        harmonic_balance(define(build), speed_rpm=RPM)


@pytest.mark.parametrize(("offset", "stable"), [(-0.02, True), (0.02, False)])
def test_mathieu_stability_boundary(offset, stable):
    # x'' + (a - 2 q cos 2 tau) x = 0 with phi = 2 tau: stiffness a / 4, parametric amplitude q / 2. Between
    # b_1(q) and a_1(q) it is unstable.
    q = 0.5
    for edge, side in ((mathieu_b(1, q), 1), (mathieu_a(1, q), -1)):
        a = edge + side * offset
        machine = duffing(stiffness=a / 4, parametric=-q / 2, damping=0.0)
        assert floquet_multipliers(machine, speed_rpm=RPM).is_stable == stable


def test_multipliers_of_a_constant_machine_are_those_of_its_core():
    machine, speed = rotor(), 1800.0
    found = floquet_multipliers(machine, speed_rpm=speed).multipliers
    core = np.linalg.eigvals(machine.system(speed_rpm=speed).core)
    expected = np.exp(core * 60 / speed)
    assert np.sort(np.abs(found)) == pytest.approx(np.sort(np.abs(expected)), rel=1e-8)


def test_growth_rate_is_what_time_stepping_shows():
    machine = duffing(stiffness=0.25, parametric=0.15, damping=0.02)
    rate = floquet_multipliers(machine, speed_rpm=RPM).growth_rate_1_s
    assert rate > 0
    # Intervals of whole periods: inside one the growth varies.
    period = 2 * np.pi
    found = lyapunov_exponent(machine, speed_rpm=RPM, duration_s=400 * period, step_s=period / 128)
    assert found.exponent_1_s == pytest.approx(rate, rel=1e-3)


def test_exponent_of_a_damped_linear_machine_is_its_damping():
    machine = duffing(stiffness=1.0, damping=0.2, drive=1.0)
    found = lyapunov_exponent(machine, speed_rpm=0.7 * RPM, duration_s=200 * np.pi, settle_s=100.0)
    assert found.exponent_1_s == pytest.approx(-0.1, rel=0.02)
    assert not found.is_chaotic
    assert "regular" in found.sentence


def test_chaos_of_the_two_well_oscillator_is_recognised():
    # The Duffing-Holmes oscillator x'' + 0.25 x' - x + x^3 = 0.3 cos t is the textbook strange attractor
    # (J. Guckenheimer, P. Holmes 1983, section 2.2).
    machine = duffing(stiffness=-1.0, cubic=1.0, damping=0.25, drive=0.3)
    found = lyapunov_exponent(machine, speed_rpm=RPM, duration_s=3000.0, settle_s=200.0, intervals=400)
    assert found.is_chaotic
    assert 0.08 < found.exponent_1_s < 0.2
    assert "chaotic" in found.sentence
