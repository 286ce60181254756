"""Where something unknown acts: at one place of the machine, or between the two halves of a coupling."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...simulators.machine import Machine
from .evidence import Comparison
from .force_kernels import ForceKernel, force_kernels, turning_kernels
from .force_transfer import places_across
from .judged import TOLD_APART
from .predict import Predictor
from .unknown_force import Unknown, gain_at_places
from .words import joined_words, line_names, mesh_orders


def places_of(compared: Comparison, unknown: Unknown, kernels: Sequence[ForceKernel]) -> dict[str, list[int]]:
    """Return the places at which forces describe an unexplained order clearly better than elsewhere, with the orders.

    Not there are orders that forces at several places together describe as well, or forces at places that the probes
    cannot tell apart.
    """
    found: dict[str, list[int]] = {}
    for order in unknown.kernels:
        gain = gain_at_places(compared, kernels, order)
        best = max(gain, key=lambda place: gain[place], default="")
        others = [own for place, own in gain.items() if place != best]
        if best and others and gain[best] > max(others) + math.log(TOLD_APART):
            found.setdefault(best, []).append(order)
    return found


def located_words(compared: Comparison, unknown: Unknown, machine: Machine, predictor: Predictor) -> list[str]:
    """Return in words where something unknown acts, a sentence for each place; none where that is not told.

    Parameters
    ----------
    compared : Comparison
        That something unknown is there was found in.
    unknown : Unknown
    machine : Machine
        Calibrated.
    predictor : Predictor
        For the conditions compared.
    """
    if not all(one.tied for one in predictor.conditions):
        return []
    # Forces that turn with the shaft have less freedom; where they are at several places, that is looked at as well.
    kernels = (*force_kernels(machine, predictor), *turning_kernels(machine, predictor))
    names, couplings = line_names(compared.lines, mesh_orders(machine)), {name for name, _ in places_across(machine)}
    hubs = {one.name for one in machine.bare_assembly().places.values() if "coupling" in one.roles}
    found = []
    for place, orders in places_of(compared, unknown, kernels).items():
        said = joined_words([names[order] for order in orders])
        if place in couplings:
            found.append(
                f"What is unknown in {said} acts between the two halves of the {place}: equal and opposite forces and "
                "moments there describe it clearly better than forces at any other place. A misaligned coupling pushes "
                "so, by whatever law: check its alignment, cold and hot."
            )
        else:
            hub = " A misaligned coupling pushes so: check its alignment, cold and hot." if place in hubs else ""
            found.append(
                f"What is unknown in {said} acts at {place}: forces there describe it clearly better than forces at "
                f"any other place.{hub}"
            )
    return found
