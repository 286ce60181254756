"""Kurtogram, separation, prewhitening and squared envelope on impacts of known rhythm and resonance."""

from __future__ import annotations

import numpy as np
import pytest
from rotorwise.diagnose.signal.envelope import squared_envelope_spectrum
from rotorwise.diagnose.signal.kurtogram import fast_kurtogram
from rotorwise.diagnose.signal.whitening import prewhiten, separate
from rotorwise.simulators.errors import InvalidValueError

RATE = 20_000.0
TIME = np.arange(80_000) / RATE
REPEATED_HZ = 87.3


def impacts(*, resonance_hz: float, slip: float, seed: int) -> np.ndarray:
    """Decaying rings, one each 1 / 87.3 s with random slip; unit rms."""
    rng = np.random.default_rng(seed)
    gaps = (1 + slip * rng.normal(size=600)) / REPEATED_HZ
    starts = np.cumsum(gaps)
    starts = starts[starts < TIME[-1]]
    after = TIME - starts[np.maximum(np.searchsorted(starts, TIME, side="right") - 1, 0)]
    ring = np.where(after >= 0, np.exp(-1000 * np.abs(after)) * np.sin(2 * np.pi * resonance_hz * after), 0.0)
    return ring / ring.std()


def lines() -> np.ndarray:
    """Shaft and mesh: what repeats exactly."""
    return sum(np.cos(2 * np.pi * f * TIME + f) for f in (24.7, 49.4, 741.0, 1482.0))


# --- kurtogram ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("resonance", [2300.0, 4100.0, 6700.0, 8800.0])
def test_the_band_chosen_holds_the_resonance(resonance):
    noise = np.random.default_rng(0).normal(0, 1.0, TIME.size)
    signal = impacts(resonance_hz=resonance, slip=0.01, seed=1) + noise
    found = fast_kurtogram(signal, rate_hz=RATE, narrowest_hz=3 * REPEATED_HZ)
    assert found.is_significant
    assert found.low_hz[found.best] - 300 <= resonance <= found.high_hz[found.best] + 300


def test_gaussian_noise_has_no_kurtosis_in_any_band():
    """Mean 0, deviation 2 / sqrt(n), over the bands of ten records."""
    rng = np.random.default_rng(2)
    values = []
    for _ in range(10):
        found = fast_kurtogram(rng.normal(size=TIME.size), rate_hz=RATE)
        values.append(found.kurtosis / found.deviation)
        assert not found.is_significant
    # The cosine flanks leave a little fewer independent samples than counted; neighbouring levels are not independent.
    assert np.mean(values) == pytest.approx(0.0, abs=0.25)
    assert np.std(values) == pytest.approx(1.0, rel=0.15)


def test_a_sine_has_minus_one_and_its_gain_does_not_matter():
    sine = np.cos(2 * np.pi * 3000.25 * TIME)
    found = fast_kurtogram(1e-9 * sine, rate_hz=RATE, levels=0)
    assert found.kurtosis[0] == pytest.approx(-1.0, abs=0.01)


def test_bands_tile_the_spectrum_and_are_no_narrower_than_asked():
    found = fast_kurtogram(np.random.default_rng(3).normal(size=20_000), rate_hz=RATE, narrowest_hz=1000.0)
    assert np.round(2**found.level).astype(int).tolist() == [n for n in (1, 2, 3, 4, 6, 8) for _ in range(n)]
    assert (found.high_hz - found.low_hz).min() > 0.99 * 1000.0
    assert found.high_hz.max() == pytest.approx(0.5 * RATE, rel=1e-3)


def test_a_short_record_is_refused():
    with pytest.raises(InvalidValueError, match="256 samples or more"):
        fast_kurtogram(np.ones(200), rate_hz=RATE)


# --- deterministic and random parts ---------------------------------------------------------------------------


def test_lines_and_noise_are_separated():
    noise = np.random.default_rng(4).normal(0, 1.0, TIME.size)
    deterministic, random = separate(lines() + noise, segment_samples=2048)
    # Of the lines less than 1 % of the amplitude stays in the random part: 40 dB down, 20 asked.
    left = np.abs([np.mean(random * np.exp(-2j * np.pi * f * TIME)) * 2 for f in (24.7, 49.4, 741.0, 1482.0)])
    assert left.max() < 0.03
    assert np.std(deterministic - lines()) < 0.2
    assert deterministic + random == pytest.approx(lines() + noise, abs=1e-12)


def test_slipping_impacts_stay_in_the_random_part():
    signal = impacts(resonance_hz=4100.0, slip=0.02, seed=5)
    deterministic, random = separate(signal + 3 * lines(), segment_samples=2048)
    assert np.std(random - signal) < 0.3
    assert np.std(deterministic - 3 * lines()) < 0.3


def test_separation_lets_the_kurtogram_see_what_lines_hide():
    """A strong mesh in the resonance's own band hides the impacts until it is taken off."""
    mesh = 4 * np.cos(2 * np.pi * 4150 * TIME)
    noise = np.random.default_rng(6).normal(0, 0.5, TIME.size)
    signal = impacts(resonance_hz=4100.0, slip=0.01, seed=6) + mesh + noise
    _, random = separate(signal, segment_samples=4096)
    options = {"rate_hz": RATE, "narrowest_hz": 1000.0}
    with_mesh, without = (fast_kurtogram(one, **options) for one in (signal, random))

    def in_band(found) -> float:
        inside = (found.low_hz < 4100) & (found.high_hz > 4100) & (found.high_hz - found.low_hz < 1500)
        return float(found.kurtosis[inside].max())

    assert in_band(with_mesh) < 0
    assert in_band(without) > 1


@pytest.mark.parametrize("segment", [8, 40_000])
def test_segments_that_do_not_fit_are_refused(segment):
    with pytest.raises(InvalidValueError, match="allowed: 16 or more"):
        separate(TIME, segment_samples=segment)


# --- prewhitening and squared envelope ------------------------------------------------------------------------


def test_prewhitened_impacts_show_their_rhythm_under_strong_lines():
    noise = np.random.default_rng(7).normal(0, 0.3, TIME.size)
    signal = impacts(resonance_hz=4100.0, slip=0.005, seed=7) + 50 * lines() + noise
    white = prewhiten(signal)
    assert white.std() == pytest.approx(signal.std(), rel=1e-6)
    options = {"rate_hz": RATE, "low_hz": 100.0, "high_hz": 9900.0, "highest_line_hz": 400.0, "floor_width_hz": 40.0}

    def ratio(one: np.ndarray) -> float:
        found = squared_envelope_spectrum(one, **options)
        near = np.abs(found.frequency_hz - REPEATED_HZ) < 0.6
        return float(found.power_ratio[0, near].max())

    assert ratio(white) > 100
    assert ratio(white) > 10 * ratio(signal)


def test_prewhitening_nothing_gives_nothing():
    assert (prewhiten(np.full(100, 3.0)) == 0).all()


def test_squared_envelope_line_of_two_tones_in_closed_form():
    """|1 + b exp(i w t)|^2 = 1 + b^2 + 2 b cos: a line of 2 b / (1 + b^2) over the mean."""
    b = 0.4
    signal = np.cos(2 * np.pi * 4000 * TIME) + b * np.cos(2 * np.pi * 4050 * TIME)
    found = squared_envelope_spectrum(
        signal, rate_hz=RATE, low_hz=3500, high_hz=4500, highest_line_hz=200, floor_width_hz=40
    )
    near = np.abs(found.frequency_hz - 50) < 0.5
    assert found.amplitude[0, near].max() == pytest.approx(2 * b / (1 + b**2), rel=0.01)
    # No second harmonic: the modulus itself would have one of a tenth of that.
    assert found.amplitude[0, np.abs(found.frequency_hz - 100) < 0.5].max() < 1e-3
