"""Wavelet denoising: identities, gain in signal to noise, and the band of the approximation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.signal.denoise import RULES, wavelet_denoise, wavelet_low_pass
from rotorwise.simulators.errors import InvalidValueError

SAMPLES = 8192
TIME = np.arange(SAMPLES) / SAMPLES


def decibels(power_ratio: float) -> float:
    return 10 * np.log10(power_ratio)


def impacts(samples: int = SAMPLES) -> np.ndarray:
    """Decaying bursts, sparse in time: what a damaged bearing gives."""
    signal = np.zeros(samples)
    ring = np.exp(-np.arange(200) / 40) * np.sin(2 * np.pi * 0.11 * np.arange(200))
    for start in range(100, samples - 200, 700):
        signal[start : start + 200] += ring
    return signal


# --- identities -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("samples", [1000, 1001, 1024])
def test_a_signal_without_details_comes_back_exactly(rule, samples):
    """Eight vanishing moments: db8 has no details on polynomials of degree 7 or less, apart from the ends."""
    line = 3 - 2 * np.linspace(0, 1, samples) ** 3
    got = wavelet_denoise(line, rule=rule, levels=2)
    assert got[100:-100] == pytest.approx(line[100:-100], abs=1e-9)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("soft", [True, False])
@pytest.mark.parametrize("samples", [4095, 4096])
def test_a_signal_that_is_nearly_all_zero_is_reconstructed_perfectly(rule, soft, samples):
    """The median of the details is 0 then, so that the threshold is 0 and nothing may be lost."""
    signal = np.zeros(samples)
    signal[[700, 2900]] = [5.0, -2.0]
    assert wavelet_denoise(signal, rule=rule, soft=soft, levels=4) == pytest.approx(signal, abs=1e-12)


@pytest.mark.parametrize("rule", RULES)
@given(gain=st.floats(1e-6, 1e6))
@settings(max_examples=10, deadline=None)
def test_denoising_scales_with_the_signal(rule, gain):
    signal = impacts(2048) + np.random.default_rng(0).normal(0, 0.1, 2048)
    plain = wavelet_denoise(signal, rule=rule)
    assert wavelet_denoise(gain * signal, rule=rule) == pytest.approx(gain * plain, rel=1e-6, abs=1e-6 * gain)


# --- gain -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("soft", [True, False])
@pytest.mark.parametrize(("kind", "least_gain"), [("low sine", 12.0), ("impacts", 4.0)])
def test_gain_in_signal_to_noise(rule, soft, kind, least_gain):
    """A sine that lies in the approximation of level 6 keeps 1/64 of white noise at best: 18 dB."""
    clean = np.sin(2 * np.pi * 12 * TIME) if kind == "low sine" else 3 * impacts()
    noise = np.random.default_rng(1).normal(0, 0.5, SAMPLES)
    rest = wavelet_denoise(clean + noise, rule=rule, soft=soft, levels=6) - clean
    assert decibels((noise**2).mean() / (rest**2).mean()) > least_gain


@pytest.mark.parametrize("soft", [True, False])
def test_the_universal_rule_leaves_nothing_of_pure_noise_but_the_approximation(soft):
    """The largest of n normal values exceeds sigma sqrt(2 ln n) in fewer than one case out of sqrt(pi ln n)."""
    noise = np.random.default_rng(2).normal(size=(20, SAMPLES))
    rest = wavelet_denoise(noise, rule="universal", soft=soft, levels=8)
    # The approximation of level 8 holds 1/256 of the power; hard thresholds let the few largest values through.
    assert 0.9 / 256 < (rest**2).mean() < (1.3 if soft else 3.0) / 256


@pytest.mark.parametrize("rule", RULES)
def test_coloured_noise_is_reduced_as_well(rule):
    """Thresholds are set level by level: noise eight times as strong at low frequency must not pass for a signal."""
    from scipy.signal import lfilter

    rng = np.random.default_rng(3)
    clean = 6 * impacts()
    noise = lfilter([1.0], [1.0, -0.8], rng.normal(0, 0.5, SAMPLES + 500))[500:]
    rest = wavelet_denoise(clean + noise, rule=rule) - clean
    assert decibels((noise**2).mean() / (rest**2).mean()) > 3.0
    # A threshold from the finest level alone would let nearly all of this noise pass.
    alone = wavelet_denoise(noise, rule="universal", levels=4) - wavelet_low_pass(noise, levels=4)
    assert (alone**2).mean() < 0.03 * (noise - wavelet_low_pass(noise, levels=4)).var()


@pytest.mark.parametrize(("rule", "soft"), [("universal", False), ("sure", True), ("bayes", True)])
def test_strong_impacts_keep_their_height(rule, soft):
    """The universal threshold, shrinking, takes an eighth of the height: hence the other default."""
    clean = 10 * impacts()
    noisy = clean + np.random.default_rng(4).normal(0, 0.1, SAMPLES)
    assert wavelet_denoise(noisy, rule=rule, soft=soft).max() == pytest.approx(clean.max(), rel=0.05)


# --- approximation --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("share_of_edge", [0.0, 0.1, 0.3, 0.5])
def test_the_fourth_approximation_keeps_what_lies_below_a_32nd_of_the_rate(share_of_edge):
    signal = np.cos(2 * np.pi * share_of_edge / 32 * np.arange(SAMPLES))
    inner = slice(1000, -1000)
    assert wavelet_low_pass(signal)[inner] == pytest.approx(signal[inner], abs=0.03)


@pytest.mark.parametrize("share_of_edge", [1.5, 2.3, 5.1, 11.3, 15.7])
def test_the_fourth_approximation_rejects_what_lies_above(share_of_edge):
    signal = np.cos(2 * np.pi * share_of_edge / 32 * np.arange(SAMPLES))
    assert np.abs(wavelet_low_pass(signal)[1000:-1000]).max() < 0.03


@pytest.mark.parametrize("levels", [1, 2, 3, 5])
def test_each_level_halves_the_band(levels):
    noise = np.random.default_rng(5).normal(size=1 << 16)
    power = np.abs(np.fft.rfft(wavelet_low_pass(noise, levels=levels))) ** 2
    # db8 is not sharp: 6 % of the power lies in the transition above the edge, and nothing beyond 1.5 times it.
    assert power[: int(power.size / 2**levels)].sum() / power.sum() > 0.93
    assert power[: int(1.5 * power.size / 2**levels)].sum() / power.sum() > 0.999
    # An orthonormal wavelet: the approximation holds one value of 2^levels.
    assert (wavelet_low_pass(noise, levels=levels) ** 2).mean() == pytest.approx(2.0**-levels, rel=0.05)


@given(order=st.permutations(range(3)))
@settings(max_examples=6, deadline=None)
def test_channels_do_not_mix(order):
    signals = np.random.default_rng(6).normal(size=(3, 600))
    for function in (wavelet_low_pass, wavelet_denoise):
        assert np.array_equal(function(signals[list(order)], levels=3), function(signals, levels=3)[list(order)])


# --- shapes and errors ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(500,), (501,), (2, 500), (2, 501), (2, 3, 333)])
def test_shapes_are_kept(shape):
    signal = np.random.default_rng(7).normal(size=shape)
    assert wavelet_denoise(signal).shape == shape
    assert wavelet_low_pass(signal).shape == shape


def test_unknown_rule_is_refused_with_the_rules():
    with pytest.raises(InvalidValueError, match=r"'magic'; allowed: universal, sure, bayes"):
        wavelet_denoise(np.zeros(100), rule="magic")


@pytest.mark.parametrize("function", [wavelet_denoise, wavelet_low_pass])
@pytest.mark.parametrize(("samples", "levels", "deepest"), [(100, 9, 2), (100, 0, 2), (14, 1, 0)])
def test_levels_that_do_not_fit_are_refused_with_the_deepest(function, samples, levels, deepest):
    with pytest.raises(InvalidValueError, match=rf"{levels} wavelet levels on {samples} .* allowed: 1 to {deepest}"):
        function(np.zeros(samples), levels=levels)


def test_a_record_too_short_for_one_level_is_refused():
    with pytest.raises(InvalidValueError, match="longer record"):
        wavelet_denoise(np.zeros(10))
