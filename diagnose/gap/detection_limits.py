"""What size of each effect the recordings would have shown, where they show none: what the answer "none" rests on.

A size shows where what it changes is worth `SHOWN` in d2, the squared length of its response in standard deviations of
all that is uncertain: noise, the machine's parameters, what the model misses. Motions that have to be simulated in time
are not asked: each size would be a simulation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...simulators.effect import effect_catalogue
from ...simulators.parameter import LogNormal
from .coordinates import FAR
from .evidence import Problem
from .hypotheses import Candidate
from .predict import UnpredictableError
from .responses import Responses
from .result import DetectionLimit, Estimate
from .words import parameter_label, value_words

#: Of single effects worth this much or more 50 of 55, 60 of 61 and 17 of 20 were named in trials (README, "Trials").
SHOWN = 100.0
#: The largest size asked, in standard coordinates, halvings of the interval to the smallest, and directions tried.
LARGEST, HALVINGS, DIRECTIONS = 3.0, 9, 8


def detection_limits(chosen: Sequence[Candidate], problem: Problem) -> tuple[DetectionLimit, ...]:
    """Return the limit of each strength that acts alone, other values being at the middle of their priors.

    Effects whose line lies where one was found are left out, and those whose motion does not repeat with the shaft.
    """
    found = []
    for one in chosen:
        if len(one.strengths) != 1 or one.placed:
            continue
        strength = one.coordinates[one.strengths[0]]
        size = _least_shown(one, problem)
        if not math.isnan(size):
            declared = strength.parameter
            found.append(DetectionLimit(one.name, one.effect.at, declared.name, declared.unit, size))
    return tuple(found)


def _least_shown(one: Candidate, problem: Problem) -> float:
    """Return the size from which a candidate shows; infinite where none does, NaN where that cannot be computed."""
    number = one.strengths[0]
    strength = one.coordinates[number]
    zero = strength.parameter.zero or 0.0
    smallest = -FAR if isinstance(strength.parameter.prior, LogNormal) else strength.coordinate(zero)
    shows = _Shown(one, problem)
    try:
        if not shows(LARGEST):
            return math.inf
        low, high = smallest, LARGEST
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (low, middle) if shows(middle) else (middle, high)
    except UnpredictableError:
        return math.nan
    return abs(strength.value(high) - zero)


class _Shown:
    """Whether a candidate shows, by the coordinate of its strength."""

    def __init__(self, one: Candidate, problem: Problem) -> None:
        self._one, self._compared = one, problem.plain()
        self._responses = Responses([one], problem.baseline.machine, problem.predictor)
        directions = DIRECTIONS if any(own.is_angle for own in one.coordinates) else 1
        self._angles = 2 * np.pi * np.arange(directions) / directions

    def __call__(self, coordinate: float) -> bool:
        position = np.zeros(len(self._one.coordinates))
        position[self._one.strengths[0]] = coordinate
        if not self._responses.repeats(position):
            raise UnpredictableError(f"{self._one} does not repeat with the shaft; no limit is computed.")
        parts = self._compared.whitening.of_orders(self._responses(position))
        turns = np.outer(self._angles, self._compared.lines.phase_orders)
        # In the direction in which it shows least, so that the limit holds in all.
        turned = np.cos(turns) @ parts[0] + np.sin(turns) @ parts[1]
        return bool((turned**2).sum(axis=1).min() >= SHOWN)


def limit_words(limits: Sequence[DetectionLimit]) -> list[str]:
    """Return remarks on the effects on the machine: from which size on each would have shown, and which show nowhere.

    Of each effect the first of its strengths that shows, at the part where it shows last.
    """
    catalogue = effect_catalogue()
    own = [one for one in limits if catalogue[one.effect].STAGE != "sensor"]
    shown, never = [], []
    for name in dict.fromkeys(one.effect for one in own):
        every = [one for one in own if one.effect == name]
        able = [one for one in every if math.isfinite(one.size)]
        spaced = name.replace("_", " ")
        if not able:
            never.append(spaced)
            continue
        last = max((one for one in able if one.parameter == able[0].parameter), key=lambda one: one.size)
        at = f" at {last.at}" if last.at else ""
        shown.append(f"{spaced}{at}, {parameter_label(last.parameter, last.unit)} {size_words(last)}")
        seen = {one.at for one in able}
        never += [f"{spaced} at {part}" for part in dict.fromkeys(one.at for one in every) if part not in seen]
    words = []
    if shown:
        words.append(
            f"From these sizes on they would have shown (all parts and strengths: report): {'; '.join(shown)}."
        )
    if never:
        words.append(f"Too weak in these recordings to show at any likely size: {', '.join(never)}.")
    return words


def size_words(limit: DetectionLimit) -> str:
    """Return the size in a readable unit."""
    return value_words(limit.size, Estimate(limit.size, limit.size, limit.size, limit.unit))
