"""How a candidate's response changes with its values: in proportion to a strength, only turned by an angle, hardly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .first_look import moved_to
from .hypotheses import Candidate
from .predict import UnpredictableError
from .responses import Responses

#: Levels of a value that is neither strength nor angle.
SHAPE_LEVELS = 3
#: Parts of a turn at which an angle is tried: no multiple of one is a multiple of the others.
TRIED_ANGLES = (0.0, 0.17, 0.39)
#: A parameter that changes the response by a smaller share over its whole prior is left at its middle.
MATTERS = 0.2
#: Relative error up to which a response counts as proportional to its strength, or as turned by its angle.
CLOSE = 0.05
#: Share of the clearest probe's response below which another probe's is not asked: rounding, and what leaks from a
#: record's ends, follow no law.
LEAST = 1e-2


@dataclass(frozen=True, eq=False)
class ResponseShape:
    """A candidate's response about one position.

    Attributes
    ----------
    candidate : Candidate
    response : Responses
        Of the candidate alone.
    centre : ndarray (coordinates,)
    first : ndarray (conditions, probes, orders), complex
        Response there.
    deviations : ndarray (conditions, probes, orders), optional
        Of the lines' noise, in which probes of any unit compare.
    """

    candidate: Candidate
    response: Responses
    centre: np.ndarray
    first: np.ndarray
    deviations: np.ndarray | None = None

    def matters(self, number: int) -> bool:
        """Return whether the response changes much over a parameter's prior.

        Where it cannot be computed at an end, the parameter matters.
        """
        one = self.candidate.coordinates[number]
        if one.is_angle:
            places = [one.at_share(share) for share in TRIED_ANGLES]
        else:
            places = one.quantiles(SHAPE_LEVELS)[:: SHAPE_LEVELS - 1]
        try:
            found = [self.response(moved_to(self.centre, [number], [place])) for place in places]
        except UnpredictableError:
            return True
        return any(self._away(other, found[0]) > MATTERS for other in found[1:])

    def only_turns(self, number: int) -> bool:
        """Return whether an angle shifts the phase of each order by as many times itself, and does nothing else."""
        found = self.response(moved_to(self.centre, [number], [self.centre[number] + 1.0]))
        return self._away(found, self.first * np.exp(1j * self.response.orders)) < CLOSE

    def is_proportional(self, moving: Sequence[int]) -> bool:
        """Return whether the response doubles with these strengths, or halves where a bound forbids doubling."""
        for factor in (2.0, 0.5):
            scaled = scaled_strengths(self.candidate, self.centre, moving, factor)
            if scaled is not None:
                return self._away(self.response(scaled), factor * self.first) < CLOSE
        return False

    def _away(self, found: np.ndarray, wanted: np.ndarray) -> float:
        """Return the largest relative difference over the probes."""
        weight = np.ones(wanted.shape) if self.deviations is None else 1 / self.deviations
        size = np.sqrt((np.abs(weight * wanted) ** 2).sum(axis=(0, 2)))
        away = np.sqrt((np.abs(weight * (found - wanted)) ** 2).sum(axis=(0, 2)))
        return float((away / np.maximum(size, LEAST * size.max() + 1e-300)).max())


def scaled_strengths(
    candidate: Candidate, position: np.ndarray, moving: Sequence[int], factor: float
) -> np.ndarray | None:
    """Return the position where the strengths are ``factor`` times as large; None where a bound forbids it."""
    values = []
    for i in moving:
        one = candidate.coordinates[i]
        zero = one.parameter.zero or 0.0
        wanted = zero + factor * (one.value(position[i]) - zero)
        values.append(one.coordinate(wanted))
        if abs(one.value(values[-1]) - wanted) > 1e-3 * abs(wanted - zero):
            return None
    return moved_to(position, moving, values)
