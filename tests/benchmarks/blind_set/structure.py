"""The machine's housings and foundation as a sum of vibration modes, driven at the bearings.

Six coordinates: horizontal, vertical, axial at the drive end, then the same at the other end. Acceleration over force
of mode m is -w^2 / (M (w_m^2 - w^2 + 2 i z w w_m)), the textbook modal sum (D. J. Ewins, Modal Testing, ch. 2).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import fft

Floats = NDArray[np.float64]
Spectra = NDArray[np.complexfloating]
COORDINATES = ("DE horizontal", "DE vertical", "DE axial", "NDE horizontal", "NDE vertical", "NDE axial")
LEAD_SECONDS = 1.0  # simulated before the record starts, so that the periodic transform's wrap-around is cut off


@dataclass(frozen=True, eq=False)
class Structure:
    """Modes: frequency in Hz, damping ratio, mass in kg; shapes [mode, coordinate]."""

    frequency_hz: Floats
    damping: Floats
    mass_kg: Floats
    shapes: Floats

    def with_resonance(self, mode: int, frequency_hz: float, damping: float) -> Structure:
        """Return the structure with one mode moved."""
        moved, damped = self.frequency_hz.copy(), self.damping.copy()
        moved[mode], damped[mode] = frequency_hz, damping
        return replace(self, frequency_hz=moved, damping=damped)


@dataclass(frozen=True)
class Clock:
    """Sampling: the record's rate, the oversampling of the forces, and the record's samples."""

    rate_hz: float
    factor: int
    samples: int

    @property
    def lead(self) -> int:
        return round(LEAD_SECONDS * self.rate_hz)

    @property
    def fine_rate_hz(self) -> float:
        return self.rate_hz * self.factor

    @property
    def fine_samples(self) -> int:
        return (self.samples + self.lead) * self.factor

    @property
    def fine_time_s(self) -> Floats:
        return np.arange(self.fine_samples, dtype=np.float64) / self.fine_rate_hz

    def frequencies_hz(self) -> Floats:
        return np.asarray(np.fft.rfftfreq(self.samples + self.lead, 1 / self.rate_hz), dtype=np.float64)


def draw_structure(rng: np.random.Generator, speed_hz: float) -> Structure:
    """Six pedestal modes clear of the running speed, and fourteen of covers and housings up to 12 kHz."""
    flexible = rng.random() < 0.25
    factors = rng.uniform(1.35, 7.0, 6)
    if flexible:
        factors[:2] = rng.uniform(0.25, 0.7, 2)
    pairs = ((0, 3, 1), (0, 3, -1), (1, 4, 1), (1, 4, -1), (2, 5, 1), (2, 5, -1))
    base = np.zeros((6, 6))
    for row, (first, second, sign) in enumerate(pairs):
        base[row, first], base[row, second] = 1.0, sign * rng.uniform(0.5, 1.2)
    factors[4:] = np.maximum(factors[4:], 2.5)
    base += 0.08 * rng.standard_normal((6, 6))
    covers = np.geomspace(300.0, 12000.0, 14) * rng.uniform(0.85, 1.15, 14)
    return Structure(
        frequency_hz=np.concatenate([np.clip(factors * speed_hz, 6.0, 600.0), covers]),
        damping=np.concatenate([rng.uniform(0.02, 0.06, 6), rng.uniform(0.005, 0.03, 14)]),
        mass_kg=np.concatenate([rng.uniform(40, 300, 6), 100.0 * (300.0 / covers) ** 0.5]),
        shapes=np.vstack([base, rng.standard_normal((14, 6))]),
    )


def decimated_spectrum(force: Floats, clock: Clock) -> Spectra:
    """Spectrum of a finely sampled force, cut to the record's rate by a steep anti-alias filter."""
    # Single precision: its error, 120 dB down, is under every sensor's noise, and the transforms take most of the time.
    full = (
        np.asarray(fft.rfft(force.astype(np.float32), axis=-1))[..., : (clock.samples + clock.lead) // 2 + 1]
        / clock.factor
    )
    roll = 1.0 / (1.0 + (clock.frequencies_hz() / (0.43 * clock.rate_hz)) ** 40)
    return (full * roll).astype(np.complex64)


def acceleration_spectrum(structure: Structure, force: Floats, clock: Clock) -> Spectra:
    """Acceleration spectra [coordinate, bin] that forces [coordinate, fine sample] cause, in m/s2."""
    driven = np.flatnonzero(np.any(force != 0.0, axis=1))
    spectra = decimated_spectrum(force[driven], clock)
    shapes = structure.shapes.astype(np.float32)
    modal = modal_responses(structure, clock) * (shapes[:, driven] @ spectra)
    return shapes.T @ modal


@lru_cache(maxsize=1)
def modal_responses(structure: Structure, clock: Clock) -> Spectra:
    """Acceleration of each mode over its modal force, [mode, bin]; kept, since each source of a record needs it."""
    omega = 2 * np.pi * clock.frequencies_hz()
    own = 2 * np.pi * structure.frequency_hz[:, None]
    decay = 2j * structure.damping[:, None] * own
    response = -(omega**2) / (structure.mass_kg[:, None] * (own**2 - omega**2 + decay * omega))
    return response.astype(np.complex64)


def to_time(spectrum: Spectra, clock: Clock) -> Floats:
    """Time signals of the record, without the lead-in."""
    return np.asarray(fft.irfft(spectrum, clock.samples + clock.lead, axis=-1))[..., clock.lead :]


def velocity_spectrum(spectrum: Spectra, clock: Clock, low_hz: float = 3.0) -> Spectra:
    """Velocity from acceleration, with a second-order high-pass as in a velocity sensor."""
    frequency = clock.frequencies_hz()
    ratio = 1j * frequency / low_hz
    high_pass = ratio**2 / (1 + 1.4 * ratio + ratio**2)
    return spectrum * high_pass / (2j * np.pi * np.maximum(frequency, 1e-6))


def band_rms(spectrum: Spectra, clock: Clock, low_hz: float, high_hz: float) -> Floats:
    """Root mean square of each row between two frequencies (over the record with its lead-in)."""
    frequency = clock.frequencies_hz()
    chosen = spectrum[..., (frequency >= low_hz) & (frequency <= high_hz)]
    return np.sqrt(2 * np.sum(np.abs(chosen) ** 2, axis=-1)) / (clock.samples + clock.lead)


def housing_velocity(spectrum: Spectra, clock: Clock) -> Floats:
    """Broadband velocity, rms, 10-1000 Hz, of each coordinate in m/s."""
    return band_rms(velocity_spectrum(spectrum, clock, 0.5), clock, 10.0, 1000.0)


def true_velocity(spectrum: Spectra, clock: Clock) -> Floats:
    """Broadband velocity, rms, 10-1000 Hz, of the record proper: without the lead-in and its wrap-around."""
    frequency = clock.frequencies_hz()
    inside = (frequency >= 10.0) & (frequency <= 1000.0)
    velocity = spectrum * inside / (2j * np.pi * np.maximum(frequency, 1e-6))
    return np.std(to_time(velocity, clock), axis=-1)
