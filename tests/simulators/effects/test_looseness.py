"""Looseness: bilinear natural frequency, threshold, half orders, direction, static load of the machine."""

import numpy as np
import pytest
from rotorwise.simulators.effects.gravity import Gravity
from rotorwise.simulators.effects.looseness import Looseness
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.rotor_dynamics.bilinear_spring import BILINEAR_SPRING
from rotorwise.simulators.rotor_dynamics.contact import rounded_ramp
from rotorwise.simulators.rotor_dynamics.support import Support
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.solvers.simulate import simulate
from rotorwise.simulators.solvers.stepper import LaneGroup, Stepper
from rotorwise.simulators.speed_profile import steady

from .jeffcott import CRITICAL, CRITICAL_RPM, MASS, STIFFNESS, footed, rpm

GRAVITY = 9.81


def loose(loss=0.8, hold=0.0):
    # 0.05 of the weight is 0.98 N, so that the least rounding of 1 N holds.
    return Looseness(loss=loss, hold=hold, rounding=0.05)


def test_rounded_ramp_is_twice_differentiable_and_exact_outside():
    depth = np.linspace(-3, 3, 6001)
    ramp = np.array([rounded_ramp(d, 1.0) for d in depth])
    assert np.array_equal(ramp[depth <= -1], np.zeros(np.sum(depth <= -1)))
    assert np.array_equal(ramp[depth >= 1], depth[depth >= 1])
    curvature = np.diff(ramp, 2) / (depth[1] - depth[0]) ** 2
    assert np.abs(np.diff(curvature)).max() < 2e-3
    assert np.all(np.diff(ramp) >= 0)


@pytest.mark.parametrize("loss", [0.3, 0.75, 0.95])
@pytest.mark.parametrize("start_m", [1e-3, 5e-3])
def test_bouncing_frequency_does_not_depend_on_the_amplitude(loss, start_m, figure):
    machine = footed().with_effects(loose(loss))
    profile = steady(speed_rpm=60)
    run = Stepper(LaneGroup([machine], [profile], [machine.system(speed_rpm=profile)]), step_s=1e-4, start_s=0.0)
    state = np.zeros((run.system.states, 1))
    state[run.system.coordinates.index("y"), 0] = -start_m
    run.states[:] = run.form.inverse @ state
    y = np.concatenate([run.advance(run.block) for _ in range(4)])[:, 1, 0]
    rising = np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    crossing = (rising - y[rising] / (y[rising + 1] - y[rising])) * 1e-4
    period = np.diff(crossing).mean()
    soft = np.sqrt(1 - loss)
    # The rounded corner (1 N of 800 N or more) shifts it by less than a thousandth.
    assert 2 * np.pi / period == pytest.approx(2 * CRITICAL * soft / (1 + soft), rel=1e-3)
    expected = 2 * CRITICAL * soft / (1 + soft)
    figure("Frequency of a lifting foot against the bilinear oscillator", 2 * np.pi / period, expected)
    # Half a wave against k, the other half against (1 - loss) k: the swing upward is longer by 1 / sqrt(1 - loss).
    assert y.max() / -y.min() == pytest.approx(1 / soft, rel=0.01)


def spectrum(machine, speed_rpm, *, turns=128, per_turn=64, settle_s=6.0):
    rate = per_turn * speed_rpm / 60
    made = simulate(machine, speed_rpm=speed_rpm, duration_s=turns * 60 / speed_rpm, rate_hz=rate, settle_s=settle_s)
    lines = 2 * np.abs(np.fft.rfft(made.probe("y"))) / (turns * per_turn)
    return lambda order: float(lines[round(order * turns)])


def test_nothing_happens_below_the_threshold_and_multiples_of_1x_above():
    # Lifts where the vertical amplitude m e w^2 / (k - m w^2) exceeds the sag m g / k, less the rounded corner.
    speed = 0.5 * CRITICAL
    sag = MASS * GRAVITY / STIFFNESS
    critical = (sag - 1.0 / STIFFNESS) * (1 - 0.25) / 0.25
    machine = footed(gravity_m_s2=GRAVITY, damping_ratio=0.05)
    below, above = (
        footed(gravity_m_s2=GRAVITY, damping_ratio=0.05, eccentricity_m=factor * critical) for factor in (0.98, 1.3)
    )
    held = [harmonic_balance(m, speed_rpm=rpm(speed)) for m in (below, below.with_effects(loose(hold=1.0)))]
    assert held[1].amplitudes == pytest.approx(held[0].amplitudes, abs=1e-12 * sag)
    lifted = harmonic_balance(above.with_effects(loose(hold=1.0)), speed_rpm=rpm(speed), harmonics=16)
    assert abs(lifted.amplitude("y", 2.0)) > 0.01 * abs(lifted.amplitude("y", 1.0))
    # A mean lift, and nothing in x: the loose direction is the vertical one.
    mean = harmonic_balance(machine, speed_rpm=rpm(speed)).amplitude("y", 0.0).real
    assert lifted.amplitude("y", 0.0).real > mean + 0.01 * sag
    assert abs(lifted.amplitude("x", 2.0)) < 1e-9 * abs(lifted.amplitude("x", 1.0))


def test_lines_come_above_a_threshold_speed():
    """A foot that stands by the weight: nothing below, multiples of 1X just above, of 1/2 X far above."""
    eccentricity, loss = 1e-4, 0.75
    # Opens where e r^2 / (1 - r^2) reaches the sag, less the rounded corner of 1 N.
    sag = (MASS * GRAVITY - 1.0) / STIFFNESS
    threshold = np.sqrt(sag / (eccentricity + sag)) * CRITICAL
    tight = footed(gravity_m_s2=GRAVITY, eccentricity_m=eccentricity, damping_ratio=0.02)
    machine = tight.with_effects(loose(loss, hold=1.0))
    below = [harmonic_balance(m, speed_rpm=rpm(0.99 * threshold), harmonics=12) for m in (tight, machine)]
    assert below[1].amplitudes == pytest.approx(below[0].amplitudes, abs=1e-9 * sag)
    above = harmonic_balance(machine, speed_rpm=rpm(1.05 * threshold), harmonics=12)
    assert all(abs(above.amplitude("y", n)) > 1e-3 * abs(above.amplitude("y", 1.0)) for n in (2, 3))
    bouncing = 2 * CRITICAL * np.sqrt(1 - loss) / (1 + np.sqrt(1 - loss))
    far, near = (spectrum(machine, rpm(speed)) for speed in (2 * bouncing, 1.05 * threshold))
    assert far(0.5) > 0.3 * far(1.0)
    assert all(far(order) > 1e-3 * far(1.0) for order in (1.5, 2.0, 2.5))
    assert near(0.5) < 1e-4 * near(1.0)


def test_half_order_where_the_speed_is_twice_the_bouncing_frequency():
    loss = 0.75
    bouncing = 2 * CRITICAL * np.sqrt(1 - loss) / (1 + np.sqrt(1 - loss))
    machine = footed(eccentricity_m=1e-4, damping_ratio=0.02).with_effects(loose(loss))
    there = spectrum(machine, rpm(2 * bouncing))
    assert there(0.5) > 0.5 * there(1.0)
    assert there(1.5) > 1e-3 * there(1.0)
    lower = spectrum(machine, rpm(0.7 * bouncing))
    assert lower(0.5) < 1e-4 * lower(1.0)
    tight = spectrum(footed(eccentricity_m=1e-4, damping_ratio=0.02), rpm(2 * bouncing))
    assert tight(0.5) < 1e-4 * tight(1.0)


def test_opening_point_is_the_static_elongation_of_the_machine():
    def opens(machine, **values):
        made = machine.with_effects(loose(**values)).assembly(speed_rpm=1000)
        return next(f for f in made.forces if f.law is BILINEAR_SPRING).parameters[1]

    sag = MASS * GRAVITY / STIFFNESS
    machine = footed(gravity_m_s2=GRAVITY)
    assert opens(machine) == pytest.approx(-sag, rel=1e-9)
    assert opens(machine, hold=1.0) == pytest.approx(0.0, abs=1e-9 * sag)
    assert opens(machine, hold=3.0) == pytest.approx(2 * sag, rel=1e-9)
    assert opens(footed()) == 0.0
    # Weight that another effect brings counts, whatever the order.
    rotors = find_machine("rigid_coupling")
    one, two = (
        opens(rotors.with_effects(*effects)) for effects in ([Gravity(), Unbalance()], [Unbalance(), Gravity()])
    )
    assert one == pytest.approx(two, rel=1e-9)
    assert one < opens(rotors) - 1e-5


def test_two_loose_joints_at_one_foot_leave_what_both_leave():
    one = Support("s", {"x": 1.0}, {"y": 1.0}, 1e6, 1e6)
    with pytest.raises(InvalidValueError, match="rounding"):
        one.loosen(loss=0.5, hold=0.0, rounding=0.0)
    machine = footed(gravity_m_s2=GRAVITY).with_effects(loose(0.5), loose(0.4))
    forces = [f for f in machine.assembly(speed_rpm=1000).forces if f.law is BILINEAR_SPRING]
    assert sum(f.parameters[0] for f in forces) == pytest.approx((1 - 0.5 * 0.6) * STIFFNESS)


def test_critical_speed_falls():
    machine = footed(eccentricity_m=1e-5, damping_ratio=0.05, foot_share=0.5)
    speeds = np.linspace(0.75, 1.1, 36) * CRITICAL_RPM
    peaks = []
    for made in (machine, machine.with_effects(loose(0.9))):
        size = [abs(harmonic_balance(made, speed_rpm=s, harmonics=6).amplitude("y", 1.0)) for s in speeds]
        peaks.append(speeds[np.argmax(size)])
    assert peaks[1] < 0.92 * peaks[0]
