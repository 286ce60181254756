"""How much of the vibration at a place comes as impacts, where tooth meshes sound too.

Mesh lines that a sound bearing's changing stiffness modulates have its rhythm in their envelope as well. Impacts differ
in four ways. They stand by themselves, not beside the mesh; what they modulate is rung-up noise or bursts, not steady
tones; they are a part of all that moves at the place, its strong direction included; and a strike is so short that it
rings more than the faintest bands.

References: J. Antoni and R. B. Randall, "Differential diagnosis of gear and bearing faults", J. Vib. Acoust. 124 (2002)
165; J. Antoni, "The spectral kurtosis", Mech. Syst. Signal Process. 20 (2006) 282.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .heard_envelopes import mesh_lines, other_directions
from .observe import Observation
from .signal.envelope import EnvelopeSpectrum

#: The stiffness of few balls is no sine: its multiples count as well.
_BESIDE_MESH = np.array([-6, -5, -4, -3, -2, -1, 1, 2, 3, 4, 5, 6])
_FAINT = 0.03  # of the loudest band, 30 dB below it: what modulates less than that is no defect (a judgement)


def share_of_impacts(
    now: Observation, envelope: EnvelopeSpectrum, depth_of: Callable[[EnvelopeSpectrum], float]
) -> float:
    """Return the modulation depth in a band that impacts make, over all directions at the place of an envelope.

    Parameters
    ----------
    now : Observation
    envelope : EnvelopeSpectrum
        Where a rhythm was found.
    depth_of : callable
        Modulation depth of the rhythm in an envelope, 0 where it is not seen.
    """
    place = [envelope, *other_directions(now, envelope)]
    band = [one for one in place if (one.low_hz, one.high_hz) == (envelope.low_hz, envelope.high_hz)]
    energy = np.array([one.mean**2 for one in band])
    depth = float(np.sqrt((energy * np.square([depth_of(one) for one in band])).sum() / max(energy.sum(), 1e-300)))
    if depth <= 0.0:
        return 0.0
    kurtosis = float((energy * [one.kurtosis for one in band]).sum() / max(energy.sum(), 1e-300))
    # Strikes that overlap have random phases, since the elements slip: they are modulated noise at least.
    bursts = kurtosis / modulated_noise_kurtosis(depth)
    return depth * float(np.clip(bursts, 0.0, 1.0)) * min(1.0, _loudness(now, band) / _FAINT)


def modulated_noise_kurtosis(depth: float) -> float:
    """Return the spectral kurtosis of Gaussian noise whose amplitude goes as 1 + depth cos.

    A steady tone modulated as deep has half of it less one: below zero even at a depth of 1.

    Examples
    --------
    >>> modulated_noise_kurtosis(0.0)
    0.0
    >>> round(modulated_noise_kurtosis(0.5), 2)
    0.8
    """
    square, fourth = 1.0 + depth**2 / 2.0, 1.0 + 3.0 * depth**2 + 0.375 * depth**4
    return 2.0 * fourth / square**2 - 2.0


def modulated_mesh(now: Observation, envelope: EnvelopeSpectrum, frequency_hz: float) -> float:
    """Return the share, 0 to 1, of a band's power that lies beside tooth-mesh lines at the distance of a rhythm.

    Lines at k mesh +- m rhythm, m up to 6, over all that is in the band except the mesh lines themselves; what such
    narrow windows would hold of evenly spread power is taken off.
    """
    carriers = mesh_lines(now, envelope)
    if not carriers.size:
        return 0.0
    spectrum = now.spectrum
    inside = (spectrum.frequency_hz >= envelope.low_hz) & (spectrum.frequency_hz <= envelope.high_hz)
    frequency, power = spectrum.frequency_hz[inside], spectrum.amplitude[envelope.channel, inside] ** 2
    width = 2.0 * spectrum.resolution_hz

    def near(places: np.ndarray) -> np.ndarray:
        at = np.sort(places)
        index = np.clip(np.searchsorted(at, frequency), 1, at.size - 1) if at.size > 1 else np.ones(frequency.size, int)
        padded = at if at.size > 1 else np.repeat(at, 2)
        return np.minimum(abs(frequency - padded[index - 1]), abs(frequency - padded[index])) <= width

    mesh = near(carriers)
    sides = near((carriers[:, None] + _BESIDE_MESH * frequency_hz).ravel()) & ~mesh
    total, even = float(power[~mesh].sum()), float(sides.sum()) / max(int((~mesh).sum()), 1)
    if total <= 0 or even >= 0.5:
        return 0.0  # lines so dense that they cover the band tell nothing
    return max(float(power[sides].sum()) / total - even, 0.0) / (1.0 - even)


def _loudness(now: Observation, band: list[EnvelopeSpectrum]) -> float:
    """Return the level of a band over that of the loudest band of the same channels."""
    channels = {one.channel for one in band}
    levels: dict[tuple[float, float], float] = {}
    for one in now.envelopes:
        if one.channel in channels:
            key = one.low_hz, one.high_hz
            levels[key] = levels.get(key, 0.0) + one.mean**2
    here = levels[band[0].low_hz, band[0].high_hz]
    return float(np.sqrt(here / max(*levels.values(), 1e-300)))
