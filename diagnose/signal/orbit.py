"""Shaft orbits: ellipse, whirl direction and full spectrum of two probes at right angles.

x + i y turns forward (from x towards y) at positive and backward at negative frequencies; a line of both is an ellipse
(C. W. Lee, "Vibration analysis of rotors" (1993); D. E. Bently and C. T. Hatch, "Fundamentals of rotating machinery
diagnostics" (2002), for the full spectrum).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy import fft

from ...simulators.errors import InvalidValueError
from .spectrum import fast_length, hann

_FLAT = 0.05  # minor over major axis: flatter is a straight line


@dataclass(frozen=True)
class Ellipse:
    """One line's orbit.

    Attributes
    ----------
    major, minor : float
        Half axes in the signals' unit; the minor one is negative where the orbit is run through backward.
    inclination_rad : float
        Of the major axis from x towards y, -pi/2 to pi/2.
    forward, backward : float
        Radii of the two circles that make the ellipse.
    """

    major: float
    minor: float
    inclination_rad: float
    forward: float
    backward: float

    @property
    def direction(self) -> float:
        """Whirl, -1 (a backward circle) through 0 (a straight line) to 1 (a forward circle): minor over major."""
        return self.minor / self.major if self.major > 0 else 0.0

    @property
    def words(self) -> str:
        """Which way it is run through."""
        return "forward" if self.direction > _FLAT else "backward" if self.direction < -_FLAT else "a straight line"


@dataclass(frozen=True, eq=False)
class FullSpectrum:
    """Amplitudes of x + i y over frequencies of both signs.

    Attributes
    ----------
    frequency_hz : numpy.ndarray, shape (bins,)
        0 and above.
    forward, backward : numpy.ndarray, shape (bins,)
        Radius of the circle at each frequency; a straight line of amplitude A has A / 2 in both.
    """

    frequency_hz: np.ndarray
    forward: np.ndarray
    backward: np.ndarray


def ellipse(x_amplitude: complex, y_amplitude: complex) -> Ellipse:
    """Return the orbit of one line from its complex amplitudes at two probes.

    Parameters
    ----------
    x_amplitude, y_amplitude : complex
        x(t) = Re X exp(i w t), y alike: as `order_amplitudes` gives them.

    Notes
    -----
    Forward radius |X + i Y| / 2, backward |X - i Y| / 2; axes are their sum and difference, the inclination half the
    sum of the two angles.

    Examples
    --------
    >>> found = ellipse(2.0, -1j)
    >>> found.major, found.minor, found.forward, found.backward
    (2.0, 1.0, 1.5, 0.5)
    """
    forward = 0.5 * (complex(x_amplitude) + 1j * complex(y_amplitude))
    backward = 0.5 * (complex(x_amplitude).conjugate() + 1j * complex(y_amplitude).conjugate())
    first, second = abs(forward), abs(backward)
    tilt = 0.5 * (np.angle(forward) + np.angle(backward)) if min(first, second) > 0 else 0.0
    tilt = (tilt + 0.5 * np.pi) % np.pi - 0.5 * np.pi
    return Ellipse(first + second, first - second, float(tilt), first, second)


def full_spectrum(x: np.ndarray, y: np.ndarray, *, rate_hz: float) -> FullSpectrum:
    """Return the full spectrum of two probes at right angles, Hann-windowed.

    Parameters
    ----------
    x, y : numpy.ndarray, shape (samples,)
        In one unit. Probes at 45 degrees to the vertical serve as well: x is the one from which the shaft turns
        towards the other, and forward then means with the rotation.
    rate_hz : float

    Examples
    --------
    >>> t = np.arange(1000) / 1000
    >>> found = full_spectrum(3 * np.cos(2 * np.pi * 50 * t), 3 * np.sin(2 * np.pi * 50 * t), rate_hz=1000)
    >>> round(float(found.forward[50]), 6), round(float(found.backward[50]), 6)
    (3.0, 0.0)
    """
    first, second = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if first.shape != second.shape or first.ndim != 1 or first.size < 16:
        raise InvalidValueError(
            f"Probes of shapes {first.shape} and {second.shape}; allowed: one channel each, equally long, 16 samples "
            "or more."
        )
    window = hann(first.size)
    length = fast_length(first.size)
    length += length % 2
    motion = (first - first.mean()) + 1j * (second - second.mean())
    amplitude = np.abs(fft.fft(motion * window, n=length)) / window.sum()
    half = length // 2
    backward = amplitude[np.r_[0, length - 1 : half - 1 : -1]]
    return FullSpectrum(np.arange(half + 1) * (rate_hz / length), amplitude[: half + 1], backward)


def filtered_orbit(x_amplitude: complex, y_amplitude: complex, *, points: int = 180) -> np.ndarray:
    """Return one turn of a line's orbit, shape (2, points): the ellipse, closed, as run through from angle zero."""
    turn = np.exp(2j * np.pi * np.linspace(0.0, 1.0, points))
    return np.stack([(x_amplitude * turn).real, (y_amplitude * turn).real])
