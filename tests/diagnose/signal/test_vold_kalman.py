"""Vold-Kalman orders against the filter's closed form, a dense solution, and run-ups of known amplitude."""

from __future__ import annotations

import numpy as np
import pytest
from rotorwise.diagnose.signal.vold_kalman import order_knots, order_waveforms
from rotorwise.simulators.errors import InvalidValueError

RATE = 10_000.0
TIME = np.arange(80_000) / RATE
SPEED = 10 + 5 * TIME
ANGLE = np.cumsum(SPEED) / RATE
INNER = slice(5_000, -5_000)


def decibels(ratio: np.ndarray) -> np.ndarray:
    return 20 * np.log10(np.abs(ratio))


@pytest.mark.parametrize("poles", [1, 2, 3])
@pytest.mark.parametrize("distance", [0.0, 0.25, 0.5, 1.0])
def test_a_lone_order_is_filtered_by_the_closed_form(poles, distance):
    angle = 100 * TIME
    signal = np.cos(2 * np.pi * (angle + distance * TIME))
    found = order_waveforms(signal, rate_hz=RATE, phase_turns=angle, orders=[1.0], bandwidth_hz=1.0, poles=poles)
    wanted = 1 / (1 + (np.sqrt(2) - 1) * (2 * distance) ** (2 * poles))
    assert np.abs(found.envelope[0, 0, 40_000]) == pytest.approx(wanted, abs=1e-3)


@pytest.mark.parametrize("poles", [1, 2])
def test_the_equations_against_a_dense_solution(poles):
    """With knots at every sample this is the textbook system; solved once more with a dense matrix."""
    count, rate, bandwidth = 120, 100.0, 12.0
    time = np.arange(count) / rate
    angle = 10 * time + 5 * time**2
    signal = np.random.default_rng(0).normal(size=count)
    found = order_waveforms(
        signal, rate_hz=rate, phase_turns=angle, orders=[1.0, 1.7], bandwidth_hz=bandwidth, poles=poles
    )
    difference = np.diff(np.eye(count), n=poles, axis=0)
    price = (np.sqrt(2) - 1) / (2 * np.sin(np.pi * bandwidth / 2 / rate)) ** (2 * poles)
    waves = [np.diag(np.exp(2j * np.pi * order * angle)) for order in (1.0, 1.7)]
    carriers = np.hstack(waves)
    matrix = carriers.conj().T @ carriers + np.kron(np.eye(2), price * difference.T @ difference)
    dense = np.linalg.solve(matrix, 2 * carriers.conj().T @ signal).reshape(2, count)
    assert found.envelope[0] == pytest.approx(dense, abs=1e-6)


def test_amplitude_of_orders_off_resonance_and_the_rest_after_removal():
    """Asked: 0.2 dB off resonance, what is removed 20 dB down. Noise of a tenth of the first order."""
    lines = ((1.0, 1.0), (2.0, 0.5), (3.5, 0.3))
    clean = np.sum([a * np.cos(2 * np.pi * (order * ANGLE + 0.1 * order)) for order, a in lines], axis=0)
    noise = np.random.default_rng(1).normal(0, 0.1, TIME.size)
    found = order_waveforms(
        clean + noise, rate_hz=RATE, phase_turns=ANGLE, orders=[o for o, _ in lines], bandwidth_hz=1.0
    )
    for row, (order, amplitude) in zip(found.envelope[0], lines, strict=True):
        assert np.abs(decibels(row[INNER] / amplitude)).max() < 0.2
        assert np.abs(np.angle(row[INNER] * np.exp(-2j * np.pi * 0.1 * order))).max() < 0.03
    left = found.residual[0] - noise
    assert decibels(left[INNER].std() / clean.std()) < -40


def resonance(frequency_hz: np.ndarray, *, at_hz: float, quality: float) -> np.ndarray:
    ratio = frequency_hz / at_hz
    return 1 / (1 - ratio**2 + 1j * ratio / quality)


def test_amplitude_near_and_off_a_resonance():
    """2X runs through a resonance of quality 15 at 60 Hz, 0.4 s for its width; asked: 1 dB near, 0.2 dB off."""
    response = resonance(2 * SPEED, at_hz=60.0, quality=15.0)
    signal = np.cos(2 * np.pi * ANGLE) + 0.3 * np.real(response * np.exp(4j * np.pi * ANGLE))
    noise = np.random.default_rng(2).normal(0, 0.05, TIME.size)
    found = order_waveforms(signal + noise, rate_hz=RATE, phase_turns=ANGLE, orders=[1.0, 2.0], bandwidth_hz=4.0)
    wrong = np.abs(decibels(found.envelope[0, 1] / (0.3 * response)))
    near = np.abs(2 * SPEED / 60 - 1) < 0.1
    inner = np.zeros(TIME.size, dtype=bool)
    inner[INNER] = True
    assert wrong[near].max() < 1.0
    # Above 1.6 times the resonance 2X fades towards the noise in the band.
    assert wrong[inner & ~near & (2 * SPEED < 96)].max() < 0.2


def test_orders_that_cross_a_fixed_line_are_kept_apart():
    """2X sweeps across 60 Hz, where a supply line of equal size stands; each keeps its amplitude."""
    line = 60 * TIME
    signal = np.cos(4 * np.pi * ANGLE) + np.cos(2 * np.pi * line + 0.5)
    phases = np.stack([ANGLE, line])
    found = order_waveforms(signal, rate_hz=RATE, phase_turns=phases, orders=[2.0, 1.0], bandwidth_hz=0.5)
    assert np.abs(decibels(found.envelope[0, :, INNER])).max() < 0.5
    alone = order_waveforms(signal, rate_hz=RATE, phase_turns=ANGLE, orders=[2.0], bandwidth_hz=0.5)
    assert np.abs(decibels(alone.envelope[0, 0, INNER])).max() > 1.0


def test_an_order_beyond_half_the_sampling_rate_is_absent_there():
    rate = 200.0
    time = np.arange(4000) / rate
    angle = 5 * time + 2.25 * time**2  # 5 to 95 Hz: 2X passes 100 Hz at 50 Hz
    found = order_waveforms(np.cos(2 * np.pi * angle), rate_hz=rate, phase_turns=angle, orders=[1, 2], bandwidth_hz=1)
    beyond = 2 * (5 + 4.5 * time) > 101
    assert (found.waveform[0, 1, beyond] == 0).all()
    assert np.abs(found.envelope[0, 0, 200:-200]) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("poles", [1, 2, 3])
@pytest.mark.parametrize("length", [400, 4000, 60_000])
def test_an_order_that_is_never_in_the_band_is_nothing(poles, length):
    angle = 30.0 * np.arange(length) / 200.0
    signal = np.cos(2 * np.pi * angle)
    options = {"rate_hz": 200.0, "phase_turns": angle, "bandwidth_hz": 1.0, "poles": poles}
    found = order_waveforms(signal, orders=[1.0, 5.0], **options)
    assert (found.waveform[0, 1] == 0).all()
    # At the ends the conjugate of a real signal's wave is not averaged out.
    inner = slice(length // 4, -length // 4)
    assert np.abs(found.envelope[0, 0, inner]) == pytest.approx(1.0, abs=0.02 if length < 1000 else 1e-3)


def test_channels_scale_and_linearity():
    signals = np.random.default_rng(3).normal(size=(2, 20_000))
    options = {"rate_hz": RATE, "phase_turns": ANGLE[:20_000], "orders": [1.0, 2.0], "bandwidth_hz": 3.0}
    both = order_waveforms(signals, **options)
    summed = order_waveforms(signals[0] + 10 * signals[1], **options)
    assert summed.envelope[0] == pytest.approx(both.envelope[0] + 10 * both.envelope[1], abs=1e-9)
    assert both.residual + both.waveform.sum(axis=1) == pytest.approx(signals, abs=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"orders": []}, "Orders"),
        ({"orders": [0.0]}, "Orders"),
        ({"orders": [1.0, 1.0]}, "same over this record"),
        ({"bandwidth_hz": 0.0}, "Bandwidth"),
        ({"bandwidth_hz": 5000.0}, "Bandwidth"),
        ({"poles": 0}, "poles"),
        ({"poles": 4}, "poles"),
        ({"phase_turns": ANGLE[:10]}, "Angle of shape"),
    ],
)
def test_wrong_options_are_refused(change, message):
    options = {"rate_hz": RATE, "phase_turns": ANGLE, "orders": [1.0], "bandwidth_hz": 1.0} | change
    with pytest.raises(InvalidValueError, match=message):
        order_waveforms(np.cos(ANGLE), **options)


@pytest.mark.parametrize("part", [(0, 3000), (1234, 1235), (7, 5000), (17_001, 20_000), (0, 20_000)])
def test_a_part_is_what_the_whole_has_there(part):
    """Parts are made from the knots: nothing of the mathematics changes, so they agree to rounding."""
    rate = 2000.0
    angle = np.cumsum(np.linspace(10, 40, 20_000)) / rate
    rng = np.random.default_rng(21)
    signals = np.stack([np.cos(2 * np.pi * angle), np.sin(2 * np.pi * 3 * angle)]) + rng.normal(0, 0.3, (2, angle.size))
    options = {"rate_hz": rate, "phase_turns": angle, "orders": [1.0, 3.0, 40.0], "bandwidth_hz": 1.7}
    whole = order_waveforms(signals, **options)
    knots = order_knots(signals, **options)
    envelope, wave = knots.part(*part)
    assert knots.distance > 1
    assert envelope == pytest.approx(whole.envelope[:, :, slice(*part)], abs=1e-12)
    assert wave == pytest.approx(whole.waveform[:, :, slice(*part)], abs=1e-12)
    at = np.arange(*part)[::7]
    assert knots.envelope_at(at) == pytest.approx(whole.envelope[:, :, at], abs=1e-12)
