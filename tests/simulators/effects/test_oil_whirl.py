"""Oil whirl: onset, frequency and radius of the limit cycle in closed form, tracking and whip, no film no sleeve."""

import numpy as np
import pytest
from rotorwise.simulators.effects.oil_whirl import OilWhirl
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.rotor_dynamics.film_sleeve import FILM
from rotorwise.simulators.solvers.harmonic_balance import NoPeriodicMotionError, harmonic_balance
from rotorwise.simulators.solvers.simulate import simulate

from .jeffcott import CRITICAL, CRITICAL_RPM, MASS, STIFFNESS, jeffcott, rpm

SHARE = 0.45
ONSET = 1500.0


def film(**values):
    chosen = {"damping_n_s_m": 50.0, "mass_kg": 0.2, "onset_rpm": ONSET, "orbit_m": 1e-4, **values}
    return OilWhirl(speed_share=SHARE, **chosen)


def whirl(machine, speed_rpm, *, duration_s=4.0, settle_s=4.0, **options):
    """Return frequency (Hz) and amplitude of the strongest line of z that is not 1X, forward positive."""
    rate = 2000.0
    made = simulate(machine, speed_rpm=speed_rpm, duration_s=duration_s, rate_hz=rate, settle_s=settle_s, **options)
    z = made.probe("x") + 1j * made.probe("y")
    window = np.hanning(z.size)
    found = np.abs(np.fft.fft((z - z.mean()) * window)) / window.sum()
    frequency = np.fft.fftfreq(z.size, 1 / rate)
    found[np.abs(np.abs(frequency) - speed_rpm / 60) < 2] = 0.0
    return frequency[np.argmax(found)], found.max()


@pytest.mark.parametrize("factor", [1.2, 2.0])
def test_limit_cycle_on_a_stiff_shaft(factor, figure):
    # Far below the critical speed the shaft yields by m w^2 / k: it stands still within a percent.
    speed = factor * ONSET
    assert SHARE * speed < 0.25 * CRITICAL_RPM
    machine = jeffcott(eccentricity_m=1e-6, damping_ratio=0.05).with_effects(film())
    frequency, size = whirl(machine, speed, settle_s=3.0)
    omega = SHARE * speed * 2 * np.pi / 60
    assert frequency == pytest.approx(omega / (2 * np.pi), abs=0.3)
    radius = 1e-4 * (factor**2 - 1) ** 0.25
    pushed = 0.2 * omega**2 * radius / (STIFFNESS - MASS * omega**2)
    assert size == pytest.approx(pushed, rel=0.03)
    figure("Orbit of the shaft in oil whirl against closed form", size, pushed)


def test_no_whirl_below_the_onset_speed():
    machine = jeffcott(eccentricity_m=1e-6, damping_ratio=0.05).with_effects(film())
    below, above = (whirl(machine, factor * ONSET)[1] for factor in (0.9, 1.1))
    assert below < 1e-4 * above


def test_it_tracks_the_speed_and_then_whips_at_the_critical_speed():
    machine = jeffcott(eccentricity_m=1e-6, damping_ratio=0.005).with_effects(film())
    own = CRITICAL / (2 * np.pi) / np.sqrt(1 + 0.2 / MASS)
    found = {}
    for ratio in (0.4, 0.7, 1.1, 1.3, 1.6):
        speed = ratio * rpm(2 * np.pi * own) / SHARE
        found[ratio] = whirl(machine, speed, settle_s=6.0, step_s=2e-4)[0] / own
    assert found[0.4] == pytest.approx(0.4, rel=0.01)
    assert found[0.7] == pytest.approx(0.7, rel=0.02)
    locked = [found[ratio] for ratio in (1.1, 1.3, 1.6)]
    assert np.ptp(locked) < 0.03
    assert locked[0] == pytest.approx(1.0, abs=0.06)


def test_whirl_turns_forward():
    machine = jeffcott(eccentricity_m=1e-6, damping_ratio=0.05).with_effects(film())
    assert whirl(machine, 2 * ONSET)[0] > 0


def test_without_a_film_there_is_no_sleeve():
    rig = find_machine("test_rig")
    one, two = (m.system(speed_rpm=1800) for m in (rig, rig.with_effects(film(damping_n_s_m=0.0))))
    assert one.coordinates == two.coordinates
    assert len(rig.with_effects(film(), film()).system(speed_rpm=1800).coordinates) == len(one.coordinates) + 4


def test_the_film_law_is_cross_coupled_and_does_no_work_by_its_stiffness():
    parameters = np.array([10.0, 1e4, 1e-8])[:, None]
    motion = np.array([[3e-5], [-4e-5]])
    u = np.zeros((2, 1))
    FILM.force(np.array([[2000.0]]), parameters, motion, np.arange(2), np.arange(2), u)
    stiffer = 1e4 * (25e-10 / 1e-8) ** 2
    s = motion[0, 0] + 1j * motion[1, 0]
    assert u[0, 0] + 1j * u[1, 0] == pytest.approx(-stiffer * s + 2000j * s, rel=1e-12)


@pytest.mark.parametrize("speed", [1500.0, 2400.0])
def test_the_line_of_the_test_rig_tracks_the_speed(speed):
    rig = find_machine("test_rig").with_effects(OilWhirl())
    made = simulate(rig, speed_rpm=speed, duration_s=4.0, rate_hz=2048.0)
    signal = made.probe("housing_a_x")
    spectrum = np.abs(np.fft.rfft(signal * np.hanning(signal.size)))
    orders = np.fft.rfftfreq(signal.size, 1 / 2048.0) * 60 / speed
    low = (orders > 0.3) & (orders < 0.7)
    assert orders[low][np.argmax(spectrum[low])] == pytest.approx(0.44, abs=0.015)


def test_a_balance_does_not_take_the_equilibrium_beneath_the_whirl_for_the_motion():
    machine = jeffcott(eccentricity_m=1e-6, damping_ratio=0.05).with_effects(film())
    with pytest.raises(NoPeriodicMotionError, match="film sleeve"):
        harmonic_balance(machine, speed_rpm=2 * ONSET)
