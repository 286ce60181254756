"""What a recipe says of a number: one value, a grid, a range, or what the parameter's declaration expects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..simulators.parameter import LogNormal, Parameter, Prior, Uniform
from .errors import InvalidValueError

#: Draws outside a parameter's bounds are drawn again; a distribution that misses them so often is a mistake.
MOST_TRIES = 1000
_LARGEST = 1e100
_WIDEST = 1000.0
_MOST_CELLS = 100_000
_ALLOWED = (
    'a number, "prior", { grid = [1, 2] }, { from = 1, to = 2 } with spacing = "log", cells = 4 or whole = true if '
    "wanted, or { around = 1, factor = 1.5 }"
)


@dataclass(frozen=True)
class Choice:
    """One or more values, or a distribution.

    Parameters
    ----------
    values : tuple of float
        Of a fixed value (one) or a grid; empty for a distribution.
    low, high : float
        Ends of a range; of a distribution's bounds otherwise.
    cells : int
        A range in so many equal parts gives one value from each.
    logarithmic, whole : bool
        Equal chances for equal ratios; whole numbers only.
    prior : Prior, optional
        Truncated to ``low`` and ``high``.
    """

    values: tuple[float, ...] = ()
    low: float = -math.inf
    high: float = math.inf
    cells: int = 1
    logarithmic: bool = False
    whole: bool = False
    prior: Prior | None = None

    @property
    def count(self) -> int:
        """How many signals differ by this number alone."""
        return max(len(self.values), self.cells)

    @property
    def is_fixed(self) -> bool:
        """Whether there is nothing to choose."""
        return len(self.values) == 1

    def draw(self, generator: np.random.Generator, cell: int = 0) -> float:
        """Return the value of one cell; a grid does not use the random numbers."""
        if self.values:
            return self.values[cell]
        if self.prior is not None:
            return self._from_prior(self.prior, generator)
        share = (cell + generator.random()) / self.cells
        if self.whole:
            return float(math.floor(self.low + share * (self.high - self.low + 1)))
        if self.logarithmic:
            return min(max(self.low * (self.high / self.low) ** share, self.low), self.high)
        return self.low + share * (self.high - self.low)

    def _from_prior(self, prior: Prior, generator: np.random.Generator) -> float:
        for _ in range(MOST_TRIES):
            value = prior.sample(generator)
            if self.low <= value <= self.high:
                return value
        raise InvalidValueError(
            f"{prior} gave no value from {self.low:g} to {self.high:g} in {MOST_TRIES} draws. Correct the range."
        )

    def ends(self) -> tuple[float, ...]:
        """Return values that are drawn or close to it: all of a grid, both ends of a range, a prior's median."""
        if self.values:
            return self.values
        if self.prior is not None:
            return (min(max(self.prior.median, self.low), self.high),)
        return self.low, self.high

    def text(self) -> str:
        """Return the choice in words, for the dataset card."""
        if self.values:
            return ", ".join(f"{value:g}" for value in self.values)
        if self.prior is not None:
            return self._prior_text(self.prior)
        how = [
            *(["logarithmic"] if self.logarithmic else []),
            *(["whole numbers"] if self.whole else []),
            *([f"one from each of {self.cells} parts"] if self.cells > 1 else []),
        ]
        return f"{self.low:g} to {self.high:g}" + (f" ({', '.join(how)})" if how else "")

    def _prior_text(self, prior: Prior) -> str:
        if isinstance(prior, Uniform):
            return f"{max(prior.low, self.low):g} to {min(prior.high, self.high):g}"
        if isinstance(prior, LogNormal):
            return f"about {prior.median:g} within a factor of {prior.factor:g}, {self.low:g} to {self.high:g}"
        return f"{prior.mean:g} +- {prior.deviation:g}, {self.low:g} to {self.high:g}"


def parse_choice(where: str, given: object, declared: Parameter | None = None, *, cells: bool = True) -> Choice:
    """Return what a recipe says of a number.

    Parameters
    ----------
    where : str
        Begins every message, such as "Recipe x.toml, gearbox, load".
    given : object
        As TOML gives it.
    declared : Parameter, optional
        Bounds and prior of the number.
    cells : bool
        Whether a grid or a range with cells is allowed here.

    Raises
    ------
    InvalidValueError
        For anything else than the forms allowed, or values out of the parameter's bounds.
    """
    if given == "prior":
        return _declared(where, declared)
    if isinstance(given, int | float) and not isinstance(given, bool):
        choice = Choice(values=(_number(where, given),))
    elif isinstance(given, dict) and set(given) == {"grid"} and isinstance(given["grid"], list) and given["grid"]:
        choice = Choice(values=tuple(_number(where, one) for one in given["grid"]))
    elif isinstance(given, dict) and set(given) == {"around", "factor"}:
        choice = _around(where, given)
    elif isinstance(given, dict) and {"from", "to"} <= set(given) <= {"from", "to", "spacing", "cells", "whole"}:
        choice = _range(where, given)
    else:
        raise InvalidValueError(f"{where} = {given!r}; allowed: {_ALLOWED}. Correct it.")
    if not cells and choice.count > 1:
        raise InvalidValueError(
            f"{where} has {choice.count} cells, but is drawn once a machine draw; allowed here: no grid and no cells. "
            "Put it into the cases."
        )
    return _checked(where, choice, declared)


def _declared(where: str, declared: Parameter | None) -> Choice:
    if declared is None or declared.prior is None:
        raise InvalidValueError(f'{where} = "prior", but nothing declares one; allowed here: a number or a range.')
    return Choice(low=declared.bounds[0], high=declared.bounds[1], prior=declared.prior)


def _around(where: str, given: Mapping[str, object]) -> Choice:
    middle, factor = _number(where, given["around"]), _number(where, given["factor"])
    if not (middle > 0 and 1 < factor <= _WIDEST):
        raise InvalidValueError(
            f"{where}: around {middle:g} by a factor of {factor:g}; allowed: above 0, factor above 1 and at most "
            f"{_WIDEST:g}. Correct it."
        )
    return Choice(prior=LogNormal(middle, factor))


def _range(where: str, given: Mapping[str, object]) -> Choice:
    low, high = _number(where, given["from"]), _number(where, given["to"])
    spacing, cells, whole = given.get("spacing", "linear"), given.get("cells", 1), given.get("whole", False)
    if not low < high:
        raise InvalidValueError(f"{where}: from {low:g} to {high:g}; allowed: rising. Turn them round.")
    if spacing not in ("linear", "log") or (spacing == "log" and low <= 0):
        raise InvalidValueError(
            f"{where}: spacing {spacing!r} from {low:g}; allowed: linear, or log from more than 0. Correct it."
        )
    if isinstance(cells, bool) or not isinstance(cells, int) or not 1 <= cells <= _MOST_CELLS:
        raise InvalidValueError(f"{where}: cells = {cells!r}; allowed: a whole number, 1 to {_MOST_CELLS}. Correct it.")
    if not isinstance(whole, bool) or (whole and (spacing == "log" or low % 1 or high % 1 or cells > 1)):
        raise InvalidValueError(
            f"{where}: whole = {whole!r}; allowed: true or false, whole ends, no spacing, no cells. Correct it."
        )
    return Choice(low=low, high=high, cells=cells, logarithmic=spacing == "log", whole=whole)


def _checked(where: str, choice: Choice, declared: Parameter | None) -> Choice:
    if declared is None:
        return choice
    for value in (choice.prior.median,) if choice.prior is not None else choice.ends():
        try:
            declared.checked(value)
        except InvalidValueError as problem:
            raise InvalidValueError(f"{where}: {problem}") from None
    if choice.prior is not None:
        return replace(choice, low=declared.bounds[0], high=declared.bounds[1])
    return choice


def _number(where: str, given: object) -> float:
    if isinstance(given, bool) or not isinstance(given, int | float) or not -_LARGEST <= given <= _LARGEST:
        raise InvalidValueError(f"{where}: {given!r} is no finite number. Give one up to 1e100.")
    return float(given)
