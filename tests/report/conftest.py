"""Synthetic analyses that look like those of real machines: a pump with an outer-race defect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.result import (
    Analysis,
    Cursor,
    Curve,
    Finding,
    Line,
    Pictures,
    Severity,
    SpeedEstimate,
)

RATE = 25600.0
SHAFT = 29.532
BPFO = 3.585
CHANNELS = ("motor drive end, horizontal", "motor drive end, vertical", "pump drive end, axial")


class Maker:
    """Builds analyses; ``points`` is the length of each spectrum."""

    def __init__(self, *, points: int = 20000) -> None:
        self.points = points

    def spectrum(self, channel: str, *, seed: int, gain: float = 1.0) -> Curve:
        """Return a velocity spectrum in m/s with shaft and bearing lines above a sloping noise floor."""
        random = np.random.default_rng(seed)
        x = np.linspace(0, 0.39 * RATE, self.points)
        floor = 2e-6 * (1 + 30 / (1 + x / 40))
        y = floor * np.sqrt(random.exponential(size=x.size))
        for order, amplitude in ((1, 1.9e-3), (2, 6e-4), (3, 2.4e-4), (BPFO, 1.1e-4), (2 * BPFO, 7e-5)):
            y[np.argmin(np.abs(x - order * SHAFT))] += gain * amplitude
        return Curve("amplitude spectrum", x, y, "Hz", "m/s", channel, noise_floor=floor)

    def envelope(self, channel: str, *, seed: int) -> Curve:
        """Return an envelope spectrum in m/s2 with the outer-race frequency and its harmonics."""
        random = np.random.default_rng(seed)
        x = np.linspace(0, 1000, self.points // 4)
        floor = np.full(x.size, 0.01)
        y = floor * np.sqrt(random.exponential(size=x.size))
        for harmonic in range(1, 6):
            y[np.argmin(np.abs(x - harmonic * BPFO * SHAFT))] += 0.6 / harmonic
        return Curve("envelope", x, y, "Hz", "m/s2", channel, noise_floor=floor, note="Band 2400 to 4800 Hz.")

    def waveform(self, channel: str, *, seed: int) -> Curve:
        """Return a second of acceleration."""
        t = np.arange(int(RATE)) / RATE
        noise = np.random.default_rng(seed).normal(size=t.size)
        return Curve("waveform", t, 2 * np.sin(2 * np.pi * SHAFT * t) + noise, "s", "m/s2", channel)

    def pictures(self) -> Pictures:
        """Return curves for every channel, cursors, an order map and an orbit."""
        cursors = [Cursor("shaft orders", f"{n}X", n * SHAFT) for n in range(1, 11)]
        cursors += [Cursor("BPFO 6205", f"{n} x BPFO", n * BPFO * SHAFT) for n in range(1, 6)]
        cursors += [Cursor("BPFI 6205", f"{n} x BPFI", n * 5.415 * SHAFT) for n in range(1, 6)]
        cursors += [Cursor("mesh", "mesh", 23 * SHAFT)]
        cursors += [Cursor("mesh sidebands", f"mesh {n:+d}X", (23 + n) * SHAFT) for n in (-2, -1, 1, 2)]
        time, order = np.linspace(0, 10, 120), np.linspace(0, 20, 400)
        level = -80 + 8 * np.random.default_rng(5).random((400, 120))
        for line in (1, 2, 3, BPFO):
            level[np.argmin(np.abs(order - line))] += 45 / line + 10 * time / 10
        angle = np.linspace(0, 12 * np.pi, 1500)
        orbit = {"x": 42 * np.cos(angle), "y": 25 * np.sin(angle + 0.4), "unit": "um", "channels": ["x", "y"]}
        return Pictures(
            spectra=tuple(self.spectrum(name, seed=i, gain=1 / (i + 1)) for i, name in enumerate(CHANNELS)),
            envelopes=tuple(self.envelope(name, seed=10 + i) for i, name in enumerate(CHANNELS)),
            waveforms=tuple(self.waveform(name, seed=20 + i) for i, name in enumerate(CHANNELS)),
            baseline_spectra=(self.spectrum(CHANNELS[0], seed=30, gain=0.5),),
            cursors=tuple(cursors),
            order_map={
                "time_s": list(time),
                "order_or_hz": list(order),
                "level_db": level.tolist(),
                "axis": "order",
                "channel": CHANNELS[0],
            },
            orbit=orbit,
        )

    def findings(self) -> tuple[Finding, ...]:
        """Return an outer-race defect, certain, and an unbalance, possible."""
        race = tuple(
            Line(
                f"{n} x BPFO" if n > 1 else "1 x BPFO",
                CHANNELS[0],
                n * BPFO * SHAFT,
                n * BPFO,
                0.6 / n,
                0.01,
                "m/s2",
                "envelope",
                0.02,
                n * 3.5848,
            )
            for n in range(1, 5)
        )
        shaft = Line("1X", CHANNELS[0], SHAFT, 1.0, 1.9e-3, 3.6e-5, "m/s", "spectrum", 9.5e-4, 1.0)
        return (
            Finding(
                "bearing_outer_race",
                0.963,
                "Envelope lines at 1 to 4 times the outer-race frequency of the 6205, 35 dB above the noise.",
                race,
                "Listen at the drive-end bearing, take a grease sample, inspect the race at the next stop.",
            ),
            Finding(
                "unbalance",
                0.41,
                "The line at 1X carries 84 % of the radial vibration and has doubled since the baseline.",
                (shaft,),
                "Measure the phase at 1X on both bearings; clean the impeller.",
                ("bent_shaft", "misalignment"),
            ),
        )

    def severity(self) -> tuple[Severity, ...]:
        """Return one verified and one unverified table."""
        return (
            Severity(
                "ISO 20816-3",
                "group 2, rigid mounting",
                "B",
                2.13,
                "mm/s",
                "velocity, rms, 10-1000 Hz",
                (1.4, 2.8, 4.5),
                CHANNELS[0],
                "ISO 20816-3:2022, table A.2",
                "H",
                alarm=2.4,
                trip=5.6,
            ),
            Severity(
                "API 617",
                "shaft displacement",
                "B",
                18.0,
                "um",
                "displacement, peak-peak",
                (12.0, 25.0, 40.0),
                "x",
                "a vendor's slide",
                "L",
                verified=False,
            ),
        )

    def __call__(self, path: str = "/data/pump_house/P-101_2024-03-02.wav", **changes: object) -> Analysis:
        """Return an analysis with everything in it, except what ``changes`` replaces."""
        whole = Analysis(
            path=path,
            verdict="Outer race of the drive-end bearing 6205 is damaged (96 %); vibration is in zone B.",
            findings=self.findings(),
            severity=self.severity(),
            severity_refusal="",
            speed=SpeedEstimate(SHAFT, SHAFT - 0.02, SHAFT + 0.02, 0.98, "vibration near the hint", 0.003),
            warnings=("Channel 'pump drive end, axial' clips in 0.4 % of its samples.",),
            channels=CHANNELS,
            rate_hz=RATE,
            duration_s=10.0,
            features={"velocity_rms": 2.13e-3, "order_1x": 1.9e-3, "kurtosis": 5.4, "crest": float("nan")},
            reader="wav",
            baseline_path="/data/pump_house/P-101_2023-11-20.wav",
            tests=184,
            pictures=self.pictures(),
        )
        return replace(whole, **changes)

    def folder(self, count: int) -> list[Analysis]:
        """Return analyses of one machine whose bearing gets worse."""
        pictures, made = self.pictures(), []
        race, unbalance = self.findings()
        for index in range(count):
            share = (index + 1) / count
            findings = (replace(race, probability=share**2), unbalance) if index else ()
            made.append(
                self(
                    f"/data/P-101_{index:03d}.wav",
                    findings=findings,
                    pictures=pictures,
                    features={"velocity_rms": 1e-3 + 2e-3 * share, "order_1x": 1e-3 * (1 + share)},
                )
            )
        return made

    def bare(self, **changes: object) -> Analysis:
        """Return an analysis in which everything that may be empty is empty."""
        empty = Analysis("a.csv", "Nothing evident.", (), (), "The unit is unknown.", None, (), (), 1000.0, 1.0)
        return replace(empty, **changes)


@pytest.fixture(scope="session")
def make() -> Maker:
    return Maker()
