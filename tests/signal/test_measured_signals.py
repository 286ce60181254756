"""Speeds and envelope lines of the measured recordings, against what their cards state."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from rotorwise.datasets import Recording, read
from rotorwise.diagnose.signal.envelope import EnvelopeSpectrum, envelope_spectra, most_impulsive
from rotorwise.diagnose.signal.speed import speed_from_vibration
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing

DATA = Path(__file__).parents[2].parent / "shared" / "data"
SIDECARS = Path(__file__).parents[1] / "measured"

pytestmark = [
    pytest.mark.measured,
    pytest.mark.skipif(not DATA.is_dir(), reason=f"measured recordings are not at {DATA}"),
]

ADI = "01_adi_limerick_mfs/data/{}.Wfm.csv"
CWRU = "05_cwru_bearing/data/{}.mat"
MFPT = "06_mfpt_bearing/data/{}.mat"
GEAR0 = "03_gear0_gearbox_28ch/data/3027_217_Data_Chan{}.mat"

# file, sidecar, hint in Hz, bearing, lowest and highest speed in Hz that the card allows
SPEEDS = [
    *[
        (
            ADI.format(f"{rpm}_GoB_GS_{load}_WA_00lb"),
            "adi_limerick",
            rpm / 60,
            "ER-12K",
            rpm / 60 - 0.25,
            rpm / 60 + 0.25,
        )
        for rpm in (1200, 1800, 2400)
        for load in ("BaLo", "VLIL", "VHIL")
    ],
    (CWRU.format("12k_Drive_End_IR007_0_105"), "cwru", 30.0, "6205", 29.88, 29.97),
    (CWRU.format("12k_Drive_End_OR007@6_0_130"), "cwru", 30.0, "6205", 29.88, 29.97),
    (CWRU.format("normal_0_97"), "cwru", 30.0, "6205", 29.88, 29.97),
    (MFPT.format("InnerRaceFault_vload_1"), "mfpt", 25.0, "NICE", 24.6, 24.85),
    (MFPT.format("InnerRaceFault_vload_7"), "mfpt", 25.0, "NICE", 24.6, 24.85),
    (GEAR0.format(5), "gear0", 33.0, None, 33.31, 33.35),
]

# file, sidecar, channel, bearing, race, shaft speed in Hz as the card states it
ENVELOPES = [
    *[
        (MFPT.format(f"{race}RaceFault_vload_{load}"), "mfpt", 0, "NICE", race, 24.75)
        for race in ("Inner", "Outer")
        for load in (1, 7)
    ],
    (CWRU.format("12k_Drive_End_IR007_0_105"), "cwru", 0, "6205", "Inner", 1797 / 60),
    (CWRU.format("12k_Drive_End_OR007@6_0_130"), "cwru", 0, "6205", "Outer", 1796 / 60),
]


@cache
def recording(file: str, sidecar: str) -> Recording:
    return read(DATA / file, sidecar=SIDECARS / f"{sidecar}.toml")


def ball_pass_orders(bearing: str | None) -> tuple[float, ...]:
    if bearing is None:
        return ()
    orders = find_bearing(bearing).defect_orders()
    return (orders.outer_race, orders.inner_race)


@pytest.mark.parametrize(("file", "sidecar", "hint", "bearing", "low", "high"), SPEEDS, ids=[row[0] for row in SPEEDS])
def test_speed_lies_where_the_card_puts_it(file, sidecar, hint, bearing, low, high):
    data = recording(file, sidecar)
    known = (23.0,) if sidecar == "gear0" else ()
    found = speed_from_vibration(
        data.signals, rate_hz=data.rate_hz, hint_hz=hint, known_orders=known, bearing_orders=ball_pass_orders(bearing)
    )
    assert found is not None
    # The interval as stated may reach out of the card's range, never lie beside it.
    assert found.low_hz <= high
    assert found.high_hz >= low
    assert found.speed_hz == pytest.approx((low + high) / 2, abs=(high - low) / 2 + 0.02)
    assert found.confidence > 0.5


def strongest_line(envelope: EnvelopeSpectrum, lowest_hz: float) -> tuple[float, float]:
    spectrum = envelope.spectrum
    first = int(lowest_hz / spectrum.resolution_hz)
    peak = first + int(spectrum.power_ratio[0, first:].argmax())
    return float(spectrum.frequency_hz[peak]), float(spectrum.amplitude[0, peak] / spectrum.floor[0, peak])


@pytest.mark.parametrize(
    ("file", "sidecar", "channel", "bearing", "race", "speed"), ENVELOPES, ids=[row[0] for row in ENVELOPES]
)
def test_the_strongest_envelope_line_is_the_ball_pass_frequency(file, sidecar, channel, bearing, race, speed):
    data = recording(file, sidecar)
    outer, inner = ball_pass_orders(bearing)
    expected = speed * (inner if race == "Inner" else outer)
    high = 0.46 * data.rate_hz if sidecar == "cwru" else 20_000.0
    (found,) = envelope_spectra(
        data.signals[channel],
        rate_hz=data.rate_hz,
        bands=[(2000.0, high)],
        highest_line_hz=1.4 * expected,
        floor_width_hz=25.0,
    )
    # Shaft lines below 2.5X modulate inner-race impacts; they are not asked for here.
    frequency, signal_to_noise = strongest_line(found, 2.5 * speed)
    assert frequency == pytest.approx(expected, rel=0.015)
    assert signal_to_noise > 10


def test_a_healthy_bearing_has_no_ball_pass_line():
    data = recording(CWRU.format("normal_0_97"), "cwru")
    outer, inner = ball_pass_orders("6205")
    found = envelope_spectra(
        data.signals[:1], rate_hz=data.rate_hz, bands=[(2000.0, 5500.0)], highest_line_hz=250, floor_width_hz=25
    )
    spectrum = most_impulsive(found, 0).spectrum
    for order in (outer, inner):
        near = abs(spectrum.frequency_hz / (order * 1796 / 60) - 1) < 0.015
        ratio = float((spectrum.amplitude[0, near] / spectrum.floor[0, near]).max())
        assert ratio < 5
