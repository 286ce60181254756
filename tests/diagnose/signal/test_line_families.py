"""Sideband families found blindly, and cepstral spacings, on made and measured gears."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rotorwise.datasets import read
from rotorwise.diagnose.signal.blind_sidebands import find_families
from rotorwise.diagnose.signal.cepstrum import band_cepstrum, line_spacing
from rotorwise.diagnose.signal.spectrum import spectrum_with_floor
from rotorwise.simulators.errors import InvalidValueError

RATE = 10_000.0
TIME = np.arange(60_000) / RATE
PINION, WHEEL, TEETH = 33.34, 16.67, 23
SHAFTS = {"pinion": PINION, "wheel": WHEEL}
DATA = Path(__file__).parents[3].parent / "shared" / "data"


def gear(*, wheel: float, pinion: float, noise: float, seed: int = 0) -> np.ndarray:
    """Three mesh harmonics with the same amplitude modulation, and the pinion's first two orders."""
    modulation = 1 + wheel * np.cos(2 * np.pi * WHEEL * TIME) + pinion * np.cos(2 * np.pi * PINION * TIME + 1)
    mesh = sum(np.cos(2 * np.pi * TEETH * PINION * k * TIME) / k for k in (1, 2, 3))
    low = 0.5 * np.cos(2 * np.pi * PINION * TIME) + 0.3 * np.cos(4 * np.pi * PINION * TIME)
    return mesh * modulation + low + np.random.default_rng(seed).normal(0, noise, TIME.size)


def families(signal, **options):
    spectrum = spectrum_with_floor(signal, rate_hz=RATE, floor_width_hz=30)
    return find_families(spectrum, channel=0, narrowest_hz=4.0, widest_hz=80.0, **options)


@pytest.mark.parametrize(("wheel", "pinion", "name"), [(0.3, 0.0, "wheel"), (0.0, 0.3, "pinion")])
def test_carrier_spacing_index_and_shaft(wheel, pinion, name):
    found = families(gear(wheel=wheel, pinion=pinion, noise=0.3), modulators_hz=SHAFTS)
    carriers = sorted(one.family.carrier.frequency_hz for one in found)
    assert carriers == pytest.approx([TEETH * PINION * k for k in (1, 2, 3)], rel=1e-5)
    for one in found:
        assert one.shaft == name
        assert abs(one.spacing_hz - SHAFTS[name]) < 4 * one.deviation_hz
        assert one.family.modulation_index == pytest.approx(0.3, rel=0.15)
        pair = [side for side in one.family.sidebands if abs(side.number) == 1]
        assert all(side.power_ratio > 100 for side in pair)


def test_a_spacing_that_no_shaft_has_is_left_unnamed():
    found = families(gear(wheel=0.3, pinion=0.0, noise=0.3), modulators_hz={"cage": 11.2})
    assert found
    assert all(one.shaft is None and one.shaft_error is None for one in found)


def test_families_among_unrelated_lines_are_rare():
    """Forty records of 60 lines at random places, 0.01 false ones each wanted: 4 would come once in a thousand runs."""
    false = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        signal = rng.normal(size=TIME.size)
        for place in rng.uniform(20, 4000, 60):
            signal += rng.uniform(0.1, 0.5) * np.cos(2 * np.pi * place * TIME)
        false += bool(families(signal, modulators_hz=SHAFTS))
    assert false < 4


def test_noise_has_no_family():
    assert families(np.random.default_rng(3).normal(size=TIME.size)) == ()


@pytest.mark.parametrize("spacing", [WHEEL, PINION])
def test_cepstrum_gives_the_spacing(spacing):
    """cos^6 of half the angle: a bump once a turn, three sidebands on each side."""
    signal = gear(wheel=0.0, pinion=0.4, noise=0.05) * (1 + 2 * np.cos(np.pi * spacing * TIME) ** 6)
    cepstrum = band_cepstrum(signal, rate_hz=RATE, low_hz=300, high_hz=2800, narrowest_hz=5)
    found = line_spacing(cepstrum, narrowest_hz=5, widest_hz=80)
    assert found is not None
    assert abs(found.spacing_hz - spacing) < found.resolution_hz
    assert found.power_ratio > 15


def test_cepstrum_of_noise_is_flat():
    """Power over its floor is exponential with mean 1."""
    noise = np.random.default_rng(4).normal(size=TIME.size)
    ratio = band_cepstrum(noise, rate_hz=RATE, low_hz=300, high_hz=4000, narrowest_hz=5).power_ratio[30:]
    assert ratio.mean() == pytest.approx(1.0, rel=0.15)
    assert ratio.max() < 20


def test_a_band_too_narrow_for_the_cepstrum_is_refused():
    with pytest.raises(InvalidValueError, match="64 or more"):
        band_cepstrum(TIME, rate_hz=RATE, low_hz=100, high_hz=110, narrowest_hz=5)


@pytest.mark.measured
@pytest.mark.skipif(not DATA.is_dir(), reason=f"measured recordings are not at {DATA}")
@pytest.mark.parametrize("channel", [5, 11, 12, 14])
def test_measured_gear_rig(channel):
    """The card: pinion 33.33 Hz, 23 teeth; 46 teeth of the wheel inferred from sidebands at 16.67 Hz."""
    path = DATA / f"03_gear0_gearbox_28ch/data/3027_217_Data_Chan{channel}.mat"
    data = read(path, sidecar=Path(__file__).parents[2] / "measured" / "gear0.toml")
    spectrum = spectrum_with_floor(data.signals, rate_hz=data.rate_hz, floor_width_hz=33)
    shafts = {"pinion": 33.33, "wheel": 16.67}
    found = find_families(spectrum, channel=0, narrowest_hz=5, widest_hz=120, highest_hz=6000, modulators_hz=shafts)
    named = [one for one in found if one.shaft is not None]
    assert {one.shaft for one in named} == {"pinion", "wheel"}
    assert all(abs(one.shaft_error or 0.0) < 2e-3 for one in named)
    cepstrum = band_cepstrum(data.signals[0], rate_hz=data.rate_hz, low_hz=300, high_hz=6000, narrowest_hz=5)
    spacing = line_spacing(cepstrum, narrowest_hz=5, widest_hz=120)
    assert spacing is not None
    assert spacing.spacing_hz == pytest.approx(16.67, rel=1e-3)
