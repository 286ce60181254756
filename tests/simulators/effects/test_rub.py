"""Rub: synchronous full rub in closed form, exact silence without contact, friction, backward orbit, 1/n X."""

import numpy as np
import pytest
from rotorwise.simulators.effects.rub import Rub
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.rotor_dynamics.rub_contact import RUB
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.solvers.simulate import simulate
from scipy.optimize import fsolve

from .jeffcott import CRITICAL, CRITICAL_RPM, MASS, STIFFNESS, jeffcott, orbit, rpm

CLEARANCE = 2e-4


def centred(**values):
    """Return a ring round the shaft's own centre."""
    return Rub(interference_m=-CLEARANCE, clearance_m=CLEARANCE, angle_rad=0.0, shaft_radius_m=1.0, **values)


@pytest.mark.parametrize("friction", [0.0, 0.15])
@pytest.mark.parametrize("ratio", [0.8, 0.95, 1.05])
def test_full_annular_rub(ratio, friction, figure):
    stiffness, eccentricity, zeta = 5e5, 1.5e-4, 0.1
    speed = ratio * CRITICAL
    machine = jeffcott(eccentricity_m=eccentricity, damping_ratio=zeta).with_effects(
        centred(stiffness_n_m=stiffness, friction=friction)
    )

    def residual(parts):
        z = parts[0] + 1j * parts[1]
        contact = stiffness * (abs(z) - CLEARANCE) * (1 + 1j * friction) * z / abs(z)
        own = (STIFFNESS - MASS * speed**2 + 2j * zeta * MASS * CRITICAL * speed) * z
        left = own + contact - MASS * eccentricity * speed**2
        return [left.real, left.imag]

    start = orbit(harmonic_balance(machine, speed_rpm=rpm(speed), harmonics=3), 1.0)[0]
    parts = fsolve(residual, [start.real, start.imag], xtol=1e-13)
    assert abs(start) > 1.02 * CLEARANCE
    # Sliding at 1 m radius: the friction's fading (0.01 m/s of 300 m/s and more) is not felt.
    assert start == pytest.approx(parts[0] + 1j * parts[1], rel=1e-6)
    figure("Orbit of a full annular rub against its force balance", start, parts[0] + 1j * parts[1])


def test_without_contact_nothing_changes():
    base = jeffcott(eccentricity_m=1e-5, damping_ratio=0.05)
    one, two = (
        harmonic_balance(m, speed_rpm=0.8 * CRITICAL_RPM).amplitudes
        for m in (base, base.with_effects(centred(stiffness_n_m=1e7, friction=0.2)))
    )
    assert two == pytest.approx(one, abs=1e-12 * np.abs(one).max())


def law(x, y, vx=0.0, vy=0.0, *, surface_m_s=30.0, friction=0.2):
    parameters = np.array([1e6, friction, CLEARANCE, 0.0, 0.0, 1e-6, 0.01, 0.1])[:, None]
    motion = np.array([[x], [y], [vx], [vy]], dtype=float)
    u = np.zeros((2, 1))
    RUB.force(np.array([[surface_m_s]]), parameters, motion, np.arange(4), np.arange(2), u)
    return u[:, 0]


def test_friction_pushes_against_the_rotation_until_the_shaft_rolls():
    depth = 1e-5
    assert law(CLEARANCE + depth, 0.0) == pytest.approx([-1e6 * depth, -0.2 * 1e6 * depth], rel=1e-6)
    # Whirling backward at the surface's speed it rolls: no friction; faster, friction turns round.
    assert law(CLEARANCE + depth, 0.0, vy=-30.0)[1] == pytest.approx(0.0, abs=1e-12)
    assert law(CLEARANCE + depth, 0.0, vy=-31.0)[1] == pytest.approx(0.2 * 1e6 * depth, rel=1e-3)
    assert np.array_equal(law(CLEARANCE - 2e-6, 0.0), [0.0, 0.0])
    # The force is the same round the ring.
    turned = law(0.0, -(CLEARANCE + depth))
    assert turned == pytest.approx([-0.2 * 1e6 * depth, 1e6 * depth], rel=1e-6)


def test_partial_rub_makes_multiples_and_a_backward_orbit():
    base = jeffcott(eccentricity_m=5e-5, damping_ratio=0.05)
    rub = Rub(stiffness_n_m=2e5, friction=0.1, interference_m=0.0, clearance_m=CLEARANCE, angle_rad=0.6)
    free, rubbing = (
        harmonic_balance(m, speed_rpm=0.6 * CRITICAL_RPM, harmonics=16) for m in (base, base.with_effects(rub))
    )
    ahead, back = orbit(rubbing, 1.0)
    assert abs(orbit(free, 1.0)[1]) < 1e-9 * abs(orbit(free, 1.0)[0])
    assert abs(back) > 0.01 * abs(ahead)
    assert abs(orbit(rubbing, 2.0)[0]) > 0.003 * abs(ahead)
    assert abs(orbit(rubbing, 2.0)[1]) > 0.003 * abs(ahead)
    # Pushed off the ring on average.
    mean = rubbing.amplitude("x", 0.0) + 1j * rubbing.amplitude("y", 0.0)
    assert (mean * np.exp(-0.6j)).real < 0


def lines(machine, speed_rpm, *, turns=120, per_turn=80, settle_s=4.0):
    """Return the full spectrum of x + i y as a function of order, negative for backward."""
    rate = per_turn * speed_rpm / 60
    made = simulate(machine, speed_rpm=speed_rpm, duration_s=turns * 60 / speed_rpm, rate_hz=rate, settle_s=settle_s)
    found = np.abs(np.fft.fft(made.probe("x") + 1j * made.probe("y"))) / (turns * per_turn)
    return lambda order: float(found[round(order * turns)])


@pytest.mark.parametrize("n", [2, 3])
def test_fractions_of_1x_at_multiples_of_the_frequency_in_contact(n):
    # One-sided contact that just touches: bouncing frequency 2 w sqrt(s) / (1 + sqrt(s)) with s = 1 + k_c / k.
    contact = 2.4e6
    stiff = np.sqrt(1 + contact / STIFFNESS)
    bouncing = 2 * CRITICAL * stiff / (1 + stiff)
    machine = jeffcott(eccentricity_m=2e-4, damping_ratio=0.01).with_effects(
        Rub(stiffness_n_m=contact, friction=0.0, interference_m=0.0, clearance_m=5e-3, angle_rad=0.0)
    )
    seen = lines(machine, rpm(n * bouncing))
    assert seen(1 / n) > 0.1 * seen(1.0)


def test_dry_friction_whirls_backward_by_itself():
    # Pressed all round (clearance below the roughness it needs): friction beats the damping, 2 zeta k < mu k_c.
    machine = jeffcott(eccentricity_m=1e-4, damping_ratio=0.005).with_effects(
        Rub(
            stiffness_n_m=1e6,
            friction=0.3,
            interference_m=-2e-5,
            clearance_m=2e-5,
            angle_rad=0.0,
            shaft_radius_m=0.01,
        )
    )
    speed = rpm(0.8 * CRITICAL)
    rate = 80 * speed / 60
    made = simulate(machine, speed_rpm=speed, duration_s=1.0, rate_hz=rate, settle_s=1.0, step_s=2e-5)
    z = made.probe("x") + 1j * made.probe("y")
    found = np.abs(np.fft.fft(z * np.hanning(z.size)))
    frequency = np.fft.fftfreq(z.size, 1 / rate)
    strongest = frequency[np.argmax(found)]
    # Faster than the shaft's own frequency, as the ring stiffens it, and against the rotation.
    assert strongest < -CRITICAL / (2 * np.pi)
    # Friction ends where the whirl rolls: |z| w_whirl = R w.
    assert np.median(np.abs(z)) * 2 * np.pi * -strongest <= 1.1 * 0.01 * 0.8 * CRITICAL


def test_retainer_of_the_magnetic_bearings_limits_the_orbit():
    rotor = find_machine("amb_rotor").with_parameters(unbalance_kg_m=2e-3)
    ring = Rub(
        at="retainer_1", stiffness_n_m=1e6, friction=0.1, interference_m=-125e-6, clearance_m=125e-6, angle_rad=0.0
    )
    free, held = (
        np.abs(harmonic_balance(m, speed_rpm=2400, harmonics=6).amplitude("path_1", 1.0))
        for m in (rotor, rotor.with_effects(ring))
    )
    assert free > 125e-6
    assert held < free
