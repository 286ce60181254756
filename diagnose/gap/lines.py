"""What is compared: complex amplitudes of shaft orders at every probe, in every condition, with their noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.effect import effect_catalogue
from ...simulators.errors import InvalidValueError, RotorwiseError
from ...simulators.machine import Machine

#: Always looked at: what shafts show, and the half orders of a nonlinear support.
USUAL_ORDERS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
#: Orders that are multiples of this fraction of a turn keep their phase to the shaft.
LOCKED_FRACTION = 1 / 6


@dataclass(frozen=True)
class Condition:
    """Speed of the reference shaft, and load in the unit of the machine's load parameter; None when unknown."""

    speed_rpm: float
    load: float | None = None

    def __str__(self) -> str:
        load = "" if self.load is None else f", load {self.load:g}"
        return f"{self.speed_rpm:.0f} rpm{load}"


@dataclass(frozen=True, eq=False)
class OrderLines:
    """Amplitudes on a grid of conditions, probes and orders.

    Attributes
    ----------
    conditions : tuple of Condition
    probes : tuple of str
    orders : tuple of float
        Multiples of the reference-shaft speed, phase-locked to it.
    amplitudes : ndarray (conditions, probes, orders), complex
        x = Re sum A exp(i order angle), angle 0 at the tacho's pulse; in the probe's SI unit.
    deviations : ndarray (conditions, probes, orders)
        Standard deviation of the real part and of the imaginary part; infinite where a line cannot be seen.
    """

    conditions: tuple[Condition, ...]
    probes: tuple[str, ...]
    orders: tuple[float, ...]
    amplitudes: np.ndarray
    deviations: np.ndarray

    def __post_init__(self) -> None:
        shape = (len(self.conditions), len(self.probes), len(self.orders))
        for name in ("amplitudes", "deviations"):
            if getattr(self, name).shape != shape:
                raise InvalidValueError(
                    f"OrderLines: {name} of shape {getattr(self, name).shape}; allowed: {shape}, for these conditions, "
                    "probes and orders."
                )

    @property
    def seen(self) -> np.ndarray:
        """Where a line can be seen, shape (conditions, probes, orders)."""
        return np.isfinite(self.deviations)

    def select(self, conditions: Sequence[int]) -> OrderLines:
        """Return these conditions only, in this order."""
        chosen = list(conditions)
        return replace(
            self,
            conditions=tuple(self.conditions[i] for i in chosen),
            amplitudes=self.amplitudes[chosen],
            deviations=self.deviations[chosen],
        )


def joined(first: OrderLines, second: OrderLines) -> OrderLines:
    """Return the conditions of both, which have the same probes and orders."""
    return replace(
        first,
        conditions=first.conditions + second.conditions,
        amplitudes=np.concatenate([first.amplitudes, second.amplitudes]),
        deviations=np.concatenate([first.deviations, second.deviations]),
    )


def stacked(values: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return the seen lines as reals: all real parts, then all imaginary parts; other axes may come first."""
    chosen = values[..., seen]
    return np.concatenate([np.real(chosen), np.imag(chosen)], axis=-1)


def locked_orders(machine: Machine, *, highest: float) -> tuple[float, ...]:
    """Return the orders to look at: the usual ones and every phase-locked line that an effect states, up to a limit.

    Parameters
    ----------
    machine : Machine
    highest : float
        Highest order of interest.
    """
    found = set(USUAL_ORDERS)
    for effect in effect_catalogue().values():
        try:
            effect().contribute(machine.bare_assembly())
            lines = effect().signature(machine)
        except RotorwiseError:
            continue
        found |= {line.order for line in lines if line.frequency_hz == 0 and _is_locked(line.order)}
    return tuple(sorted(round(order, 6) for order in found if 0 < order <= highest + 1e-9))


def _is_locked(order: float) -> bool:
    return abs(order / LOCKED_FRACTION - round(order / LOCKED_FRACTION)) < 1e-6
