"""How probable healthy lines are about a calibrated machine, its unknowns and the probes' gains integrated out.

By how much the model is wrong beside them is taken as likely as it can be: a share of what is larger, a line as the
model makes it or as it was measured, and all of one that it cannot make (run-out at four times the shaft's speed). Such
a line would else be certain to a share of nothing, and move everything that can be moved. Not of 1X to 3X: a machine
that is far off would be excused for not making them, and what it lacks would not be asked for.
"""

from __future__ import annotations

import math

import numpy as np

from .baseline import Baseline
from .line_covariance import LineCovariance, line_covariance
from .lines import OrderLines
from .model_error import error_blocks, model_error
from .out_of_reach import out_of_reach

#: Factors of the usual model error of which the likeliest counts.
ERROR_FACTORS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
#: Orders that an unbalance and a coupling make.
OF_EVERY_MACHINE = (1.0, 2.0, 3.0)
#: Deviations of a sum of squares within which nothing is missed.
WITHIN = 3.0


def covariance_of_all(current: Baseline, healthy: OrderLines, factor: float) -> LineCovariance:
    """Return the covariance about a machine with the usual model error times a factor, of all that is uncertain."""
    measured = np.where(healthy.seen, healthy.amplitudes, 0.0)
    usual = factor * np.maximum(model_error(current.lines), model_error(measured))
    foreign = np.where(_of_every_machine(healthy), 0.0, out_of_reach(current, healthy))
    errors = error_blocks(healthy.conditions, np.maximum(usual, foreign))
    return line_covariance(healthy, errors, current.slopes, current.prior)


def _of_every_machine(healthy: OrderLines) -> np.ndarray:
    """Return which lines any machine makes, (orders,), bool: one that does not make them is not excused by that."""
    pairs = zip(healthy.orders, healthy.kinds, strict=True)
    return np.array([order in OF_EVERY_MACHINE and not (kind.frequency_hz or kind.envelope) for order, kind in pairs])


def whitened(current: Baseline, healthy: OrderLines, factor: float) -> tuple[LineCovariance, np.ndarray, float]:
    """Return the covariance, what the machine leaves of the lines whitened by it, and the logarithm of its density."""
    covariance = covariance_of_all(current, healthy, factor)
    white = covariance.whole(_left_over(current, healthy))
    return covariance, white, float(covariance.density(white))


def evidence(current: Baseline, healthy: OrderLines) -> float:
    """Return the logarithm of the evidence of the healthy lines, up to a constant."""
    return max(density for _, _, density in _each(current, healthy))


def is_explained(current: Baseline, healthy: OrderLines) -> bool:
    """Return whether the lines are as near as noise, the usual model error and what is uncertain allow."""
    (_, white, first), *others = _each(current, healthy)
    likeliest = all(first >= density for _, _, density in others)
    return likeliest and float(white @ white) <= white.size + WITHIN * math.sqrt(2 * white.size)


def fitted(current: Baseline, healthy: OrderLines) -> tuple[np.ndarray, np.ndarray]:
    """Return the most probable change of the machine's unknowns and the gains, by their slopes, and its covariance."""
    covariance, _, _ = max(_each(current, healthy), key=lambda one: one[2])
    change, root = covariance.told(_left_over(current, healthy))
    spread = current.prior[:, None] * root
    return current.prior_mean + current.prior * change, spread @ spread.T


def _left_over(current: Baseline, healthy: OrderLines) -> np.ndarray:
    return healthy.amplitudes - current.lines - np.tensordot(current.prior_mean, current.slopes, 1)


def _each(current: Baseline, healthy: OrderLines) -> list[tuple[LineCovariance, np.ndarray, float]]:
    return [whitened(current, healthy, factor) for factor in ERROR_FACTORS]
