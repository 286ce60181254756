"""Synchronous average and gear indicators against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal.synchronous_average import (
    difference_signal,
    gear_indicators,
    phase_locked_to_mesh,
    residual_signal,
    synchronous_average,
)
from rotorwise.simulators.errors import InvalidValueError

RATE = 20_000.0
TIME = np.arange(80_000) / RATE
#: 20 to 30 Hz in 4 s, beginning within a turn.
ANGLE = 0.37 + 20 * TIME + 0.5 * 2.5 * TIME**2
TEETH = 23
TURN = np.arange(1000) / 1000


def gear(angle: np.ndarray) -> np.ndarray:
    return np.cos(2 * np.pi * (TEETH * angle + 0.1)) + 0.3 * np.cos(2 * np.pi * (2 * TEETH * angle + 0.4))


def test_average_over_a_run_up_is_the_gear_at_every_angle():
    other = np.cos(2 * np.pi * 0.6180339 * 31 * ANGLE)
    found = synchronous_average(gear(ANGLE) + other, phase_turns=ANGLE, highest_order=4 * TEETH)
    grid = np.arange(found.average.shape[1]) / found.average.shape[1]
    # The other shaft's line is left with 1 / (turns |sin|) of its height at most.
    assert found.average[0] == pytest.approx(gear(grid), abs=2.0 / found.turns)
    assert found.turns == int(ANGLE[-1]) - 1


def test_the_mesh_itself_keeps_the_angle_without_a_tacho():
    """A speed 3e-4 off and a wander of 0.1 %: half a tooth after 60 turns; the average would fade."""
    wandering = 25 * TIME + 0.02 * np.sin(2 * np.pi * 0.4 * TIME)
    signal = gear(wandering) + 0.1 * np.cos(2 * np.pi * wandering) + np.random.default_rng(5).normal(0, 0.3, TIME.size)
    rough = 25 * (1 + 3e-4) * TIME
    locked = phase_locked_to_mesh(signal, rate_hz=RATE, phase_turns=rough, mesh_order=TEETH, bandwidth_hz=5.0)
    faded = synchronous_average(signal, phase_turns=rough, highest_order=4 * TEETH).orders()[0]
    kept = synchronous_average(signal, phase_turns=locked, highest_order=4 * TEETH).orders()[0]
    assert abs(kept[TEETH]) == pytest.approx(1.0, abs=0.03)
    assert abs(kept[2 * TEETH]) == pytest.approx(0.3, abs=0.03)
    assert abs(faded[TEETH]) < 0.7


def test_noise_falls_with_the_root_of_the_turns_and_the_deviation_says_so():
    noise = np.random.default_rng(0).normal(0, 1.0, TIME.size)
    found = synchronous_average(noise, phase_turns=ANGLE, highest_order=100)
    # Averaged 99 times; the bandwidth kept, at least a quarter of the record's, takes off more.
    assert found.average.std() == pytest.approx(float(np.sqrt((found.deviation**2).mean())), rel=0.1)
    assert found.average.std() < 1.0 / np.sqrt(found.turns)


def test_orders_give_amplitude_and_phase():
    found = synchronous_average(gear(ANGLE), phase_turns=ANGLE, highest_order=4 * TEETH)
    orders = found.orders()[0]
    assert abs(orders[TEETH] - np.exp(2j * np.pi * 0.1)) < 1e-3
    assert abs(orders[2 * TEETH] - 0.3 * np.exp(2j * np.pi * 0.4)) < 1e-3


def test_residual_and_difference_take_off_what_they_say():
    sidebands = np.cos(2 * np.pi * (TEETH + 1) * TURN) + np.cos(2 * np.pi * (TEETH - 1) * TURN)
    far = np.cos(2 * np.pi * (TEETH + 4) * TURN)
    low = np.cos(2 * np.pi * TURN) + np.cos(4 * np.pi * TURN) + 5.0
    signal = gear(TURN) + sidebands + far + low
    assert residual_signal(signal, teeth=TEETH) == pytest.approx(sidebands + far, abs=1e-9)
    assert difference_signal(signal, teeth=TEETH) == pytest.approx(far, abs=1e-9)


def test_fm0_and_energy_ratio_in_closed_form():
    """Mesh 1 and a far sideband of 0.2: FM0 is peak to peak over 1, the energy ratio 0.2."""
    signal = np.cos(2 * np.pi * 20 * TURN) + 0.2 * np.cos(2 * np.pi * 25 * TURN)
    found = gear_indicators(signal, teeth=20)
    assert found.fm0 == pytest.approx(np.ptp(signal) / 1.0, rel=1e-6)
    assert found.energy_ratio == pytest.approx(0.2, rel=1e-6)
    assert found.fm4 == pytest.approx(1.5, rel=1e-6)  # kurtosis of a sine


def test_fm4_of_noise_is_three_and_of_one_bad_tooth_far_above():
    rng = np.random.default_rng(1)
    values = [gear_indicators(gear(TURN) + rng.normal(0, 0.1, 1000), teeth=TEETH).fm4 for _ in range(50)]
    # The mean of 50 kurtoses of about 1000 samples scatters by sqrt(24 / 1000 / 50) = 0.022.
    assert np.mean(values) == pytest.approx(3.0, abs=0.08)
    # A tooth is a 23rd of a turn: kurtosis of a rectangle of that width with Gaussian inside would be 3 x 23.
    burst = 2.0 * np.exp(-(((TURN - 0.5) * TEETH) ** 2)) * np.cos(2 * np.pi * 3.4 * TEETH * TURN)
    assert gear_indicators(gear(TURN) + burst + rng.normal(0, 0.1, 1000), teeth=TEETH).fm4 > 10


def test_na4_rises_when_the_residual_grows_and_kurtosis_does_not():
    rng = np.random.default_rng(2)
    noise = rng.normal(0, 0.1, 1000)
    healthy = residual_signal(gear(TURN) + noise, teeth=TEETH).var()
    grown = gear(TURN) + 2.0 * noise
    assert gear_indicators(grown, teeth=TEETH).na4 == pytest.approx(3.0, abs=0.7)
    own = gear_indicators(gear(TURN) + noise, teeth=TEETH, healthy_variance=healthy).na4
    assert gear_indicators(grown, teeth=TEETH, healthy_variance=healthy).na4 == pytest.approx(16 * own, rel=1e-6)


@given(gain=st.floats(1e-6, 1e6), shift=st.integers(0, 999))
@settings(max_examples=20, deadline=None)
def test_indicators_ignore_gain_and_where_the_turn_begins(gain, shift):
    signal = gear(TURN) + np.random.default_rng(3).normal(0, 0.1, 1000)
    plain, other = gear_indicators(signal, teeth=TEETH), gear_indicators(gain * np.roll(signal, shift), teeth=TEETH)
    for name in ("fm0", "fm4", "na4", "energy_ratio"):
        assert getattr(other, name) == pytest.approx(getattr(plain, name), rel=1e-6)


@pytest.mark.parametrize("teeth", [2, 600])
def test_teeth_that_the_turn_cannot_hold_are_refused(teeth):
    with pytest.raises(InvalidValueError, match="allowed: 3 to 500"):
        gear_indicators(TURN, teeth=teeth)
