"""The hypothesis that something acts which no effect of the catalogue explains: forces, or simply smooth lines.

Order by order the unexplained part is a random function of the condition: forces somewhere on the machine or at one
place of it, smooth or by a power of speed (`force_kernels`), or an error of each probe's line that varies smoothly, at
all probes or at those of one place alone.
Which of these and how strong is what the data say most probably (empirical Bayes); the choice costs the logarithm of
its prior probability. Where a stiffness changes with the shaft's angle, a force at one order makes lines at others:
these are no further orders that something unknown makes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .evidence import LAW_TOLERANCE, PROBE_TOLERANCE, Comparison
from .force_kernels import ForceKernel, prior_shares
from .lines import unstacked
from .model_error import similarity
from .record_scatter import alike
from .transfer_error import LEAST

#: Sizes tried, as shares of the largest line left in the order.
SIZES = np.geomspace(1e-3, 10.0, 17)
#: An order needs this much more evidence than the choices cost, to count as unexplained.
LEAST_GAIN = 3.0
#: An order whose lines together exceed noise by fewer standard deviations is not looked at.
STANDS_OUT = 2.0
#: Relative size, in the covariance, of what keeps it positive.
JITTER = 1e-9


@dataclass(frozen=True, eq=False)
class Unknown:
    """Lines that nothing in the catalogue explains.

    Attributes
    ----------
    log_evidence : float
    lines : ndarray (conditions, probes, orders), complex
        Their most probable values; 0 in orders that need nothing.
    gains : ndarray (orders,)
        Evidence that each order adds.
    kernels : mapping of int to ndarray (reals, reals)
        By the number of each order that needs it: the covariance that it adds to the lines.
    prices : mapping of int to float
        Evidence that the choice of each of these cost.
    """

    log_evidence: float
    lines: np.ndarray
    gains: np.ndarray
    kernels: Mapping[int, np.ndarray]
    prices: Mapping[int, float]

    def without(self, order: int) -> tuple[np.ndarray, float]:
        """Return the covariance of all orders but one, and what choosing them cost."""
        kept = [number for number in self.kernels if number != order]
        some = next(iter(self.kernels.values()))
        added = sum((self.kernels[number] for number in kept), np.zeros_like(some))
        return added, sum(self.prices[number] for number in kept)


def unexplained(compared: Comparison, kernels: Sequence[ForceKernel]) -> Unknown:
    """Return the most probable unexplained lines.

    Parameters
    ----------
    compared : Comparison
    kernels : sequence of ForceKernel
        What forces make; none where phases are not those of one pulse a turn.
    """
    residual = compared.factor @ compared.residual
    chosen: dict[int, np.ndarray] = {}
    prices: dict[int, float] = {}
    for order in range(len(compared.lines.orders)):
        found = _most_probable(compared, residual, order, kernels)
        if found and found[0] > LEAST_GAIN:
            _, chosen[order], prices[order] = found
    count = len(compared.lines.orders)
    if len(chosen) > 1:
        chosen = _needed(compared, residual, chosen, prices)
    if not chosen:
        # Nothing is left over: that something is there all the same has to pay for at least one order.
        nothing = compared.log_constant - 0.5 * float(compared.residual @ compared.residual)
        none = np.zeros(compared.seen.shape, dtype=complex)
        return Unknown(nothing - LEAST_GAIN, none, np.zeros(count), {}, {})
    # Sizes were chosen order by order; what they are worth together is the density of all lines.
    together = sum(chosen.values(), np.zeros_like(compared.covariance))
    evidence, values = _joint(compared, residual, together)
    gains = np.zeros(count)
    for order, part in chosen.items():
        gains[order] = evidence - _joint(compared, residual, together - part)[0]
    lines, prices = unstacked(values, compared.lines.parts), {order: prices[order] for order in chosen}
    return Unknown(evidence - sum(prices.values()), lines, gains, chosen, prices)


def _needed(
    compared: Comparison, residual: np.ndarray, chosen: Mapping[int, np.ndarray], prices: Mapping[int, float]
) -> dict[int, np.ndarray]:
    """Return the orders without those whose lines the forces at others make as well, at less than their price."""
    kept = dict(chosen)
    while len(kept) > 1:
        together = sum(kept.values(), np.zeros_like(compared.covariance))
        evidence = _joint(compared, residual, together)[0]
        worth = {k: evidence - _joint(compared, residual, together - own)[0] - prices[k] for k, own in kept.items()}
        least = min(worth, key=lambda order: worth[order])
        if worth[least] >= 0:
            break
        del kept[least]
    return kept


def _most_probable(
    compared: Comparison, residual: np.ndarray, order: int, kernels: Sequence[ForceKernel]
) -> tuple[float, np.ndarray, float] | None:
    """Return what the best kernel adds to the evidence of one order, less its price, its covariance, and the price."""
    lines = compared.lines
    one = _one_order(compared, residual, order)
    if one is None or one.white @ one.white < one.rows.size + STANDS_OUT * math.sqrt(2 * one.rows.size):
        return None
    smooth = 1 / 3 if kernels and lines.kinds[order].phase else 1.0
    options: list[tuple[np.ndarray, float, ForceKernel | None]] = []
    options += [(_line_kernel(compared, own), smooth * share, None) for own, share in _groups(compared)]
    if lines.kinds[order].phase:
        passed = _as_it_passes(compared, order)
        shares = zip(kernels, prior_shares(kernels), strict=True)
        options += [(passed * kernel.lines(order), share, kernel) for kernel, share in shares]
    found = []
    for number, (kernel, share, _) in enumerate(options):
        block = _stacked(compared, order, kernel) * one.largest**2
        gain, size = _best_size(one.white, one.inverse @ block @ one.inverse.T)
        price = math.log(SIZES.size / share)
        found.append((gain - price, -number, size * block, price))
    gain, number, block, price = max(found, key=lambda one: one[:2])
    whole, force = np.zeros_like(compared.covariance), options[-number][2]
    if force is not None:
        whole = _spread(compared, order, force)
        own = np.diag(whole)[one.rows].max()
        whole *= np.diag(block).max() / max(own, 1e-300)
    whole[np.ix_(one.rows, one.rows)] = block
    return gain, whole, price


def _spread(compared: Comparison, order: int, kernel: ForceKernel) -> np.ndarray:
    """Return the covariance of all stacked lines (reals, reals) that forces at one order make, there and at others.

    What they make at others follows no better than the orders of an effect follow each other.
    """
    parts, numbers = compared.lines.parts, list(kernel.numbers)
    found = kernel.spread(order)
    for at, number in enumerate(numbers):
        found[:, :, at, :, :, :, at] *= _as_it_passes(compared, number, 0.0 if number == order else LAW_TOLERANCE)
    place = np.full(parts.shape, -1)
    place[parts] = np.arange(int(parts.sum()))
    rows = place[..., numbers].transpose(0, 1, 3, 2).ravel()
    seen = np.flatnonzero(rows >= 0)
    whole = np.zeros_like(compared.covariance)
    whole[np.ix_(rows[seen], rows[seen])] = found.reshape(2 * [rows.size])[np.ix_(seen, seen)]
    return whole


@dataclass(frozen=True, eq=False)
class _OneOrder:
    """What is left of one order: its rows among the stacked lines, whitened by the inverse factor of its covariance."""

    rows: np.ndarray
    inverse: np.ndarray
    white: np.ndarray
    largest: float


def _one_order(compared: Comparison, residual: np.ndarray, order: int) -> _OneOrder | None:
    here = np.zeros(compared.seen.shape, dtype=bool)
    here[:, :, order] = True
    rows = np.flatnonzero(np.concatenate([here[part] for part in compared.lines.parts]))
    if not rows.size:
        return None
    own = compared.covariance[np.ix_(rows, rows)]
    inverse = np.linalg.inv(np.linalg.cholesky(own + JITTER * np.diag(np.diag(own))))
    return _OneOrder(rows, inverse, inverse @ residual[rows], float(np.abs(residual[rows]).max()))


def gain_at_places(compared: Comparison, kernels: Sequence[ForceKernel], order: int) -> dict[str, float]:
    """Return by how much forces at each place, at their best size and law, raise the evidence of one order.

    "" stands for forces at all places; nothing where the order has no phase or is not seen.
    """
    one = _one_order(compared, compared.factor @ compared.residual, order)
    if one is None or not compared.lines.kinds[order].phase:
        return {}
    passed, found = _as_it_passes(compared, order), {}
    for kernel in kernels:
        block = _stacked(compared, order, passed * kernel.lines(order)) * one.largest**2
        gain, _ = _best_size(one.white, one.inverse @ block @ one.inverse.T)
        found[kernel.at] = max(found.get(kernel.at, -math.inf), gain)
    return found


def _joint(compared: Comparison, residual: np.ndarray, added: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the logarithm of the density with a further covariance, and what of the residual that explains."""
    whole = compared.covariance + added
    factor = np.linalg.cholesky(whole + JITTER * np.diag(np.diag(whole)))
    white = np.linalg.solve(factor, residual)
    density = -0.5 * float(white @ white) - float(np.log(np.diag(factor)).sum())
    return density - 0.5 * residual.size * math.log(2 * math.pi), added @ np.linalg.solve(factor.T, white)


def _stacked(compared: Comparison, order: int, kernel: np.ndarray) -> np.ndarray:
    """Return the covariance of one order's stacked lines, from that of all parts (2, c, p, 2, c, p), largest 1."""
    seen = np.flatnonzero(compared.lines.parts[..., order])
    block = kernel.reshape(2 * [compared.lines.parts[..., order].size])[np.ix_(seen, seen)]
    return block / max(float(np.diag(block).max()), 1e-300)


def _best_size(white: np.ndarray, kernel: np.ndarray) -> tuple[float, float]:
    """Return the largest gain of evidence by a random function, and its variance, from whitened lines and kernel."""
    values, vectors = np.linalg.eigh(kernel)
    power = (vectors.T @ white) ** 2
    grown = np.outer(SIZES**2, np.maximum(values, 0.0))
    gains = 0.5 * (power * grown / (1 + grown)).sum(axis=1) - 0.5 * np.log1p(grown).sum(axis=1)
    best = int(np.argmax(gains))
    return float(gains[best]), float(SIZES[best] ** 2)


def _as_it_passes(compared: Comparison, order: int, law: float = 0.0) -> np.ndarray:
    """Return the factors by which errors of the way from a force to the probes enlarge a covariance of lines.

    What something unknown makes is known no better than what an effect does: at each probe it may be wrong by a complex
    factor, and smoothly by the share by which the machine misses its own healthy lines; at all of them by ``law``.
    Shape as of the covariance, (1, conditions, probes, 1, conditions, probes).
    """
    transfer, conditions = compared.transfer, compared.lines.conditions
    share = np.where(transfer.share[:, order] > LEAST, transfer.share[:, order], 0.0)
    smooth = similarity(conditions, transfer.length)
    own = PROBE_TOLERANCE**2 + np.einsum("p,cd->pcd", share**2, smooth)
    # Of a normal amplitude whose phase may be any, both parts of the factor add the same.
    found = np.full((len(conditions), share.size, len(conditions), share.size), 1 + 2 * law**2)
    for probe, added in enumerate(own):
        found[:, probe, :, probe] += 2 * added
    found *= alike(len(conditions), transfer.by_record)[:, None, :, None]
    return found[None, :, :, None]


def _groups(compared: Comparison) -> list[tuple[np.ndarray, float]]:
    """Return which probes show a line that is merely smooth, (probes,) bool, and the prior probability of that.

    All of them, or what acts on the measuring chain: one alone, or those of one place that measure the same.
    """
    beside = compared.transfer.beside
    every = np.ones(len(beside), dtype=bool)
    some = {tuple(own.tolist()) for own in (*beside, *np.eye(len(beside), dtype=bool))} - {tuple(every.tolist())}
    if not some:
        return [(every, 1.0)]
    return [(every, 0.5), *((np.array(own), 0.5 / len(some)) for own in sorted(some))]


def _line_kernel(compared: Comparison, probes: np.ndarray) -> np.ndarray:
    conditions = compared.lines.conditions
    smooth = similarity(conditions) * alike(len(conditions), compared.transfer.by_record)
    size = _sizes(compared) * probes
    return np.einsum("xy,cd,pq->xcpydq", np.eye(2), smooth, np.diag(size**2))


def _sizes(compared: Comparison) -> np.ndarray:
    """Return the scale of each probe: its largest line."""
    return np.maximum(np.abs(compared.lines.amplitudes).max(axis=(0, 2)), 1e-300)
