"""From true motion to a recording: sensor gain, mounting, noise, defects, converter and unit."""

from __future__ import annotations

import numpy as np
from machine import Machine
from rotorwise.datasets.recording import Channel
from scipy import fft
from structure import COORDINATES, Clock, Floats, to_time, velocity_spectrum

DEFECTS = ("clipping", "dropout", "loose_mounting", "drift")
KNOTS_HZ = np.array([10.0, 200.0, 1000.0, 4000.0, 20000.0])


def remount_curve_db(rng: np.random.Generator) -> Floats:
    """Gain change in dB at ``KNOTS_HZ`` of a sensor put back elsewhere: 3 dB at low frequency, up to 8 dB above."""
    return rng.choice([-1.0, 1.0]) * np.array([3.0, rng.uniform(3, 4), *rng.uniform(3, 8, 3)])


def coloured_noise(rng: np.random.Generator, samples: int, rate_hz: float, density: float, corner_hz: float) -> Floats:
    """Noise of a flat density (unit per root hertz) that rises as 1/f power below a corner."""
    spectrum = np.asarray(fft.rfft(rng.standard_normal(samples) * density * np.sqrt(rate_hz / 2)))
    frequency = np.maximum(np.fft.rfftfreq(samples, 1 / rate_hz), 0.2)
    return np.asarray(fft.irfft(spectrum * np.sqrt(1 + corner_hz / frequency), samples))


def housing_channels(
    spectra: np.ndarray,
    clock: Clock,
    machine: Machine,
    rng: np.random.Generator,
    *,
    change_db: np.ndarray | None,
    defect: str | None,
    unit_known: bool,
) -> tuple[Floats, tuple[Channel, ...]]:
    """Signals [channel, sample] in SI of housing sensors, and what the user knows about them."""
    frequency = clock.frequencies_hz()
    own = machine.details("sensors")
    density = float(np.exp(own.uniform(np.log(5e-5), np.log(4e-3))))
    hum = own.uniform(0.002, 0.04) * (own.random() < 0.25)
    broken = int(rng.integers(len(machine.coordinates))) if defect else -1
    signals, channels = [], []
    for number, (place, unit) in enumerate(zip(machine.coordinates, machine.units, strict=True)):
        gain = np.full(frequency.size, 1 + own.uniform(-0.03, 0.03))
        if change_db is not None:
            gain *= 10 ** (np.interp(np.log(np.maximum(frequency, 1)), np.log(KNOTS_HZ), change_db[number]) / 20)
        spectrum = spectra[place] * gain
        if number == broken and defect == "loose_mounting":
            spectrum = spectrum * _loose_mount(frequency, rng)
        if unit == "mm/s":
            signal = to_time(velocity_spectrum(spectrum, clock), clock)
            noise, pickup = density * 2e-3, hum * 2e-3
        else:
            signal, noise, pickup = to_time(spectrum, clock), density, hum
        signal = signal + coloured_noise(rng, clock.samples, clock.rate_hz, noise, 20.0)
        signal += pickup * _mains(machine.line_hz, clock, rng)
        if number == broken and defect:
            signal = _break(signal, defect, clock.rate_hz, rng)
        spare = rng.uniform(1.2, 10.0) if not (number == broken and defect == "clipping") else 1.0
        signals.append(_convert(signal, spare, int(own.choice([12, 16, 20, 20])), rng))
        quantity = "velocity" if unit == "mm/s" else "acceleration"
        location, direction = COORDINATES[place].split(" ")
        known = (quantity, unit) if unit_known else (None, None)
        channels.append(Channel(COORDINATES[place], known[0], location, direction, known[1]))
    return np.array(signals), tuple(channels)


def probe_channels(
    shaft: Floats, angle: Floats, clock: Clock, machine: Machine, rng: np.random.Generator, change_db: np.ndarray | None
) -> tuple[Floats, tuple[Channel, ...]]:
    """Proximity-probe signals in metres: shaft motion, run-out of the target, noise, gap."""
    own = machine.details("sensors")
    signals, channels = [], []
    gap = own.uniform(0.4e-3, 1.2e-3) * (own.random() < 0.3)
    for number, place in enumerate(machine.coordinates):
        size = own.uniform(0.5e-6, 4e-6)
        runout = sum(
            size / k * own.uniform(0.3, 1) * np.cos(k * angle + own.uniform(0, 2 * np.pi)) for k in range(1, 7)
        )
        signal = (shaft[number] + runout) * (1 + own.uniform(-0.03, 0.03))
        if change_db is not None:
            signal = signal * 10 ** (change_db[number, 0] / 20)
        signal = signal + coloured_noise(rng, signal.size, clock.rate_hz, own.uniform(2e-9, 1e-8), 5.0)
        signal += 0.3e-6 * own.random() * _mains(machine.line_hz, clock, rng) + gap
        signals.append(_convert(signal, rng.uniform(1.5, 6), 16, rng))
        location, _ = COORDINATES[place].split(" ")
        axis = "x" if place % 3 == 0 else "y"
        channels.append(Channel(f"{location} {axis}", "displacement", location, axis, "um"))
    return np.array(signals), tuple(channels)


def _mains(line_hz: float, clock: Clock, rng: np.random.Generator) -> Floats:
    turned = 2 * np.pi * line_hz * np.arange(clock.samples) / clock.rate_hz
    return np.cos(turned + rng.uniform(0, 6)) + 0.3 * np.cos(3 * turned + rng.uniform(0, 6))


def _loose_mount(frequency: Floats, rng: np.random.Generator) -> np.ndarray:
    own, damping = rng.uniform(150, 1200), rng.uniform(0.02, 0.1)
    ratio = frequency / own
    return (1 + 2j * damping * ratio) / (1 - ratio**2 + 2j * damping * ratio)


def _break(signal: Floats, defect: str, rate_hz: float, rng: np.random.Generator) -> Floats:
    peak = float(np.max(np.abs(signal)))
    if defect == "clipping":
        return np.clip(signal, -peak * rng.uniform(0.3, 0.8), peak * rng.uniform(0.3, 0.8))
    if defect == "dropout":
        out = signal.copy()
        for _ in range(int(rng.integers(1, 12))):
            start = int(rng.integers(signal.size))
            out[start : start + int(rng.uniform(0.005, 0.1) * rate_hz)] = 0.0
        return out
    if defect == "drift":
        time = np.arange(signal.size) / rate_hz
        ramp = rng.uniform(2, 10) * peak * (1 - np.exp(-time / (rng.uniform(0.2, 1.0) * time[-1])))
        return signal + ramp + coloured_noise(rng, signal.size, rate_hz, 0.02 * peak, 20.0) * 0.1
    # A sensor that hammers on its base: knocks on the strongest peaks.
    knocks = np.maximum(np.abs(signal) - 0.5 * peak, 0.0)
    return signal + rng.uniform(0.0, 1.0) * knocks * rng.standard_normal(signal.size)


def _convert(signal: Floats, spare: float, bits: int, rng: np.random.Generator) -> Floats:
    step = 2 * spare * max(float(np.max(np.abs(signal))), 1e-12) / 2**bits
    return np.round(signal / step + rng.uniform(-0.5, 0.5)) * step
