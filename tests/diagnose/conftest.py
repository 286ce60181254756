"""Signals with a known truth for the tests of the diagnosis, and a browser for their pages."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, MountedBearing, Nameplate, OperatingCondition, Recording
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing
from rotorwise.simulators.synthetic_vibration import ImpactTrain, synthetic_vibration

SPEED_HZ = 24.6
RATE_HZ = 12_800.0
HEALTHY = {1: 0.3, 2: 0.12, 3: 0.06}


@dataclass(frozen=True)
class Machine:
    """What the synthetic machine does; every field has a quiet default."""

    lines: dict[float, float] = field(default_factory=lambda: dict(HEALTHY))
    impacts: tuple[ImpactTrain, ...] = ()
    noise_rms: float = 0.3
    seconds: float = 5.0
    speed_hz: float = SPEED_HZ
    rate_hz: float = RATE_HZ
    quantity: str | None = "acceleration"
    nameplate: Nameplate = field(
        default_factory=lambda: Nameplate(bearings=(MountedBearing(find_bearing("6205")),), line_frequency_hz=50.0)
    )
    hint_rpm: float | None = 1480.0
    seed: int = 0


Make = Callable[..., Recording]


@pytest.fixture
def make() -> Make:
    """Return a function that makes a two-channel recording of a machine."""

    def made(**changes: object) -> Recording:
        machine = Machine(**changes)  # pyright: ignore[reportArgumentType]
        signals = [
            synthetic_vibration(
                duration_s=machine.seconds,
                rate_hz=machine.rate_hz,
                speed_hz=machine.speed_hz,
                seed=10 * machine.seed + channel,
                shaft_lines={order: gain * value for order, value in machine.lines.items()},
                impacts=machine.impacts,
                noise_rms=machine.noise_rms,
            )
            for channel, gain in enumerate((1.0, 0.8))
        ]
        channels = tuple(Channel(name, machine.quantity, "drive end", name) for name in ("horizontal", "vertical"))
        return Recording(
            np.array(signals), machine.rate_hz, channels, OperatingCondition(machine.hint_rpm), machine.nameplate
        )

    return made


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not chromium or not driver:
        pytest.skip(f"no headless browser: chromium {chromium}, chromedriver {driver}")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    flags = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync")
    more = ("--disable-background-networking", "--disable-component-update", "--window-size=1280,900")
    for flag in (*flags, *more, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    running = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    yield running
    running.quit()
