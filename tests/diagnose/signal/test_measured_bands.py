"""The chains kurtogram or prewhitening, squared envelope on measured bearing faults: lines where theory puts them."""

from __future__ import annotations

from pathlib import Path

import pytest
from rotorwise.datasets import read
from rotorwise.diagnose.signal.envelope import squared_envelope_spectrum
from rotorwise.diagnose.signal.kurtogram import fast_kurtogram
from rotorwise.diagnose.signal.whitening import prewhiten
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing

DATA = Path(__file__).parents[3].parent / "shared" / "data"
SIDECARS = Path(__file__).parents[2] / "measured"

pytestmark = [
    pytest.mark.measured,
    pytest.mark.skipif(not DATA.is_dir(), reason=f"measured recordings are not at {DATA}"),
]

# file, sidecar, bearing, race, shaft speed in Hz as the card states it
FAULTS = [
    *[
        (f"06_mfpt_bearing/data/{race}RaceFault_vload_{load}.mat", "mfpt", "NICE", race, 24.75)
        for race in ("Inner", "Outer")
        for load in (1, 7)
    ],
    ("05_cwru_bearing/data/12k_Drive_End_IR007_0_105.mat", "cwru", "6205", "Inner", 1797 / 60),
    ("05_cwru_bearing/data/12k_Drive_End_OR007@6_0_130.mat", "cwru", "6205", "Outer", 1796 / 60),
]


def strongest(signal, rate_hz: float, band: tuple[float, float], *, above_hz: float, below_hz: float):
    found = squared_envelope_spectrum(
        signal, rate_hz=rate_hz, low_hz=band[0], high_hz=band[1], highest_line_hz=below_hz, floor_width_hz=25.0
    )
    first = int(above_hz / found.resolution_hz)
    peak = first + int(found.power_ratio[0, first:].argmax())
    return float(found.frequency_hz[peak]), float(found.power_ratio[0, peak])


@pytest.mark.parametrize(("file", "sidecar", "bearing", "race", "speed"), FAULTS, ids=[row[0] for row in FAULTS])
@pytest.mark.parametrize("way", ["kurtogram", "prewhitened"])
def test_the_strongest_line_is_the_ball_pass_frequency(file, sidecar, bearing, race, speed, way):
    data = read(DATA / file, sidecar=SIDECARS / f"{sidecar}.toml")
    orders = find_bearing(bearing).defect_orders()
    expected = speed * (orders.inner_race if race == "Inner" else orders.outer_race)
    signal, rate = data.signals[0], data.rate_hz
    if way == "kurtogram":
        map_of_bands = fast_kurtogram(signal, rate_hz=rate, narrowest_hz=3 * expected)
        assert map_of_bands.is_significant
        band = float(map_of_bands.low_hz[map_of_bands.best]), float(map_of_bands.high_hz[map_of_bands.best])
    else:
        signal, band = prewhiten(signal), (0.01 * rate, 0.49 * rate)
    # Sidebands at the shaft speed may be higher than the ball-pass line of an inner race that passes the load zone.
    near = 0.8 * speed
    frequency, power_ratio = strongest(signal, rate, band, above_hz=expected - near, below_hz=expected + near)
    assert frequency == pytest.approx(expected, rel=0.015)
    assert power_ratio > 30
