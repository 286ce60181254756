"""Sidebands of a carrier line at multiples of a modulator, with their signal-to-noise ratio."""

from __future__ import annotations

from dataclasses import dataclass

from .spectrum import Spectrum, peak_near


@dataclass(frozen=True)
class Sideband:
    """One sideband: its number (negative below the carrier), frequency, amplitude and noise floor."""

    number: int
    frequency_hz: float
    amplitude: float
    noise_floor: float

    @property
    def power_ratio(self) -> float:
        """Power over mean noise power."""
        return (self.amplitude / self.noise_floor) ** 2 if self.noise_floor > 0 else float("inf")


@dataclass(frozen=True)
class SidebandFamily:
    """A carrier with its sidebands.

    Attributes
    ----------
    carrier : Sideband
        Number 0.
    sidebands : tuple of Sideband
    modulation_index : float
        Sum of the amplitudes of the significant first pair over the carrier's: 2 J1(b)/J0(b), about b, for phase
        modulation, m for amplitude modulation by 1 + m cos.
    """

    carrier: Sideband
    sidebands: tuple[Sideband, ...]
    modulation_index: float


def find_sidebands(
    spectrum: Spectrum,
    *,
    channel: int,
    carrier_hz: float,
    modulator_hz: float,
    pairs: int = 3,
    significant_ratio: float = 16.0,
) -> SidebandFamily:
    """Return the sidebands of a carrier at multiples of a modulator.

    Parameters
    ----------
    spectrum : Spectrum
    channel : int
    carrier_hz, modulator_hz : float
        The carrier is looked for within two bins; each sideband within one bin of its place from the carrier found.
    pairs : int
        Sidebands on each side.
    significant_ratio : float
        Power ratio from which a sideband counts in the modulation index.

    Examples
    --------
    >>> import numpy as np
    >>> from rotorwise.diagnose.signal.spectrum import spectrum_with_floor
    >>> t = np.arange(20000) / 5000
    >>> x = (1 + 0.4 * np.cos(2 * np.pi * 25 * t)) * np.cos(2 * np.pi * 600 * t)
    >>> noise = np.random.default_rng(1).normal(0, 0.1, t.size)
    >>> found = find_sidebands(
    ...     spectrum_with_floor(x + noise, rate_hz=5000, floor_width_hz=30), channel=0, carrier_hz=600, modulator_hz=25
    ... )
    >>> round(found.modulation_index, 2)
    0.4
    """
    resolution = spectrum.resolution_hz
    carrier = Sideband(0, *peak_near(spectrum, channel, carrier_hz, tolerance_hz=2 * resolution))
    found = []
    for number in [*range(-pairs, 0), *range(1, pairs + 1)]:
        wanted = carrier.frequency_hz + number * modulator_hz
        if resolution < wanted < spectrum.frequency_hz[-2]:
            found.append(Sideband(number, *peak_near(spectrum, channel, wanted, tolerance_hz=resolution)))
    first = [side.amplitude for side in found if abs(side.number) == 1 and side.power_ratio > significant_ratio]
    # Over a carrier that is only noise the index would say nothing.
    index = sum(first) / carrier.amplitude if carrier.power_ratio > significant_ratio else 0.0
    return SidebandFamily(carrier, tuple(found), index)
