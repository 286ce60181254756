"""The machine as its healthy recordings show it: calibrated, the pulse placed, what the model lacks added."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from ...simulators.machine import Machine
from .baseline import Baseline
from .calibration_starts import from_other_starts
from .form_error import FormErrors, form_errors
from .healthy_evidence import evidence, is_explained
from .lines import OrderLines
from .model_form import Extended, extended
from .predict import Predictor
from .pulse_place import PLACE_GAIN, Placed, is_better, placed_at, placings, turn_nearby, turned

#: How often a place of the pulse is looked for once more when what the model lacks has been added.
ROUNDS = 2
#: A calibrated machine, and what was added to it.
_Grown = tuple[Placed, Extended | None]


@dataclass(frozen=True, eq=False)
class HealthyMachine:
    """What healthy recordings say of a machine.

    Attributes
    ----------
    at_healthy : Baseline
        Calibrated.
    pulse_rad : float
        Angle by which the machine has turned when the tacho's pulse comes.
    form : Extended or None
        What the model lacks; None where that was not looked for.
    errors : FormErrors or None
        What it lacks besides, by its shape.
    """

    at_healthy: Baseline
    pulse_rad: float
    form: Extended | None
    errors: FormErrors | None


def healthy_machine(
    machine: Machine,
    healthy: OrderLines,
    predictor: Predictor,
    *,
    reference_rpm: float,
    as_given: bool = False,
    tell: Callable[[str], None] = lambda _: None,
) -> HealthyMachine:
    """Return the machine as its healthy lines show it.

    Parameters
    ----------
    machine : Machine
    healthy : OrderLines
        As observed.
    predictor : Predictor
        For their conditions.
    reference_rpm : float
        Highest speed of all recordings.
    as_given : bool
        Do not add what the model lacks.
    """

    def grown(placed: Placed, known: float = -math.inf) -> _Grown:
        if as_given:
            return placed, None
        here = turned(healthy, placed.pulse_rad)
        form = extended(placed, here, predictor, reference_rpm=reference_rpm, known=known, tell=tell)
        return replace(placed, at_healthy=form.at_healthy, evidence=evidence(form.at_healthy, here)), form

    # Of a machine that does not repeat only 1X and its multiples have a phase, and the terms that it gets, run-outs and
    # unbalances that may point anywhere, make these with the pulse at any place.
    able = predictor.repeats(machine) or as_given
    places = placings(machine, healthy, predictor, tell=tell) if able else []
    places = places or [placed_at(0.0, machine, (), healthy, predictor, tell=tell)]
    nearest = max(places, key=lambda one: one.evidence)
    places = [_calibrated_anew(one, healthy, predictor, tell) if one is nearest else one for one in places]
    if able and not as_given:
        # Before anything is added: forces that turn with the shaft would make up for a pulse that sits elsewhere.
        places += _turned_on(max(places, key=lambda one: one.evidence), healthy, predictor, reference_rpm, tell)
    best = _likeliest(places, grown, healthy)
    for _ in range(ROUNDS if able else 0):
        placed = best[0]
        here = turned(healthy, placed.pulse_rad)
        turn = turn_nearby(placed.at_healthy, here, predictor, reference_rpm=reference_rpm)
        if not turn:
            break
        angle = math.remainder(placed.pulse_rad + turn, 2 * math.pi)
        other = grown(placed_at(angle, placed.machine, placed.free, healthy, predictor, tell=tell))
        if _worth(other) <= _worth(best) + (PLACE_GAIN if placed.pulse_rad == 0.0 else 0.0):
            break
        best = other
    placed, form = best
    here = turned(healthy, placed.pulse_rad)
    errors = None if as_given else form_errors(placed.at_healthy, here, predictor, reference_rpm=reference_rpm)
    return HealthyMachine(placed.at_healthy, placed.pulse_rad, form, errors)


def _turned_on(
    placed: Placed, healthy: OrderLines, predictor: Predictor, reference_rpm: float, tell: Callable[[str], None]
) -> list[Placed]:
    """Return the place of the pulse nearby at which the machine as it is makes the lines likelier, if there is one."""
    here = turned(healthy, placed.pulse_rad)
    turn = turn_nearby(placed.at_healthy, here, predictor, reference_rpm=reference_rpm)
    if not turn:
        return []
    angle = math.remainder(placed.pulse_rad + turn, 2 * math.pi)
    other = placed_at(angle, placed.machine, placed.free, healthy, predictor, tell=tell)
    return [other] if is_better(other, placed) else []


def _calibrated_anew(placed: Placed, healthy: OrderLines, predictor: Predictor, tell: Callable[[str], None]) -> Placed:
    """Return a place of the pulse with the machine calibrated from other starts, where it was not explained."""
    here = turned(healthy, placed.pulse_rad)
    found = from_other_starts(placed.at_healthy, placed.machine, here, predictor, tell=tell)
    return replace(placed, at_healthy=found, evidence=evidence(found, here))


def _likeliest(places: Sequence[Placed], grown: Callable[[Placed, float], _Grown], healthy: OrderLines) -> _Grown:
    """Return the likeliest place of the pulse, the machine having what it lacks there.

    How far behind one is before says little: the machine's own unbalance pointing elsewhere alone leaves most of the
    lines. Where one has it and misses nothing, there is no reason to look at others.
    """
    known: dict[Placed, _Grown] = {}
    for one in sorted(places, key=lambda one: -one.evidence):
        known[one] = grown(one, max((other.evidence for other, _ in known.values()), default=-math.inf))
        if is_explained(known[one][0].at_healthy, turned(healthy, one.pulse_rad)):
            break
    # Each further guess has to be clearly likelier than those with less freedom.
    best, *others = (known[one] for one in places if one in known)
    for other in others:
        best = other if _worth(other) > _worth(best) + PLACE_GAIN else best
    return best


def _worth(grown: _Grown) -> float:
    """Return the evidence less what the added terms had to bring: with enough forces the pulse may sit anywhere."""
    placed, form = grown
    return placed.evidence - (form.price if form else 0.0)
