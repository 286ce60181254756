"""Order tracking: amplitude and phase at varying speed, against the exact angle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal.order_tracking import (
    angular_resample,
    constant_speed_phase,
    order_amplitudes,
    phase_from_pulses,
)
from rotorwise.simulators.errors import InvalidValueError

RATE = 10_000.0
TIME = np.arange(80_000) / RATE


def ramp(time: np.ndarray) -> np.ndarray:
    """Shaft angle in turns, 20 to 30 Hz in 8 s."""
    return 0.2 + 20 * time + 0.5 * (10 / 8) * time**2


def sway(time: np.ndarray) -> np.ndarray:
    """Shaft angle in turns, 25 Hz with +-8 % at 0.4 Hz."""
    return 0.2 + 25 * time - 2 / (2 * np.pi * 0.4) * np.cos(2 * np.pi * 0.4 * time)


PROFILES = {"ramp": ramp, "sway": sway}
# order, amplitude, phase in turns
LINES = ((0.5, 0.3, 0.1), (1.0, 2.0, 0.25), (2.0, 0.7, 0.6), (3.05, 0.5, 0.9), (17.0, 0.2, 0.4))


def machine(angle: np.ndarray) -> np.ndarray:
    return np.sum([a * np.cos(2 * np.pi * (order * angle + p)) for order, a, p in LINES], axis=0)


def pulses_of(profile, *, per_turn: float = 1.0) -> np.ndarray:
    """Exact times at which the shaft angle passes whole multiples of 1/per_turn, first one after the start."""
    fine = np.linspace(0, TIME[-1], 400_001)
    angle = profile(fine)
    wanted = np.arange(np.ceil(angle[0] * per_turn), np.floor(angle[-1] * per_turn) + 1) / per_turn
    return np.interp(wanted, angle, fine)


# --- order amplitudes -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", PROFILES)
def test_amplitude_and_phase_of_orders_to_1e_3(profile):
    angle = PROFILES[profile](TIME)
    amplitude, _ = order_amplitudes(machine(angle), phase_turns=angle, orders=[order for order, _, _ in LINES])
    expected = np.array([a * np.exp(2j * np.pi * p) for _, a, p in LINES])
    assert np.abs(amplitude[0] / expected - 1).max() < 1e-3


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("per_turn", [1, 8])
def test_amplitude_and_phase_with_the_angle_from_tacho_pulses(profile, per_turn):
    angle = phase_from_pulses(
        pulses_of(PROFILES[profile], per_turn=per_turn), samples=TIME.size, rate_hz=RATE, pulses_per_revolution=per_turn
    )
    truth = PROFILES[profile](TIME)
    zero = np.ceil(truth[0] * per_turn) / per_turn
    amplitude, _ = order_amplitudes(machine(truth - zero), phase_turns=angle, orders=[0.5, 1.0, 2.0])
    expected = np.array([a * np.exp(2j * np.pi * p) for _, a, p in LINES[:3]])
    assert np.abs(amplitude[0] / expected - 1).max() < 1e-3


def test_an_order_between_two_lines_is_empty():
    angle = ramp(TIME)
    amplitude, _ = order_amplitudes(machine(angle), phase_turns=angle, orders=[1.5, 2.5, 10.0])
    assert np.abs(amplitude).max() < 1e-4


def test_the_stated_deviation_against_monte_carlo():
    """Scatter of |A| over 400 draws; white noise gives sqrt(2 sum w^2) / sum w sigma = sigma sqrt(3 / n)."""
    samples, sigma = 4000, 0.5
    angle = constant_speed_phase(samples=samples, rate_hz=1000, speed_hz=25)
    clean = np.cos(2 * np.pi * 2 * angle)
    rng = np.random.default_rng(0)
    noise = rng.normal(0, sigma, (400, samples))
    amplitude, deviation = order_amplitudes(clean + noise, phase_turns=angle, orders=[2.0])
    scatter = np.abs(amplitude[:, 0]).std()
    assert scatter == pytest.approx(sigma * np.sqrt(3 / samples), rel=0.12)
    # Root mean square of the stated deviations: 400 draws of 14 degrees of freedom scatter by 1.3 %, the Monte Carlo
    # by 3.5 %.
    assert np.sqrt((deviation**2).mean()) == pytest.approx(scatter, rel=0.12)


def test_too_few_turns_state_no_deviation():
    angle = constant_speed_phase(samples=600, rate_hz=1000, speed_hz=25)
    _, deviation = order_amplitudes(np.cos(2 * np.pi * angle), phase_turns=angle, orders=[1.0])
    assert np.isnan(deviation).all()


@given(gain=st.floats(1e-6, 1e6), turn=st.floats(0, 1), order=st.permutations(range(3)))
@settings(max_examples=20, deadline=None)
def test_scaling_turning_the_zero_and_channel_order(gain, turn, order):
    angle = ramp(TIME[:20_000])
    signals = np.stack([np.cos(2 * np.pi * (order * angle + 0.1)) for order in (1, 2, 3)])
    orders = np.array([1.0, 2.0, 3.0])
    plain, _ = order_amplitudes(signals, phase_turns=angle, orders=orders)
    other, _ = order_amplitudes(gain * signals[list(order)], phase_turns=angle - turn, orders=orders)
    expected = gain * plain[list(order)] * np.exp(2j * np.pi * orders * turn)
    assert other == pytest.approx(expected, rel=1e-6, abs=1e-9 * gain)


# --- resampling -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("per_turn", [64, 256])
def test_resampling_gives_the_signal_at_equal_angles(profile, per_turn):
    angle = PROFILES[profile](TIME)
    got = angular_resample(machine(angle), phase_turns=angle, samples_per_turn=per_turn)
    grid = np.ceil(angle[0]) + np.arange(got.shape[1]) / per_turn
    # The ends ring where the record is cut.
    inner = slice(per_turn, -per_turn)
    assert got[0, inner] == pytest.approx(machine(grid)[inner], abs=1e-3 * 3.7)


@pytest.mark.parametrize("profile", PROFILES)
def test_orders_above_half_the_new_rate_do_not_fold(profile):
    angle = PROFILES[profile](TIME)
    high = np.cos(2 * np.pi * 61.3 * angle)
    got = angular_resample(high, phase_turns=angle, samples_per_turn=64)[0]
    # Without the filter 61.3 orders would stand at 2.7 with amplitude 1.
    assert np.abs(got[64:-64]).max() < 2e-3


def test_a_fixed_frequency_smears_and_an_order_stands():
    angle = ramp(TIME)
    signals = np.stack([np.cos(2 * np.pi * 3 * angle), np.cos(2 * np.pi * 75.0 * TIME)])
    got = angular_resample(signals, phase_turns=angle, samples_per_turn=128)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(got.shape[1]) / got.shape[1])
    spectrum = 2 * np.abs(np.fft.rfft(got * window, axis=1)) / window.sum()
    assert spectrum[0].max() == pytest.approx(1.0, abs=1e-3)
    assert spectrum[1].max() < 0.25


@given(turns=st.integers(1, 40), speed=st.floats(5, 60), start=st.floats(0, 3))
@settings(max_examples=30, deadline=None)
def test_only_whole_turns_are_returned(turns, speed, start):
    samples = int(turns / speed * 2000) + 5
    angle = start + constant_speed_phase(samples=samples, rate_hz=2000, speed_hz=speed)
    whole = int(np.floor(angle[-1]) - np.ceil(angle[0]))
    signal = np.zeros((2, samples))
    if whole < 1:
        with pytest.raises(InvalidValueError, match="whole turns"):
            angular_resample(signal, phase_turns=angle, samples_per_turn=16)
    else:
        assert angular_resample(signal, phase_turns=angle, samples_per_turn=16).shape == (2, 16 * whole)


def test_an_angle_that_stands_still_is_refused():
    angle = np.array([0.0, 0.5, 0.5, 1.0, 1.5, 2.5])
    with pytest.raises(InvalidValueError, match="does not rise"):
        angular_resample(np.zeros(6), phase_turns=angle, samples_per_turn=8)


# --- phase from pulses ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("per_turn", [1, 3, 60])
def test_phase_from_pulses_follows_the_shaft(profile, per_turn):
    times = pulses_of(PROFILES[profile], per_turn=per_turn)
    angle = phase_from_pulses(times, samples=TIME.size, rate_hz=RATE, pulses_per_revolution=per_turn)
    truth = PROFILES[profile](TIME)
    truth = truth - np.ceil(truth[0] * per_turn) / per_turn
    time = TIME
    inside = (time >= times[0]) & (time <= times[-1])
    assert np.abs(angle - truth)[inside].max() < 2e-4
    # Outside, less than one pulse distance is run on at the end speed.
    assert np.abs(angle - truth).max() < 1e-2
    assert (np.diff(angle) > 0).all()


def test_phase_at_constant_speed_is_exact_outside_the_pulses_too():
    angle = phase_from_pulses(np.array([0.14, 0.24, 0.34]), samples=1000, rate_hz=1000)
    assert angle == pytest.approx(10 * (np.arange(1000) / 1000 - 0.14), abs=1e-9)


def test_two_pulses_are_refused():
    with pytest.raises(InvalidValueError, match="2 tacho pulses; allowed: 3 or more"):
        phase_from_pulses(np.array([0.1, 0.2]), samples=100, rate_hz=100)
