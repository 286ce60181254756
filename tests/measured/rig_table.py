"""Compare the healthy Analog Devices bench with the simulated rig: python tests/measured/rig_table.py.

Nothing is fitted. The sensor's range is not documented: 20 mV/g (+-40 g) is taken, 80 mV/g (+-10 g) would make every
measured number a quarter of it (-12 dB). Which housing carries the sensor and which of its radial axes is horizontal is
not documented either; X is set beside x, Y beside y, Z beside axial, and both housings are shown.
"""

from __future__ import annotations

import sys
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
from rotorwise.datasets import read
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import ADI_SPEEDS, DATA, HERE, IMBALANCE, adi

VOLTS_PER_G = 0.020
STANDARD_GRAVITY = 9.80665
ORDERS = (1, 2, 3)
EDGES_HZ = (10.0, 200.0, 1000.0, 2000.0, 4000.0, 8000.0)
AXES = {"X": "x", "Y": "y", "Z": "axial"}
HOUSINGS = ("a", "b")


def line_amplitudes(signals: np.ndarray, rate_hz: float, shaft_hz: float) -> np.ndarray:
    """Return the peak amplitude at each order, shape (channels, orders), by a Hann-windowed Fourier sum."""
    window = np.hanning(signals.shape[1])
    time_s = np.arange(signals.shape[1]) / rate_hz
    waves = np.exp(-2j * np.pi * shaft_hz * np.outer(time_s, ORDERS))
    return 2 * np.abs((signals * window) @ waves) / window.sum()


def band_levels(signals: np.ndarray, rate_hz: float) -> np.ndarray:
    """Return the rms in each band, shape (channels, bands); the window keeps 1X out of the bands above."""
    window = np.hanning(signals.shape[1])
    power = np.abs(np.fft.rfft((signals - signals.mean(axis=1, keepdims=True)) * window, axis=1)) ** 2
    frequency = np.fft.rfftfreq(signals.shape[1], 1 / rate_hz)
    scale = 2 / (signals.shape[1] * np.sum(window**2))
    parts = [power[:, (frequency >= low) & (frequency < high)].sum(axis=1) for low, high in pairwise(EDGES_HZ)]
    return np.sqrt(scale * np.stack(parts, axis=1))


def shaft_frequency_hz(signals: np.ndarray, rate_hz: float, nominal_hz: float) -> float:
    """Return the frequency within 1 % of the nominal one at which 1X of all channels together is strongest."""
    tried = nominal_hz * np.linspace(0.99, 1.01, 81)
    power = [np.sum(line_amplitudes(signals, rate_hz, one)[:, 0] ** 2) for one in tried]
    return float(tried[int(np.argmax(power))])


def measured(speed: str, load: str = "BaLo") -> tuple[float, np.ndarray, np.ndarray]:
    """Return shaft frequency, lines (axes, orders) and bands (axes, bands) of a record, m/s2; healthy by default."""
    recording = read(DATA / adi(speed, load=load), sidecar=HERE / "adi_limerick.toml")
    signals = recording.signals / VOLTS_PER_G * STANDARD_GRAVITY
    signals = signals - signals.mean(axis=1, keepdims=True)
    shaft_hz = shaft_frequency_hz(signals, recording.rate_hz, float(speed) / 60)
    return (
        shaft_hz,
        line_amplitudes(signals, recording.rate_hz, shaft_hz),
        band_levels(signals, recording.rate_hz),
    )


def simulated(preset: str, shaft_hz: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Return lines and bands of each housing's axes, and the seconds of computing for a second of signal."""
    rig, rate_hz, duration_s = find_machine("test_rig").preset(preset), 20000.0, 2.0
    start = time.process_time()
    run = rig.simulate(speed_rpm=60 * shaft_hz, duration_s=duration_s, rate_hz=rate_hz)
    cost = (time.process_time() - start) / (duration_s + rig.definition.settle_s)
    chosen = np.stack([run.probe(f"housing_{house}_{axis}") for house in HOUSINGS for axis in AXES.values()])
    return line_amplitudes(chosen, rate_hz, shaft_hz), band_levels(chosen, rate_hz), cost


def text(values: np.ndarray) -> str:
    """Return numbers with two significant digits, separated by slashes."""
    return " / ".join("0" if value < 1e-4 else f"{value:.2g}" for value in values)


def decibels(simulation: np.ndarray, measurement: np.ndarray) -> str:
    """Return simulation over measurement in dB, separated by slashes."""
    ratio = np.where(simulation > 1e-4, simulation, np.nan) / measurement
    return " / ".join("none" if np.isnan(one) else f"{20 * np.log10(one):+.0f}" for one in ratio)


def main() -> None:
    """Print lines, bands, growth with speed and cost."""
    if not DATA.is_dir():
        sys.exit(f"{DATA} is not there: the measured recordings are needed to make the table.")
    presets = ("adi", "adi_hertz")
    lines, bands, growth = [], [], {}
    for speed in ADI_SPEEDS:
        shaft_hz, line, band = measured(speed)
        models = {preset: simulated(preset, shaft_hz) for preset in presets}
        growth[speed] = (line[:, 0], models["adi"][0][:, 0])
        for number, axis in enumerate(AXES):
            lines.append(f"| {speed} | {axis} | {text(line[number])} |")
            bands.append(f"| {speed} | {axis} | {text(band[number])} |")
            for preset in presets:
                for house in range(len(HOUSINGS)):
                    own = len(AXES) * house + number
                    for rows, values, truth in ((lines, models[preset][0], line), (bands, models[preset][1], band)):
                        rows[-1] += f" {text(values[own])} ({decibels(values[own], truth[number])}) |"
        for preset in presets:
            print(f"{speed} rpm, {preset}: {models[preset][2]:.2f} s of computing for a second of signal")
    heads = " | ".join(f"{preset}, housing {house} (dB)" for preset in presets for house in HOUSINGS)
    print("\nPeak amplitude of 1X / 2X / 3X, m/s2\n")
    print(f"| rpm | axis | measured at 20 mV/g | {heads} |\n|{'---|' * 7}", *lines, sep="\n")
    print(f"\nrms in the bands between {' / '.join(f'{edge:.0f}' for edge in EDGES_HZ)} Hz, m/s2\n")
    print(f"| rpm | axis | measured at 20 mV/g | {heads} |\n|{'---|' * 7}", *bands, sep="\n")
    doubling = np.log2(growth["2400"][0] / growth["1200"][0]), np.log2(growth["2400"][1] / growth["1200"][1])
    print("\nExponent of 1X from 1200 to 2400 rpm, X / Y / Z")
    print("measured:", text(doubling[0]), " adi housing a:", text(doubling[1][:3]), " b:", text(doubling[1][3:]))
    print_unbalance()


def print_unbalance() -> None:
    """Print 1X of the heaviest imbalance class beside an unbalance of the simulated disc that explains X best.

    One number is chosen here for each housing, the unbalance; the other eight follow.
    """
    rig = find_machine("test_rig").preset("adi").with_parameters(residual_unbalance_kg_m=0.0)
    rig = rig.with_effects(Unbalance(moment_kg_m=1e-3, angle_rad=0.0))
    lines = {speed: measured(speed, IMBALANCE[-1]) for speed in ADI_SPEEDS}
    truth = np.stack([line[:, 0] for _, line, _ in lines.values()])
    print(
        f"\n1X of the class {IMBALANCE[-1]}, X / Y / Z, m/s2\n\n| rpm | measured at 20 mV/g | housing a | housing b |"
    )
    print("|---|---|---|---|")
    models = []
    for shaft_hz, _, _ in lines.values():
        motion = harmonic_balance(rig, speed_rpm=60 * shaft_hz, harmonics=1)
        models.append([[abs(motion.amplitude(f"housing_{h}_{a}", 1.0)) for a in AXES.values()] for h in HOUSINGS])
    model = np.array(models)
    factors = np.exp(np.mean(np.log(truth[:, None, 0] / model[:, :, 0]), axis=0))
    for row, speed in enumerate(ADI_SPEEDS):
        cells = [model[row, house] * factors[house] for house in range(len(HOUSINGS))]
        shown = " | ".join(f"{text(cell)} ({decibels(cell, truth[row])})" for cell in cells)
        print(f"| {speed} | {text(truth[row])} | {shown} |")
    print("Unbalance of the disc that X asks for, g.mm:", ", ".join(f"{1e6 * 1e-3 * one:.0f}" for one in factors))


if __name__ == "__main__":
    main()
