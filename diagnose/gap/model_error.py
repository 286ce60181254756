"""By how much a model's lines are wrong: as a random function of speed and load, for each order at each probe alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .lines import Condition, dense

#: Model error of a line that no healthy recording shows, as a share of its rms over the conditions.
MODEL_ERROR = 0.01
#: Speed to which model errors that grow with it refer.
REFERENCE_RPM = 1000.0
#: Change of speed, and of load, over which the model error changes much.
ERROR_LENGTH_SPEED, ERROR_LENGTH_LOAD = 0.2, 0.5


@dataclass(frozen=True, eq=False)
class ModelError:
    """By how much a machine's lines are wrong: standard deviation of the real part and of the imaginary part.

    Attributes
    ----------
    deviation : ndarray (probes, orders)
        At `REFERENCE_RPM`.
    growth : ndarray (probes, orders)
        Power of the speed.
    length : float
        Relative change of speed over which they change much.
    own_share : float
        Share of the variance that no other condition has in common with one, however near.
    common : ndarray (probes, orders) or float
        Share of the variance, beside which the others count, that all conditions have in common, however far.
    """

    deviation: np.ndarray
    growth: np.ndarray
    length: float = ERROR_LENGTH_SPEED
    own_share: float = 0.0
    common: np.ndarray | float = 0.0

    def at(self, conditions: Sequence[Condition]) -> np.ndarray:
        """Return the deviation in each condition, shape (conditions, probes, orders)."""
        speeds = np.array([one.speed_rpm for one in conditions])[:, None, None] / REFERENCE_RPM
        return self.deviation * speeds**self.growth

    def alike(self, conditions: tuple[Condition, ...]) -> np.ndarray:
        """Return how alike each line's is in two conditions, 0 to 1, shape (probes, orders, conditions, conditions)."""
        near = similarity(conditions, self.length)
        changing = near + self.own_share * (np.eye(len(conditions)) - near)
        constant = np.broadcast_to(self.common, self.deviation.shape)[..., None, None]
        return constant + (1 - constant) * changing


def error_blocks(
    conditions: tuple[Condition, ...], error: np.ndarray | ModelError, *, length: float = ERROR_LENGTH_SPEED
) -> np.ndarray:
    """Return the covariance of each line's model error over the conditions, (probes, orders, conditions, conditions).

    Of the real part, and of the imaginary part; those of different lines are independent.

    Parameters
    ----------
    conditions : tuple of Condition
    error : ndarray ([conditions,] probes, orders) or ModelError
        Without conditions it is the same in all of them.
    length : float
        Relative change of speed over which it changes much; a ModelError has its own.
    """
    known = isinstance(error, ModelError)
    kernel = error.alike(conditions) if known else similarity(conditions, length)
    each = error.at(conditions) if known else np.broadcast_to(error, (len(conditions), *error.shape[-2:]))
    own = np.moveaxis(each, 0, -1)
    return kernel * own[..., :, None] * own[..., None, :]


def error_covariance(
    conditions: tuple[Condition, ...],
    error: np.ndarray | ModelError,
    parts: np.ndarray,
    *,
    length: float = ERROR_LENGTH_SPEED,
) -> np.ndarray:
    """Return the covariance of the stacked lines' model error; arguments as of `error_blocks` and `stacked`."""
    return dense(np.broadcast_to(blocks := error_blocks(conditions, error, length=length), (2, *blocks.shape)), parts)


def similarity(conditions: tuple[Condition, ...], length: float = ERROR_LENGTH_SPEED) -> np.ndarray:
    """Return how alike the model errors in two conditions are, from 0 to 1, shape (conditions, conditions).

    ``length`` is the relative change of speed over which they change much.
    """
    speed = np.log([c.speed_rpm for c in conditions])
    distance = ((speed[:, None] - speed[None, :]) / length) ** 2
    loads = np.array([np.nan if c.load is None else c.load for c in conditions], dtype=float)
    span = np.nanmax(np.abs(loads)) if np.isfinite(loads).any() else 0.0
    if span > 0:
        change = (loads[:, None] - loads[None, :]) / (ERROR_LENGTH_LOAD * span)
        distance = distance + np.where(np.isfinite(change), change, 0.0) ** 2
    return np.exp(-0.5 * distance)


def model_error(lines: np.ndarray) -> np.ndarray:
    """Return the model error's standard deviation before any healthy line is seen, shape (probes, orders)."""
    return MODEL_ERROR * np.sqrt((np.abs(lines) ** 2).mean(axis=0) / 2)
