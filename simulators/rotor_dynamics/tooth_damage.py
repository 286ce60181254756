"""What is wrong with single teeth or with all flanks of a gear pair, as polynomials for the gear mesh.

A damaged tooth changes the pair that it forms with its partner while the two are in contact, for the pair phase
s = 0 .. contact ratio since their first contact: its compliance by dc(s), its error by e(s). Pairs act in parallel, so
that the mesh stiffness changes by 1 / (c + dc) - 1 / c, c(s) being the sound pair's compliance. Tooth number n of the
pairs meets tooth n mod z1 of the pinion and n mod z2 of the wheel.

Wear of all flanks is an error that repeats with every tooth: flank depth w |s - s_p| / max|s - s_p|, in proportion to
the sliding distance (Archard), s_p at the pitch point; pairs in contact share the error by their stiffness.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from .gear_mesh_stiffness import OVERLAP, SpurPair

_FIT_ERROR = 1e-5
_DEGREES = range(3, 16)
_PITCH_SAMPLES = 2048
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(40)


@dataclass(frozen=True)
class ToothCrack:
    """A crack at the root of one tooth; see `SpurGear.crack_compliance_m_n`."""

    on_wheel: bool
    depth: float
    crack_angle_rad: float

    def compliance(self, pair: SpurPair) -> np.ndarray:
        """Return dc(s) in m/N as ascending powers of s."""
        gear = pair.wheel if self.on_wheel else pair.pinion

        def model(phase: np.ndarray) -> np.ndarray:
            roll = pair.roll_angles_rad(phase)[self.on_wheel]
            return gear.crack_compliance_m_n(roll, depth=self.depth, crack_angle_rad=self.crack_angle_rad)

        return fitted(model, pair.contact_ratio)

    def error(self, pair: SpurPair) -> np.ndarray:
        """Return e(s) in m: none, the unloaded tooth stands where it stood."""
        return np.zeros(1)


@dataclass(frozen=True)
class PittedTooth:
    """Pits that take a share of the face width away: dc = c_h share / (1 - share) (1 - q^2)^4, q = 2 s / ratio - 1.

    c_h is the compliance of the contact, the only part that pits touch here; they are deepest in the middle of the
    path of contact, near the pitch point.
    """

    share: float

    def compliance(self, pair: SpurPair) -> np.ndarray:
        """Return dc(s) in m/N as ascending powers of s."""
        return pair.contact_compliance_m_n * self.share / (1 - self.share) * _bump(pair.contact_ratio, 4)

    def error(self, pair: SpurPair) -> np.ndarray:
        """Return e(s) in m: none, sound flank beside the pits carries on."""
        return np.zeros(1)


@dataclass(frozen=True)
class ToothError:
    """A tooth that stands proud by ``height_m``, below 0 set back: e = -height (1 - q^2)^2, q = 2 s / ratio - 1."""

    height_m: float

    def compliance(self, pair: SpurPair) -> np.ndarray:
        """Return dc(s) in m/N: none."""
        return np.zeros(1)

    def error(self, pair: SpurPair) -> np.ndarray:
        """Return e(s) in m as ascending powers of s."""
        return -self.height_m * _bump(pair.contact_ratio, 2)


Damage = ToothCrack | PittedTooth | ToothError


@dataclass(frozen=True)
class DamagedTooth:
    """Damage of the pairs ``first``, ``first`` + ``every``, ``first`` + 2 ``every``, ..."""

    every: int
    first: int
    damage: Damage

    @property
    def key(self) -> tuple[int, int, str]:
        """An order that does not depend on which effect came first."""
        return self.every, self.first, repr(self.damage)


def fitted(model: Callable[[np.ndarray], np.ndarray], contact_ratio: float) -> np.ndarray:
    """Return ascending powers of the pair phase that follow ``model`` over one contact and 0.12 beyond its ends."""
    low, high = -OVERLAP, contact_ratio + OVERLAP
    check = np.linspace(low, high, 201)
    truth = model(check)
    powers = np.zeros(1)
    for degree in _DEGREES:
        powers = Chebyshev.interpolate(model, degree, [low, high])(Polynomial([0.0, 1.0])).coef
        if np.abs(np.polynomial.polynomial.polyval(check, powers) - truth).max() <= _FIT_ERROR * np.abs(truth).max():
            break
    return powers


def _bump(contact_ratio: float, power: int) -> np.ndarray:
    position = Polynomial([-1.0, 2 / contact_ratio])
    return ((1 - position**2) ** power).coef


@lru_cache(maxsize=64)
def pair_compliance(pair: SpurPair) -> np.ndarray:
    """Return the compliance c(s) of a sound pair in m/N as ascending powers of the pair phase."""
    return fitted(lambda phase: 1 / pair.pair_stiffness_n_m(phase), pair.contact_ratio)


@lru_cache(maxsize=256)
def damage_polynomials(pair: SpurPair, damage: Damage) -> tuple[np.ndarray, np.ndarray]:
    """Return dc(s) in m/N and e(s) in m of one damaged tooth, ascending powers of the pair phase."""
    return damage.compliance(pair), damage.error(pair)


def mean_stiffness_loss_n_m(pair: SpurPair, tooth: DamagedTooth) -> float:
    """Return what a damaged tooth takes from the mean mesh stiffness, in N/m."""
    phase = pair.contact_ratio / 2 * (_NODES + 1)
    sound = np.polynomial.polynomial.polyval(phase, pair_compliance(pair))
    added = np.polynomial.polynomial.polyval(phase, damage_polynomials(pair, tooth.damage)[0])
    return float(pair.contact_ratio / 2 * np.sum(_WEIGHTS * (1 / sound - 1 / (sound + added)))) / tooth.every


@lru_cache(maxsize=64)
def wear_harmonics_m(pair: SpurPair, *, wear_m: float, count: int) -> np.ndarray:
    """Return complex amplitudes of harmonics 1 to ``count`` of the mesh in the error that worn flanks make.

    The error is the real part of the sum of E_k exp(2 pi i k p), p the mesh phase in pitches.

    Parameters
    ----------
    pair : SpurPair
    wear_m : float
        Depth at the worst end of the path of contact, of both flanks together.
    count : int
    """
    phase = (np.arange(_PITCH_SAMPLES) + 0.5) / _PITCH_SAMPLES
    pitch_point = pair.pitch_point_phase
    reach = max(pitch_point, pair.contact_ratio - pitch_point)
    weight, total = np.zeros(phase.size), np.zeros(phase.size)
    for earlier in range(math.ceil(pair.contact_ratio)):
        own = phase + earlier
        stiffness = np.where(own < pair.contact_ratio, pair.pair_stiffness_n_m(np.minimum(own, pair.contact_ratio)), 0)
        weight += stiffness
        total += stiffness * wear_m * np.abs(own - pitch_point) / reach
    orders = np.arange(1, count + 1)
    return 2 * np.mean(total / weight * np.exp(-2j * np.pi * np.outer(orders, phase)), axis=1)
