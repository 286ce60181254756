"""Parameters of machines and effects: name, unit, default, bounds, prior, meaning and source."""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import InvalidValueError


@dataclass(frozen=True)
class Uniform:
    """Every value from ``low`` to ``high`` is equally likely."""

    low: float
    high: float

    @property
    def median(self) -> float:
        """Middle of the interval."""
        return (self.low + self.high) / 2

    def sample(self, generator: np.random.Generator) -> float:
        """Return one random value."""
        return float(generator.uniform(self.low, self.high))

    def log_density(self, value: float) -> float:
        """Return ln p(value)."""
        return -math.log(self.high - self.low) if self.low <= value <= self.high else -math.inf


@dataclass(frozen=True)
class Normal:
    """Gaussian with mean and standard deviation."""

    mean: float
    deviation: float

    @property
    def median(self) -> float:
        """The mean."""
        return self.mean

    def sample(self, generator: np.random.Generator) -> float:
        """Return one random value."""
        return float(generator.normal(self.mean, self.deviation))

    def log_density(self, value: float) -> float:
        """Return ln p(value)."""
        z = (value - self.mean) / self.deviation
        return -0.5 * z * z - math.log(self.deviation * math.sqrt(2 * math.pi))


@dataclass(frozen=True)
class LogNormal:
    """A positive value known within a factor: two thirds of the mass lie in median / factor to median x factor."""

    median: float
    factor: float

    def sample(self, generator: np.random.Generator) -> float:
        """Return one random value."""
        return float(self.median * self.factor ** generator.normal())

    def log_density(self, value: float) -> float:
        """Return ln p(value)."""
        if value <= 0:
            return -math.inf
        width = math.log(self.factor)
        z = math.log(value / self.median) / width
        return -0.5 * z * z - math.log(value * width * math.sqrt(2 * math.pi))


Prior = Uniform | Normal | LogNormal


@dataclass(frozen=True)
class Parameter:
    """One number that describes a machine or an effect.

    Parameters
    ----------
    name, unit, meaning, source : str
        ``unit`` is "" for a pure number. ``source`` says where default and prior come from.
    default : float
    bounds : tuple of float
        Smallest and largest allowed value, both included.
    prior : Uniform, Normal or LogNormal, optional
        What is known before a measurement. None for a value that is given, not estimated.
    zero : float, optional
        For a strength: the value at which the effect is absent.
    only_with : str
        Name of the strength without which this parameter does nothing; empty where there is none.
    period : float
        Of an angle: by how much it can be changed without changing anything. A full turn, or a part of it.
    chooses : bool
        Whether it only says which part is meant, the nearest bolt or tooth: it then has no slope.
    accompanies : bool
        Of a strength: whether it comes with others of the effect only. Alone it would be another effect.
    """

    name: str
    unit: str
    default: float
    bounds: tuple[float, float]
    meaning: str
    source: str
    prior: Prior | None = None
    zero: float | None = None
    only_with: str = ""
    period: float = 2 * math.pi
    chooses: bool = False
    accompanies: bool = False

    def __post_init__(self) -> None:
        for label, value in (("default", self.default), ("zero", self.zero)):
            if value is not None and not self.bounds[0] <= value <= self.bounds[1]:
                raise InvalidValueError(
                    f"Parameter {self.name}: {label} {value:g} is outside its bounds {self.bounds[0]:g} to "
                    f"{self.bounds[1]:g}. Correct the declaration."
                )

    def checked(self, value: object) -> float:
        """Return ``value`` as a float within the bounds, or raise InvalidValueError."""
        try:
            number = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            raise InvalidValueError(
                f"{self.name} = {value!r} is not a number; {self._allowed}. Give a number."
            ) from None
        if isinstance(value, bool) or not self.bounds[0] <= number <= self.bounds[1]:
            raise InvalidValueError(f"{self.name} = {value!r}; {self._allowed} ({self.meaning}). Correct the value.")
        return number

    @property
    def _allowed(self) -> str:
        return f"allowed: {self.bounds[0]:g} to {self.bounds[1]:g}{' ' + self.unit if self.unit else ''}"


def parameter(
    *,
    unit: str,
    bounds: tuple[float, float],
    meaning: str,
    source: str,
    default: float | None = None,
    prior: Prior | None = None,
    zero: float | None = None,
    only_with: str = "",
    period: float = 2 * math.pi,
    chooses: bool = False,
    accompanies: bool = False,
) -> Any:
    """Return a dataclass field that carries its `Parameter`; the default is the prior's median unless given."""
    if default is None:
        if prior is None:
            raise InvalidValueError("A parameter has neither a default nor a prior; give one of the two.")
        default = prior.median
    # The field's name is not known yet; `parameters_of` puts it in.
    declared = Parameter(
        "", unit, default, bounds, meaning, source, prior, zero, only_with, period, chooses, accompanies
    )
    return dataclasses.field(default=default, metadata={"parameter": declared})


@functools.cache
def parameters_of(owner: type) -> tuple[Parameter, ...]:
    """Return the parameters that a dataclass declares with `parameter`, in order."""
    return tuple(
        dataclasses.replace(field.metadata["parameter"], name=field.name)
        for field in dataclasses.fields(owner)
        if "parameter" in field.metadata
    )
