"""Calibration from other starts, where the one from the machine as given leaves lines unexplained.

A resonance that lies at another speed than the model has it makes hills: steps by slopes fit its lines by damping it
away, or by moving all else, and end there. Machines drawn at random from their prior have resonances elsewhere; from
the few that come nearest, slopes lead on.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline, again, shifted
from .calibration import covariance_about, misfit, settled
from .healthy_evidence import is_explained
from .lines import OrderLines
from .model_error import model_error
from .predict import Predictor, UnpredictableError

#: Machines drawn, of these the ones that steps are made from, and how wide they are drawn, in standard deviations of
#: the prior: in so many dimensions whole ones are all far off.
DRAWS, FOLLOWED, WIDTH = 128, 3, 0.7
#: Steps from each, twice, as lines that are doubted anew lead off small hills; and the share of the first calibration's
#: squared residual that the best must be below to go on: of 27 starts of nine rigs the eleven that explained the lines
#: in the end were below 0.03 by then, and of the others ten above 0.15.
FIRST_STEPS, ROUNDS, FAR_CLOSER = 4, 2, 0.1
SEED = 2


def from_other_starts(
    found: Baseline,
    machine: Machine,
    healthy: OrderLines,
    predictor: Predictor,
    *,
    tell: Callable[[str], None] = lambda _: None,
) -> Baseline:
    """Return the machine calibrated from another start that explains its lines; as it was found where none does.

    Nor is another looked for where the lines are explained already, or where each start would be a simulation in time.
    One that leaves lines unexplained may be on any hill: likelier, and far off between the healthy speeds.

    Parameters
    ----------
    found : Baseline
        The machine as calibrated from where it is given.
    machine : Machine
        As given.
    healthy : OrderLines
    predictor : Predictor
        For their conditions.
    """
    if is_explained(found, healthy) or not predictor.repeats(machine):
        return found
    best, least = found, FAR_CLOSER * _missed(found, healthy)
    for number, one in enumerate(_nearest(found, machine, healthy, predictor)[:FOLLOWED]):
        tell(f"calibration from another start, {number + 1}")
        try:
            other = again(one, one.machine, predictor)
        except UnpredictableError:
            continue
        for _ in range(ROUNDS):
            other = settled(other, machine, healthy, predictor, most_steps=FIRST_STEPS)
        if is_explained(other, healthy):
            return other
        missed = _missed(other, healthy)
        best, least = (other, missed) if missed < least else (best, least)
    if best is found:
        return found
    other = settled(best, machine, healthy, predictor)
    return other if is_explained(other, healthy) else found


def _missed(one: Baseline, healthy: OrderLines) -> float:
    """Return the mean square of what a machine misses, in parts of what any may miss before a line is seen."""
    return misfit(one, healthy, covariance_about(one, healthy, model_error(one.lines)))


def _nearest(found: Baseline, machine: Machine, healthy: OrderLines, predictor: Predictor) -> list[Baseline]:
    """Return machines drawn from the prior, those that miss least first; the slopes are not theirs."""
    generator, drawn = np.random.default_rng(SEED), []
    for _ in range(DRAWS):
        move = WIDTH * generator.standard_normal(found.position.size)
        try:
            one = shifted(found, machine, found.given - found.position + np.where(found.active, move, 0.0), predictor)
        except UnpredictableError:
            continue
        drawn.append((_missed(one, healthy), len(drawn), one))
    return [one for _, _, one in sorted(drawn, key=lambda item: item[:2])]
