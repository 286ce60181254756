"""Edges that are known to a sample only: the angle lies between them, and what they leave open is told."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.observe import smooth_turns
from rotorwise.diagnose.gap.pulse_edges import are_steps

RATE_HZ, SAMPLES = 500.0, 2500
HOW = {"samples": SAMPLES, "rate_hz": RATE_HZ, "pulses_per_revolution": 1.0}


def _seen(speed_hz: float, shift_turns: float = 0.0, wander: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the true turns at every sample, and rising edges halfway between the samples where they were crossed."""
    turns = speed_hz * np.arange(SAMPLES) / RATE_HZ + shift_turns
    turns = turns + wander * np.sin(2 * np.pi * 1.3 * np.arange(SAMPLES) / RATE_HZ)
    return turns, np.flatnonzero(np.diff(np.floor(turns)) > 0) + 0.5


def _angle(speed_hz: float, shift_turns: float, **how: float) -> tuple[float, float]:
    """Return the mean error and the doubt of the angle, in samples."""
    turns, edges = _seen(speed_hz, shift_turns, **how)
    found = smooth_turns(edges / RATE_HZ, steps=True, **HOW)
    assert found is not None
    error = float(np.mean(found[0] - turns))
    return (error - round(error)) * RATE_HZ / speed_hz, found[1] * RATE_HZ / speed_hz


@pytest.mark.parametrize("shift", [0.1, 0.37, 0.81])
def test_edges_that_all_fall_alike_leave_a_whole_sample_open(shift):
    error, doubt = _angle(10.0, shift / 50)
    # 50 samples a turn: each pulse lies at the same part of a sample, and nothing says at which.
    assert doubt == pytest.approx(1 / np.sqrt(12), rel=1e-6)
    assert abs(error) <= 0.5


def test_edges_at_three_places_leave_a_third_open():
    # 33 1/3 samples a turn; the ends of the cubic take a part of the spread.
    error, doubt = _angle(15.0, 0.2 / 33.3)
    assert doubt == pytest.approx(1 / 3 / np.sqrt(12), rel=0.2)
    assert abs(error) <= 1 / 6 + 0.02


def test_errors_are_as_large_as_told():
    generator = np.random.default_rng(5)
    drawn = [_angle(float(speed), float(shift)) for speed, shift in generator.uniform((8, 0), (30, 1), (200, 2))]
    errors, doubts = np.array(drawn).T
    assert 0.5 < np.sqrt(np.mean(errors**2) / np.mean(doubts**2)) < 2


def test_an_edge_upon_a_sample_is_where_it_is_though_rounding_moves_it():
    # Every edge lies upon a sample; rounding puts it into the one before or behind, mostly into one of them.
    at = np.arange(1, 49)
    edges = 50.0 * at + np.where(at % 7 == 0, 0.5, -0.5)
    found = smooth_turns(edges / RATE_HZ, steps=True, **HOW)
    assert found is not None
    # The mean of the edges is off by 0.37 samples; what is left comes from the cubic's slope.
    np.testing.assert_allclose(found[0] + 1, np.arange(SAMPLES) / 50, atol=0.15 / 50)
    assert found[1] == pytest.approx(0.0, abs=1e-6)


def test_edges_further_apart_than_a_sample_are_not_forced_between_samples():
    _, edges = _seen(10.0, 0.3 / 50)
    scattered = (edges + np.where(np.arange(edges.size) % 3 == 0, 0.7, -0.7)) / RATE_HZ
    stepped, plain = smooth_turns(scattered, steps=True, **HOW), smooth_turns(scattered, steps=False, **HOW)
    assert stepped is not None
    assert plain is not None
    assert np.array_equal(stepped[0], plain[0])
    assert stepped[1] == plain[1] == 0


def test_steps_are_told_from_slow_edges():
    turns, edges = _seen(10.0, 0.3 / 50)
    pulses = (turns % 1 < 0.2).astype(float)
    assert are_steps(pulses, edges)
    slow = np.convolve(pulses, np.ones(4) / 4, mode="same")
    assert not are_steps(slow, edges)


def test_pulses_of_one_sample_are_steps():
    signal = np.zeros(20_000)
    signal[4000::4000] = 5.0
    assert are_steps(signal, np.flatnonzero(np.diff(signal) > 0) + 0.5)
