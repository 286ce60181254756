"""Influence coefficient: how a trial unbalance moves 1X at one speed (ISO 21940-31; Darlow 1989, chapter 3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...simulators.errors import InvalidValueError


@dataclass(frozen=True)
class Influence:
    """A linear law: response = before + coefficient * unbalance.

    Attributes
    ----------
    coefficient : complex
        Response per kg.m.
    deviation : float
        Its standard deviation, of real and imaginary part together; NaN where nothing was repeated.
    before : complex
        Response without any trial unbalance.
    """

    coefficient: complex
    deviation: float
    before: complex

    @property
    def correction_kg_m(self) -> complex:
        """The unbalance that takes the response away."""
        return -self.before / self.coefficient


def influence_coefficient(unbalance_kg_m: np.ndarray, response: np.ndarray) -> Influence:
    """Return the influence coefficient by least squares over runs with and without trial unbalances.

    Parameters
    ----------
    unbalance_kg_m : ndarray (runs,), complex
        Size and angle on the shaft; 0 for a run without.
    response : ndarray (runs,), complex
        1X at one probe and one speed, phases against the same mark.

    Raises
    ------
    InvalidValueError
        For values that do not match or are not finite, or when all runs have the same unbalance.
    """
    trial, seen = np.asarray(unbalance_kg_m, dtype=complex), np.asarray(response, dtype=complex)
    if trial.ndim != 1 or trial.shape != seen.shape or not (np.isfinite(trial) & np.isfinite(seen)).all():
        raise InvalidValueError(
            f"{trial.shape} unbalances and {seen.shape} responses; allowed: one finite response for each unbalance."
        )
    spread = trial - trial.mean() if trial.size else trial
    power = float((np.abs(spread) ** 2).sum())
    if not power:
        raise InvalidValueError(
            f"All {trial.size} runs have the same unbalance; allowed: two different ones or more. Add a trial run."
        )
    slope = complex((spread.conj() * seen).sum() / power)
    before = complex(seen.mean() - slope * trial.mean())
    left = float((np.abs(seen - before - slope * trial) ** 2).sum())
    deviation = math.sqrt(left / (trial.size - 2) / power) if trial.size > 2 else math.nan
    return Influence(slope, deviation, before)
