"""Parameters in standard coordinates: where the prior of each is a unit normal, or flat on a circle for an angle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...simulators.parameter import LogNormal, Normal, Parameter, Uniform

#: Coordinate that stands for nothing at all of a positive quantity.
FAR = 12.0
#: Share of machines that are not of usual size, and how much wider a strength's prior is there: what unbalances a rotor
#: of a tonne is nothing to one of a kilogram.
OTHER_SIZE, WIDER = 0.1, 4.0


@dataclass(frozen=True)
class Coordinate:
    """One parameter with a prior.

    Attributes
    ----------
    parameter : Parameter
        Its prior is not None.
    effect : int, optional
        Number of the effect, among those that the machine is given with, whose parameter it is; None for one of the
        machine's own.
    """

    parameter: Parameter
    effect: int | None = None

    @cached_property
    def is_angle(self) -> bool:
        """Whether every direction is equally likely, so that the coordinate has no ends."""
        prior, period = self.parameter.prior, self.parameter.period
        if not isinstance(prior, Uniform) or self.parameter.unit != "rad":
            return False
        turns = (prior.high - prior.low) / period
        return turns > 0.5 and abs(turns - round(turns)) < 1e-6

    @property
    def precision(self) -> float:
        """Precision of the prior in the coordinate: 1, or 0 on a circle."""
        return 0.0 if self.is_angle else 1.0

    @property
    def least_precision(self) -> float:
        """The same, on a circle that of a flat prior over the period."""
        return 12 / self.parameter.period**2 if self.is_angle else 1.0

    @property
    def is_strength(self) -> bool:
        """Whether the parameter is a size that is 0 where the effect is absent."""
        return self.parameter.zero is not None and isinstance(self.parameter.prior, LogNormal)

    def log_density(self, coordinate: float) -> float:
        """Return the logarithm of the prior density at a coordinate, with the wide tails of a strength."""
        if self.is_angle:
            return -math.log(self.parameter.period)
        usual = -0.5 * coordinate**2 - 0.5 * math.log(2 * math.pi)
        if not self.is_strength:
            return usual
        wide = -0.5 * (coordinate / WIDER) ** 2 - 0.5 * math.log(2 * math.pi) - math.log(WIDER)
        return float(np.logaddexp(math.log(1 - OTHER_SIZE) + usual, math.log(OTHER_SIZE) + wide))

    def value(self, coordinate: float) -> float:
        """Return the parameter's value, kept within its bounds."""
        prior = self.parameter.prior
        if self.is_angle:
            raw = math.remainder(coordinate, self.parameter.period)
        elif isinstance(prior, LogNormal):
            raw = prior.median * prior.factor**coordinate
        elif isinstance(prior, Normal):
            raw = prior.mean + prior.deviation * coordinate
        else:
            assert isinstance(prior, Uniform)
            raw = prior.low + (prior.high - prior.low) * _normal_share(coordinate)
        low, high = self.parameter.bounds
        return min(max(raw, low), high)

    def coordinate(self, value: float) -> float:
        """Return the coordinate of a value; far outside the prior, 4 standard deviations."""
        prior = self.parameter.prior
        if self.is_angle:
            return math.remainder(value, self.parameter.period)
        if isinstance(prior, LogNormal):
            return max(math.log(max(value, 1e-300) / prior.median) / math.log(prior.factor), -FAR)
        if isinstance(prior, Normal):
            return (value - prior.mean) / prior.deviation
        assert isinstance(prior, Uniform)
        return _normal_quantile((value - prior.low) / (prior.high - prior.low))

    def at_share(self, share: float) -> float:
        """Return the coordinate below which a share of the prior lies; round a circle, that share of its period."""
        return self.parameter.period * share if self.is_angle else _normal_quantile(share)

    def quantiles(self, count: int) -> list[float]:
        """Return coordinates of equally likely parts of the prior, their middles; evenly round a circle."""
        return [self.at_share((k + (0.0 if self.is_angle else 0.5)) / count) for k in range(count)]


def coordinates_of(parameters: Sequence[Parameter]) -> tuple[Coordinate, ...]:
    """Return the coordinates of the parameters that have a prior; the others are given, not estimated."""
    return tuple(Coordinate(parameter) for parameter in parameters if parameter.prior is not None)


def values_at(coordinates: Sequence[Coordinate], position: np.ndarray) -> dict[str, float]:
    """Return the parameters' values by name at a position, shape (coordinates,)."""
    return {c.parameter.name: c.value(float(z)) for c, z in zip(coordinates, position, strict=True)}


def log_prior(coordinates: Sequence[Coordinate], position: np.ndarray) -> float:
    """Return the logarithm of the prior density at a position."""
    return sum(c.log_density(float(z)) for c, z in zip(coordinates, position, strict=True))


def _normal_share(coordinate: float) -> float:
    return 0.5 * math.erfc(-coordinate / math.sqrt(2))


def _normal_quantile(share: float) -> float:
    from scipy.special import ndtri

    return float(np.clip(ndtri(min(max(share, 0.0), 1.0)), -4.0, 4.0))
