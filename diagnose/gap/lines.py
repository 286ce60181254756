"""What is compared: lines of every probe in every condition, with their noise."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.errors import InvalidValueError

#: Speeds within this factor count as one.
ALIKE = 1.05


@dataclass(frozen=True)
class Condition:
    """Speed of the reference shaft, and load in the unit of the machine's load parameter; None when unknown.

    ``tied`` says whether the shaft's angle is known, so that phases refer to it.
    """

    speed_rpm: float
    load: float | None = None
    tied: bool = True

    def __str__(self) -> str:
        load = "" if self.load is None else f", load {self.load:g}"
        return f"{self.speed_rpm:.0f} rpm{load}"


def different_speeds(conditions: Sequence[Condition]) -> int:
    """Return how many speeds lie apart."""
    speeds = sorted(one.speed_rpm for one in conditions)
    return min(len(speeds), 1) + sum(b > ALIKE * a for a, b in itertools.pairwise(speeds))


@dataclass(frozen=True)
class LineKind:
    """How a line is seen.

    Attributes
    ----------
    phase : bool
        It keeps its phase to the shaft: its complex amplitude is compared. Else only its size is, a number of at
        least 0.
    envelope : bool
        It is a line of the envelope's spectrum.
    frequency_hz : float
        Added to the order's frequency.
    """

    phase: bool = True
    envelope: bool = False
    frequency_hz: float = 0.0

    def order_at(self, order: float, speed_rpm: float) -> float:
        """Return the line's place as a multiple of the shaft's speed."""
        return abs(order + 60 * self.frequency_hz / speed_rpm)


@dataclass(frozen=True, eq=False)
class OrderLines:
    """Amplitudes on a grid of conditions, probes and lines.

    Attributes
    ----------
    conditions : tuple of Condition
    probes : tuple of str
    orders : tuple of float
        Multiples of the reference-shaft speed.
    amplitudes : ndarray (conditions, probes, orders), complex
        x = Re sum A exp(i order angle), angle 0 at the tacho's pulse; in the probe's SI unit. Real and at least 0 for
        lines without phase. In conditions that are not tied, the phase is that relative to the reference probe.
    deviations : ndarray (conditions, probes, orders)
        Standard deviation of the real part and of the imaginary part; infinite where a line cannot be seen.
    kinds : tuple of LineKind
        One for each order; all with phase when not given.
    reference : tuple of int
        For each order, the number of the probe whose phase counts as 0 in conditions that are not tied.
    knees : ndarray (probes, orders), optional
        Of the scale on which sizes of lines without phase are (`size_scale.py`); they are in units when not given.
    constant : ndarray (probes, orders), optional
        Standard deviation of what a line may have alike in all conditions (`track_run_out.py`).
    """

    conditions: tuple[Condition, ...]
    probes: tuple[str, ...]
    orders: tuple[float, ...]
    amplitudes: np.ndarray
    deviations: np.ndarray
    kinds: tuple[LineKind, ...] = ()
    reference: tuple[int, ...] = ()
    knees: np.ndarray | None = None
    constant: np.ndarray | None = None

    def __post_init__(self) -> None:
        count = len(self.orders)
        if not self.kinds:
            object.__setattr__(self, "kinds", (LineKind(),) * count)
        if not self.reference:
            object.__setattr__(self, "reference", (0,) * count)
        shape = (len(self.conditions), len(self.probes), count)
        for name in ("amplitudes", "deviations"):
            if getattr(self, name).shape != shape:
                raise InvalidValueError(
                    f"OrderLines: {name} of shape {getattr(self, name).shape}; allowed: {shape}, for these conditions, "
                    "probes and orders."
                )
        if not len(self.kinds) == len(self.reference) == count:
            raise InvalidValueError(
                f"OrderLines: {len(self.kinds)} kinds and {len(self.reference)} references for {count} orders; allowed:"
                " one of each for every order."
            )

    @property
    def phase_orders(self) -> np.ndarray:
        """By how much each line's phase turns with the shaft's angle: its order, 0 for lines without phase."""
        return phase_orders(self.orders, self.kinds)

    @property
    def spectrum_on_scale(self) -> bool:
        """Whether sizes in the spectrum, not only in the envelope, are on the scale: of machines that do not repeat."""
        own = np.array([not kind.phase and not kind.envelope for kind in self.kinds])
        return self.knees is not None and bool((np.isfinite(self.knees) & own).any())

    @property
    def seen(self) -> np.ndarray:
        """Where a line can be seen, shape (conditions, probes, orders)."""
        return np.isfinite(self.deviations)

    @property
    def parts(self) -> np.ndarray:
        """Where the real part and where the imaginary part says something, shape (2, conditions, probes, orders)."""
        seen = self.seen
        return np.stack([seen, seen & has_phase(self.conditions, len(self.probes), self.kinds, self.reference)])

    @property
    def part_counts(self) -> np.ndarray:
        """Of how many parts each line is, (orders,): a real and an imaginary one, or only its size."""
        return np.array([2 if kind.phase else 1 for kind in self.kinds])

    def select(self, conditions: Sequence[int]) -> OrderLines:
        """Return these conditions only, in this order."""
        chosen = list(conditions)
        return replace(
            self,
            conditions=tuple(self.conditions[i] for i in chosen),
            amplitudes=self.amplitudes[chosen],
            deviations=self.deviations[chosen],
        )


def phase_orders(orders: Sequence[float], kinds: Sequence[LineKind]) -> np.ndarray:
    """Return each line's order, 0 for lines without phase, shape (orders,)."""
    return np.array([order if kind.phase else 0.0 for order, kind in zip(orders, kinds, strict=True)])


def has_phase(
    conditions: Sequence[Condition], probes: int, kinds: Sequence[LineKind], reference: Sequence[int]
) -> np.ndarray:
    """Return where a line's phase says something, shape (conditions, probes, orders)."""
    tied = np.array([one.tied for one in conditions])[:, None, None]
    first = np.array(reference)[None, None, :] == np.arange(probes)[None, :, None]
    return np.array([kind.phase for kind in kinds])[None, None, :] & (tied | ~first)


def turned_to_reference(
    amplitudes: np.ndarray, conditions: Sequence[Condition], reference: Sequence[int]
) -> np.ndarray:
    """Return amplitudes (conditions, probes, orders) with the reference probe's phase at 0 where nothing ties it."""
    result = amplitudes.copy()
    columns = np.arange(amplitudes.shape[2])
    for number, condition in enumerate(conditions):
        if not condition.tied:
            first = amplitudes[number, np.array(reference), columns]
            size = np.abs(first)
            result[number] *= np.where(size > 0, first.conj() / np.maximum(size, 1e-300), 1.0)
    return result


def strongest_probes(amplitudes: np.ndarray, deviations: np.ndarray) -> tuple[int, ...]:
    """Return for each order the probe that shows it most clearly over all conditions."""
    clear = np.where(np.isfinite(deviations), np.abs(amplitudes) / np.maximum(deviations, 1e-300), 0.0)
    return tuple(int(i) for i in np.argmax((clear**2).sum(axis=0), axis=0))


def joined(first: OrderLines, second: OrderLines) -> OrderLines:
    """Return the conditions of both, which have the same probes and orders."""
    return replace(
        first,
        conditions=first.conditions + second.conditions,
        amplitudes=np.concatenate([first.amplitudes, second.amplitudes]),
        deviations=np.concatenate([first.deviations, second.deviations]),
    )


def stacked(values: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return lines as reals: the real parts, then the imaginary parts, of those that say something.

    Parameters
    ----------
    values : ndarray (..., conditions, probes, orders), complex
    parts : ndarray (2, conditions, probes, orders), bool
        `OrderLines.parts`.
    """
    return np.concatenate([np.real(values[..., parts[0]]), np.imag(values[..., parts[1]])], axis=-1)


def unstacked(values: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return stacked reals (reals,) as complex lines, 0 where nothing is seen."""
    result = np.zeros(parts.shape[1:], dtype=complex)
    count = int(parts[0].sum())
    result[parts[0]] = values[:count]
    result[parts[1]] += 1j * values[count:]
    return result


def seen_in(parts: np.ndarray) -> np.ndarray:
    """Return what says something line by line, (2, probes, orders, conditions)."""
    return np.moveaxis(parts, 1, -1)


def in_blocks(values: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return lines (..., conditions, probes, orders) as reals, (..., 2, probes, orders, conditions); 0 where unseen."""
    both = np.where(parts, np.stack([np.real(values), np.imag(values)], axis=-4), 0.0)
    return np.moveaxis(both, -3, -1)


def from_blocks(blocks: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return reals (..., 2, probes, orders, conditions) as stacked ones, (..., reals)."""
    return np.moveaxis(blocks, -1, -3)[..., parts]


def dense(blocks: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return a matrix of the stacked lines, (reals, reals), of one matrix over the conditions for each line.

    ``blocks`` (2, probes, orders, conditions, conditions); what is unseen is left out.
    """
    place = np.full(parts.shape, -1)
    place[parts] = np.arange(int(parts.sum()))
    place = seen_in(place)
    rows, columns = np.broadcast_arrays(place[..., :, None], place[..., None, :])
    both = (rows >= 0) & (columns >= 0)
    result = np.zeros((int(parts.sum()),) * 2)
    result[rows[both], columns[both]] = blocks[both]
    return result
