"""Spacing of a gear's lines and whirl below the speed as features, on signals whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, GearPair, Nameplate, OperatingCondition, Recording
from rotorwise.diagnose.features import features
from rotorwise.diagnose.gear_spacing import gear_spacing
from rotorwise.diagnose.observe import observe

RATE = 12_800.0
TIME = np.arange(51_200) / RATE
PINION, TEETH, WHEEL_TEETH = 24.3, 23, 37


def gearbox(*, pulse_hz: float | None = None, eccentricity: float = 0.0, seed: int = 0) -> Recording:
    """Mesh lines in noise; with ``pulse_hz`` one tooth dips by a half, so often a second."""
    rng = np.random.default_rng(seed)
    mesh = sum(np.cos(2 * np.pi * TEETH * PINION * k * TIME + k) / k for k in (1, 2, 3, 4))
    shape = 1.0 + eccentricity * np.cos(2 * np.pi * PINION * TIME)
    if pulse_hz is not None:
        shape = shape - 0.5 * np.exp(-((((pulse_hz * TIME) % 1.0) - 0.5) ** 2) / 0.03**2)
    lines = mesh * shape + 0.5 * np.cos(2 * np.pi * PINION * TIME)
    signals = np.stack([lines + rng.normal(0, 0.05, TIME.size), 0.6 * lines + rng.normal(0, 0.05, TIME.size)])
    channels = (Channel("x", "acceleration"), Channel("y", "acceleration"))
    plate = Nameplate(gears=(GearPair(TEETH, WHEEL_TEETH),))
    return Recording(signals, RATE, channels, OperatingCondition(60 * PINION), plate)


@pytest.mark.parametrize(
    ("pulse_hz", "gear"), [(PINION, f"{TEETH}-tooth gear"), (PINION * TEETH / WHEEL_TEETH, f"{WHEEL_TEETH}-tooth gear")]
)
def test_a_damaged_tooth_spaces_the_lines_by_its_own_gear(pulse_hz, gear) -> None:
    now = observe(gearbox(pulse_hz=pulse_hz))
    found = gear_spacing(now)
    assert found is not None
    assert found.gear == gear
    assert found.spacing_hz == pytest.approx(pulse_hz, rel=5e-3)
    assert features(now)["gear_spacing_ratio"] == found.power_ratio > 16


@pytest.mark.parametrize("changes", [{}, {"eccentricity": 0.2}, {"seed": 4}])
def test_sound_and_eccentric_gears_do_not(changes) -> None:
    assert features(observe(gearbox(**changes)))["gear_spacing_ratio"] < 16


def test_without_gears_there_is_no_such_feature() -> None:
    made = gearbox(pulse_hz=PINION)
    plain = Recording(made.signals, RATE, made.channels, made.condition)
    assert np.isnan(features(observe(plain))["gear_spacing_ratio"])


def rotor(whirl: float, *, place: float = 0.46, size: float = 0.4) -> Recording:
    """Probes at right angles: 1X forward, and a line below it whose forward less backward share is ``whirl``."""
    rng = np.random.default_rng(5)
    speed, forward = 41.0, 0.5 * (1 + whirl)
    slow = 2 * np.pi * place * speed * TIME
    motion = np.exp(2j * np.pi * speed * TIME)
    motion = motion + size * (forward * np.exp(1j * slow) + (1 - forward) * np.exp(-1j * slow))
    signals = 1e-5 * np.stack([motion.real, motion.imag]) + rng.normal(0, 2e-7, (2, TIME.size))
    channels = (Channel("x", "displacement", "m", "x"), Channel("y", "displacement", "m", "y"))
    return Recording(signals, RATE, channels, OperatingCondition(60 * speed))


@pytest.mark.parametrize("whirl", [1.0, 0.5, 0.0, -0.7])
def test_whirl_below_the_speed(whirl) -> None:
    assert features(observe(rotor(whirl)))["sub_synchronous_whirl"] == pytest.approx(whirl, abs=0.02)


def test_no_whirl_without_a_line_below_or_without_probes() -> None:
    assert np.isnan(features(observe(rotor(1.0, size=0.0)))["sub_synchronous_whirl"])
    made = rotor(1.0)
    one = made.select([0])
    assert np.isnan(features(observe(one))["sub_synchronous_whirl"])
