"""Causes beside the weight of a machine that is given without it.

A machine whose stiffness is the same all round shows nothing of its weight, and is often modelled without. A shaft that
lies sags all the same: the weight opens and closes a crack once a turn, and a shaft that is not round makes 2X of it.
Whether it lies nobody here knows; each such effect competes in both ways.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...simulators.effect import Effect, SensorEffect, effect_catalogue
from ...simulators.machine import Machine
from .first_look import INVISIBLE, in_the_middle
from .hypotheses import Candidate
from .lacking_terms import acts
from .predict import Predictor, UnpredictableError
from .refine import Fit

#: A response that differs by this share of the larger one, at the middle of the prior, is another.
ANOTHER = 0.3


def beside_weight(
    competing: Sequence[Candidate], machine: Machine, predictor: Predictor, deviations: np.ndarray
) -> list[Candidate]:
    """Return the candidates that act otherwise once the machine has its weight, with that beside them.

    None where the machine has it, nor where the weight alone moves a line: then the healthy recordings tell it, or it
    competes by itself. Nor where a motion does not repeat with the shaft: each is a simulation.

    Parameters
    ----------
    machine : Machine
        Calibrated.
    predictor : Predictor
    deviations : ndarray (conditions, probes, orders)
        Of the lines' noise.
    """
    found = []
    for weight in _weights(machine):
        heavy = machine.with_effects(weight)
        if not predictor.repeats(heavy) or _differ(machine, heavy, predictor, deviations).any():
            continue
        acting = [one for one in competing if not isinstance(one.effect, SensorEffect)]
        both = [(one, replace(one, beside=(weight,))) for one in acting]
        both = [pair for pair in both if all(predictor.repeats(in_the_middle(one, machine)) for one in pair)]
        predictor.prepare([in_the_middle(one, machine) for pair in both for one in pair])
        base = predictor.amplitudes(machine)
        found += [laden for one, laden in both if _acts_otherwise(one, laden, machine, predictor, base)]
    return found


def weight_words(best: Fit) -> tuple[str, ...]:
    """Return a remark where causes are named beside a weight that the machine was given without."""
    named = [str(one).replace("_", " ") for one in best.candidates if one.beside]
    if not named:
        return ()
    return (
        f"The machine is given without weight, which its sound lines do not show. {' and '.join(named)} fits as in a "
        "shaft that lies: the extended machine has its weight. In a shaft that stands this is not the cause.",
    )


def _weights(machine: Machine) -> list[Effect]:
    """Return what acts on every machine of the kind, but not on this one as it is given."""
    there = {one.NAME for one in machine.effects}
    every = [kind() for kind in effect_catalogue().values() if kind.PERMANENT and kind.NAME not in there]
    return [one for one in every if acts(one, machine)]


def _differ(one: Machine, other: Machine, predictor: Predictor, deviations: np.ndarray) -> np.ndarray:
    """Return which lines of two machines are seen to differ; all where one has none that can be computed."""
    try:
        moved = predictor.amplitudes(one) - predictor.amplitudes(other)
    except UnpredictableError:
        return np.ones(deviations.shape, dtype=bool)
    return np.abs(moved) > INVISIBLE * deviations


def _acts_otherwise(one: Candidate, laden: Candidate, machine: Machine, predictor: Predictor, base: np.ndarray) -> bool:
    try:
        plain, heavy = (predictor.amplitudes(in_the_middle(each, machine)) - base for each in (one, laden))
    except UnpredictableError:
        return False
    larger = max(float(np.linalg.norm(plain)), float(np.linalg.norm(heavy)))
    return float(np.linalg.norm(plain - heavy)) > ANOTHER * larger
