"""How often the speed tracked in the vibration is wrong, and how sure it then says to be.

Run: python tests/benchmarks/speed_trust.py tune|judge [NUMBER], or measured. The first two draw from different seeds,
order ratios and numbers of teeth; limits were chosen on "tune".
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rotorwise.datasets.reading import read
from rotorwise.diagnose.signal.speed_track import track_speed
from scipy.signal import lfilter

HERE = Path(__file__).resolve()
DATA, SIDECARS = HERE.parents[3] / "shared" / "data", HERE.parents[1] / "measured"
RATE_HZ, DURATION_S = 10_000.0, 10.0
SETS = {
    "tune": {"seed": 0, "ratios": (3.585, 5.415, 2.357, 4.71), "teeth": (19, 23)},
    "judge": {"seed": 5000, "ratios": (2.6, 3.05, 4.95, 7.2, 10.4), "teeth": (13, 17, 31)},
}
MACHINES = ("shaft", "one line", "bearing, shaft weak", "bearing, shaft hidden", "gear", "noise")
RANGES = ("around", "all", "above", "below")


@dataclass(frozen=True, eq=False)
class Case:
    """A signal with its speed at every sample, and the speeds to look for in Hz."""

    signal: np.ndarray
    speed_hz: np.ndarray
    range_hz: tuple[float, float]


def speed_profile(rng: np.random.Generator) -> np.ndarray:
    """Return a constant, rising, falling or wandering speed, shape (samples,)."""
    time_s = np.arange(int(RATE_HZ * DURATION_S)) / RATE_HZ
    part = time_s / DURATION_S
    base = np.exp(rng.uniform(np.log(8.0), np.log(45.0)))
    growth = rng.uniform(1.3, 3.0)
    return (
        base
        * (
            np.ones(part.size),
            growth**-0.5 + (growth**0.5 - growth**-0.5) * part,
            growth**0.5 - (growth**0.5 - growth**-0.5) * part,
            1 + rng.uniform(0.02, 0.1) * np.sin(2 * np.pi * rng.uniform(0.1, 0.4) * time_s),
        )[rng.integers(4)]
    )


def rung(signal: np.ndarray, frequency_hz: float, damping: float) -> np.ndarray:
    """Return what a resonance makes of a signal, unit rms."""
    radius = np.exp(-2 * np.pi * damping * frequency_hz / RATE_HZ)
    angle = 2 * np.pi * frequency_hz / RATE_HZ
    out = lfilter([1.0], [1, -2 * radius * np.cos(angle), radius**2], signal)
    return out / out.std()


def shaft_lines(rng: np.random.Generator, angle: np.ndarray, orders: tuple[int, ...]) -> np.ndarray:
    """Return lines of random size and phase, unit rms."""
    lines = np.sum(
        [rng.uniform(0.2, 1) * np.cos(2 * np.pi * (order * angle + rng.uniform())) for order in orders], axis=0
    )
    return lines / lines.std()


def bearing_impacts(rng: np.random.Generator, angle: np.ndarray, ratio: float) -> np.ndarray:
    """Return impacts at a ball-pass order with slip, through a low and a high resonance, unit rms."""
    steps = 1 + 0.01 * rng.normal(size=int(ratio * angle[-1]) + 5)
    places = np.searchsorted(angle, (np.cumsum(steps) + rng.uniform()) / ratio)
    places = places[places < angle.size]
    load = 1 + rng.choice([0.0, 0.8]) * np.cos(2 * np.pi * angle[places])
    train = np.zeros(angle.size)
    train[places] = load
    low, high = rung(train, rng.uniform(80, 600), 0.1), rung(train, rng.uniform(2000, 4000), 0.03)
    out = low + rng.uniform(0.3, 2.0) * high
    return out / out.std()


def gear_mesh(rng: np.random.Generator, angle: np.ndarray, teeth: int) -> np.ndarray:
    """Return three harmonics of a mesh, modulated once a turn, unit rms."""
    turn = 1 + rng.uniform(0.05, 0.4) * np.cos(2 * np.pi * (angle + rng.uniform()))
    out = turn * shaft_lines(rng, teeth * angle, (1, 2, 3))
    return out / out.std()


def draw(machine: str, span: str, seed: int, ratios: tuple[float, ...], teeth: tuple[int, ...]) -> Case:
    """Return one case."""
    rng = np.random.default_rng([seed, MACHINES.index(machine), RANGES.index(span)])
    speed = speed_profile(rng)
    angle = np.cumsum(speed) / RATE_HZ
    signal = rng.uniform(0.2, 1.0) * rng.normal(size=angle.size)
    if machine == "shaft":
        lines = shaft_lines(rng, angle, (1, 2, 3, 4, 5, 6))
        both = lines + rng.uniform(0, 1) * rung(lines, rng.uniform(60, 300), 0.03)
        signal += both / both.std()
    elif machine == "one line":
        signal += shaft_lines(rng, angle, (1,))
    elif machine.startswith("bearing"):
        weak = rng.uniform(0.05, 0.3) if machine.endswith("weak") else 0.0
        signal += bearing_impacts(rng, angle, rng.choice(ratios)) + weak * shaft_lines(rng, angle, (1, 2))
    elif machine == "gear":
        signal += gear_mesh(rng, angle, int(rng.choice(teeth))) + rng.uniform(0, 0.3) * shaft_lines(rng, angle, (1, 2))
    low, high = float(speed.min()), float(speed.max())
    limits = {
        "around": (low / rng.uniform(1.2, 2.0), high * rng.uniform(1.1, 2.0)),
        "all": (4.0, 500.0),
        "above": (1.25 * high, rng.uniform(3, 6) * high),
        "below": (low / rng.uniform(3, 5), low / 1.25),
    }
    return Case(signal, speed, limits[span])


def judged(case: Case) -> tuple[float, float]:
    """Return the share of frames within 3 % and the median confidence."""
    found = track_speed(case.signal, rate_hz=RATE_HZ, lowest_hz=case.range_hz[0], highest_hz=case.range_hz[1])
    truth = np.interp(found.time_s * RATE_HZ, np.arange(case.speed_hz.size), case.speed_hz)
    return float((np.abs(found.speed_hz / truth - 1) < 0.03).mean()), float(np.median(found.confidence))


def measured_records() -> list[tuple[Path, str, float]]:
    """Return recordings of constant speed: path, sidecar, speed in Hz by their cards."""
    cards = {"05*/data/*": ("cwru", 1797 / 60), "06*/data/*": ("mfpt", 24.75), "03*/data/*.mat": ("gear0", 33.33)}
    found = [(path, *card) for place, card in cards.items() for path in sorted(DATA.glob(place))]
    adi = sorted(DATA.glob("01*/data/*.csv"))
    return found + [(path, "adi_limerick", int(path.name.split("_")[0]) / 60) for path in adi]


def measured() -> None:
    """Print a row for every measured record, and the sums over the ranges; right is within 4 % of the card."""
    sums = np.zeros((2, 3), dtype=int)
    for path, sidecar, speed_hz in measured_records():
        recording = read(path, sidecar=SIDECARS / f"{sidecar}.toml")
        rows = [index for index, channel in enumerate(recording.channels) if channel.is_vibration]
        signals = recording.signals[rows][:, : int(12 * recording.rate_hz)]
        signals = signals[:, np.isfinite(signals).all(axis=0)]
        words = []
        for low, high in ((0.5, 1.4), (4 / speed_hz, 500 / speed_hz), (1.25, 5.0), (0.25, 0.8)):
            limits = {"lowest_hz": low * speed_hz, "highest_hz": high * speed_hz}
            found = track_speed(signals, rate_hz=recording.rate_hz, **limits)
            sure = float(np.median(found.confidence))
            is_wrong = int((np.abs(found.speed_hz / speed_hz - 1) < 0.04).mean() <= 0.5)
            sums[is_wrong] += 1, sure >= 0.5, sure >= 0.8
            words.append(f"{np.median(found.speed_hz) / speed_hz:.2f}: {sure:.2f}")
        print(f"{path.name:40} {', '.join(words)}")
    print("right, of these 50, 80 % sure:", sums[0].tolist(), "wrong:", sums[1].tolist())


def main() -> None:
    """Print a row for every machine and range."""
    if sys.argv[1] == "measured":
        measured()
        return
    chosen = SETS[sys.argv[1]]
    number = int(sys.argv[2]) if len(sys.argv) > 2 else 30
    begun = time.process_time()
    print("| machine | range | right | of these sure: 50, 80 % | wrong | of these sure: 50, 80 % |")
    print("|---|---|---|---|---|---|")
    sums = np.zeros(6, dtype=int)
    for machine in MACHINES:
        for span in RANGES:
            cases = [chosen["seed"] + i for i in range(number)]
            found = [judged(draw(machine, span, seed, chosen["ratios"], chosen["teeth"])) for seed in cases]
            right = np.array([share > 0.5 for share, _ in found]) & (machine != "noise")
            sure = np.array([confidence for _, confidence in found])
            row = [
                count
                for kind in (right, ~right)
                for count in (kind.sum(), *((kind & (sure >= p)).sum() for p in (0.5, 0.8)))
            ]
            sums += row
            print(f"| {machine} | {span} | {row[0]} | {row[1]}, {row[2]} | {row[3]} | {row[4]}, {row[5]} |")
    print(f"| all | | {sums[0]} | {sums[1]}, {sums[2]} | {sums[3]} | {sums[4]}, {sums[5]} |")
    print(f"CPU {time.process_time() - begun:.0f} s")


if __name__ == "__main__":
    main()
