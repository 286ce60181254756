"""Hum of the supply is no shaft: the one beside it is found, or the answer is unsure; a synchronous machine stays."""

import numpy as np
import pytest
from rotorwise.diagnose.signal.speed import speed_from_vibration
from rotorwise.diagnose.signal.speed_peaks import Peaks
from rotorwise.diagnose.signal.supply_lines import follows_supply, of_supply, without_supply

RATE_HZ, DURATION_S = 8192.0, 4.0


def record(lines: dict[float, float], *, seed: int = 0) -> np.ndarray:
    """Return lines of these frequencies and amplitudes, each at a random phase, in noise of 0.05."""
    generator = np.random.default_rng(seed)
    time = np.arange(int(RATE_HZ * DURATION_S)) / RATE_HZ
    signal = 0.05 * generator.normal(size=time.size)
    for frequency, size in lines.items():
        signal += size * np.cos(2 * np.pi * frequency * time + generator.uniform(0, 2 * np.pi))
    return signal[None]


def hum(supply_hz: float, size: float) -> dict[float, float]:
    return {supply_hz: size, 2 * supply_hz: 0.3 * size, 3 * supply_hz: 0.5 * size}


@pytest.mark.parametrize("supply_hz", [50.0, 60.0, 49.97])
@pytest.mark.parametrize("speed_hz", [15.67, 26.24, 39.0, 45.5])
@pytest.mark.parametrize("hinted", [False, True])
def test_the_shaft_is_found_beside_hum(speed_hz: float, supply_hz: float, hinted: bool) -> None:
    lines = {speed_hz: 0.5, 2 * speed_hz: 0.05, **hum(supply_hz, 1.0)}
    hint = speed_hz * 1.03 if hinted else None
    found = speed_from_vibration(record(lines), rate_hz=RATE_HZ, hint_hz=hint)
    assert found is not None
    assert found.speed_hz == pytest.approx(speed_hz, rel=2e-3)


@pytest.mark.parametrize("supply_hz", [50.0, 60.0])
def test_hum_alone_is_not_believed(supply_hz: float) -> None:
    found = speed_from_vibration(record(hum(supply_hz, 1.0)), rate_hz=RATE_HZ)
    assert found is None or found.confidence < 0.5


@pytest.mark.parametrize("supply_hz", [50.0, 60.0])
def test_a_synchronous_machine_is_found_by_its_own_lines_or_a_hint(supply_hz: float) -> None:
    four_poles = {supply_hz / 2 * order: 0.5 / order for order in range(1, 7)}
    found = speed_from_vibration(record(four_poles), rate_hz=RATE_HZ)
    assert found is not None
    assert found.speed_hz == pytest.approx(supply_hz / 2, rel=1e-3)
    assert found.confidence > 0.8
    two_poles = {supply_hz * order: 0.5 / order for order in range(1, 7)}
    found = speed_from_vibration(record(two_poles), rate_hz=RATE_HZ, hint_hz=supply_hz)
    assert found is not None
    assert found.speed_hz == pytest.approx(supply_hz, rel=1e-3)
    assert found.confidence > 0.8


def test_what_is_of_the_supply() -> None:
    assert of_supply(np.array([50.02, 120.0, 49.5, 25.0, 149.9])).tolist() == [True, True, False, False, True]
    assert [follows_supply(one) for one in (50.0, 30.0, 24.9, 15.0, 16.67)] == [True, True, False, True, True]
    lines = Peaks(np.array([26.2, 50.0, 180.1]), np.full(3, 0.01), np.full(3, 100.0), 1000.0)
    assert without_supply(lines).frequency_hz.tolist() == [26.2]


def test_a_hint_makes_no_speed_of_noise() -> None:
    generator = np.random.default_rng(3)
    for _ in range(40):
        noise = generator.normal(size=(2, 32768))
        found = speed_from_vibration(noise, rate_hz=RATE_HZ, hint_hz=float(generator.uniform(10, 60)))
        assert found is None or found.confidence <= 0.5


@pytest.mark.parametrize("seed", range(10))
def test_a_sound_machine_that_shows_little_but_1x_is_believed_near_a_hint(seed: int) -> None:
    speed_hz = float(np.random.default_rng(seed).uniform(12, 45))
    found = speed_from_vibration(record({speed_hz: 0.5}, seed=seed), rate_hz=RATE_HZ, hint_hz=1.02 * speed_hz)
    assert found is not None
    assert found.speed_hz == pytest.approx(speed_hz, rel=1e-3)
    assert found.confidence > 0.5
