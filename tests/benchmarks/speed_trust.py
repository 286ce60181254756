"""How often the speed tracked in the vibration is wrong, and how sure it then says to be.

Run: python tests/benchmarks/speed_trust.py tune|judge [NUMBER]. The two draw from different seeds, order ratios and
tooth numbers; rules were made while looking at "tune" only.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

import numpy as np
from rotorwise.diagnose.signal.speed_track import track_speed
from scipy.signal import lfilter

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
    return base * (
        np.ones(part.size),
        growth**-0.5 + (growth**0.5 - growth**-0.5) * part,
        growth**0.5 - (growth**0.5 - growth**-0.5) * part,
        1 + rng.uniform(0.02, 0.1) * np.sin(2 * np.pi * rng.uniform(0.1, 0.4) * time_s),
    )[rng.integers(4)]


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


def main() -> None:
    """Print a row for every machine and range."""
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
            row = [count for kind in (right, ~right) for count in (kind.sum(), *((kind & (sure >= p)).sum() for p in (0.5, 0.8)))]
            sums += row
            print(f"| {machine} | {span} | {row[0]} | {row[1]}, {row[2]} | {row[3]} | {row[4]}, {row[5]} |")
    print(f"| all | | {sums[0]} | {sums[1]}, {sums[2]} | {sums[3]} | {sums[4]}, {sums[5]} |")
    print(f"CPU {time.process_time() - begun:.0f} s")


if __name__ == "__main__":
    main()
