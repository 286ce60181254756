"""By how much what passes from a force to a probe is wrong in the model, as the healthy recordings show it.

A machine whose supports are not those of the model answers every force wrongly, a fault's as well. Healthy lines that
the machine makes itself say by which share; what an effect adds may then be wrong by the same share, smoothly in speed
and load. A direction in which the model hardly moves is taken to be as wrong as the largest one at the same place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.assembly import Probe
from .baseline import Baseline
from .calibration import left_variance
from .lines import Condition, OrderLines
from .model_error import ERROR_LENGTH_SPEED, similarity

#: A healthy line tells where it is so many times its noise (of one record; more tell more), and the model's at least
#: this share of it.
CLEAR, LEAST_MADE = 10.0, 1 / 3
#: Shares where healthy recordings show no such line, as the model has then not been checked: the first one, and those
#: that are tried where something unknown acts as well.
UNCHECKED = (0.2, 0.5, 1.0)
#: A smaller share is left out: the tolerance of an effect's law at each probe covers it.
LEAST = 0.01


@dataclass(frozen=True, eq=False)
class TransferError:
    """The share by which responses may be wrong.

    Attributes
    ----------
    share : ndarray (probes, orders)
    beside : ndarray (probes, probes), bool
        Probes at the same place that measure the same quantity.
    is_checked : bool
        Whether healthy recordings told the share.
    length : float
        Relative change of speed over which the error changes much.
    by_record : float
        Share by which what acts differs from one recording to the next, see `record_scatter.py`.
    """

    share: np.ndarray
    beside: np.ndarray
    is_checked: bool = True
    length: float = ERROR_LENGTH_SPEED
    by_record: float = 0.0

    def options(self) -> list[TransferError]:
        """Return what it may be as well: itself where it was checked."""
        if self.is_checked:
            return [self]
        return [replace(self, share=np.full(self.share.shape, share)) for share in UNCHECKED]

    def at_least(self, share: float) -> TransferError:
        """Return one that is nowhere smaller than a share."""
        return replace(self, share=np.maximum(self.share, share))

    def directions(self, response: np.ndarray, conditions: tuple[Condition, ...]) -> tuple[np.ndarray, np.ndarray]:
        """Return independent errors of a response, each of standard deviation 1, up to their complex phase.

        Parameters
        ----------
        response : ndarray (conditions, probes, orders), complex
        conditions : tuple of Condition

        Returns
        -------
        errors : ndarray (places, ways, conditions), complex
        places : ndarray of int (places, 2)
            Probe and order of the only line that each of them changes.
        """
        size = (np.abs(response) ** 2).sum(axis=0)
        largest = np.argmax(np.where(self.beside[:, :, None], size[None], -1.0), axis=1)
        present = np.take_along_axis(size, largest, axis=0) > 0
        values, vectors = np.linalg.eigh(similarity(conditions, self.length))
        ways = (vectors * np.sqrt(np.maximum(values, 0.0)))[:, values > 1e-3 * values.max()].T
        places = np.argwhere(present & (self.share > LEAST))
        probe, order = places.T
        as_large = response[:, largest[probe, order], order].T
        return self.share[probe, order, None, None] * ways * as_large[:, None], places


def none_of(lines: OrderLines) -> TransferError:
    """Return that responses are right."""
    probes = len(lines.probes)
    return TransferError(np.zeros(lines.seen.shape[1:]), np.eye(probes, dtype=bool))


def learnt(
    current: Baseline,
    healthy: OrderLines,
    probes: Sequence[Probe],
    *,
    length: float = ERROR_LENGTH_SPEED,
    constant: np.ndarray | float = 0.0,
) -> TransferError:
    """Return by which share the calibrated machine misses healthy lines that it makes itself.

    Orders of which nothing is learnt have their probe's rms, probes of which nothing is learnt that of all.

    Parameters
    ----------
    current : Baseline
        Calibrated, in the healthy conditions.
    healthy : OrderLines
    probes : sequence of Probe
        Of the machine, in any order.
    length : float
        Relative change of speed over which what the machine misses changes much.
    constant : ndarray (probes, orders) or float
        Share of the variance of that which is alike in all conditions: a run-out says nothing of what forces make.
    """
    places = {probe.name: (probe.location, probe.quantity) for probe in probes}
    own = [places[name] for name in healthy.probes]
    beside = np.array([[one == other for other in own] for one in own])
    seen = healthy.seen
    count = seen.sum(axis=0)
    noise = np.where(seen, healthy.deviations, 0.0) ** 2
    parts = healthy.part_counts
    size = np.where(seen, np.abs(healthy.amplitudes) ** 2 / parts, 0.0).sum(axis=0)
    made = np.where(seen, np.abs(current.lines) ** 2 / parts, 0.0).sum(axis=0)
    clear = (count > 1) & (size * np.sqrt(count) > CLEAR**2 * noise.sum(axis=0)) & (made > LEAST_MADE**2 * size)
    if not clear.any():
        return TransferError(np.full(clear.shape, UNCHECKED[0]), beside, is_checked=False)
    # The gain of each probe has been fitted as well.
    left = (1 - constant) * left_variance(current, healthy) * count**2 / np.maximum(count - 1, 1)
    power = np.where(clear, left / np.where(size > 0, size, 1.0), 0.0)
    of_all = power.sum() / clear.sum()
    of_probe = np.where(clear.any(axis=1), power.sum(axis=1) / np.maximum(clear.sum(axis=1), 1), of_all)
    share = np.sqrt(np.where(clear, power, of_probe[:, None]))
    return TransferError(np.minimum(share, 1.0), beside, length=length)
