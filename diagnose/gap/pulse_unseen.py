"""The tacho's pulse where no healthy recording tells its place: elsewhere, if that alone explains all lines.

Taken to be at the machine's zero, a pulse that is not turns the machine's own lines, and an unbalance that turns them
back would be named on a sound machine. Where the machine with the pulse at another angle misses nothing, nothing is
claimed: an unbalance of its own that points elsewhere looks the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline
from .healthy_evidence import WITHIN, whitened
from .lines import OrderLines
from .predict import Predictor
from .pulse_place import PLACE_GAIN, best_angle, placed_at, turned

#: By how much more than usual the model may be wrong where no healthy recording shows by how much it is: calibrated,
#: machines of other authors missed 0.1 to 7.5 % of their healthy lines, 3.6 % in the root mean square.
UNSEEN = 3.6
ROUNDS = 2


def pulse_elsewhere(
    found: Baseline,
    machine: Machine,
    lines: OrderLines,
    predictor: Predictor,
    *,
    tell: Callable[[str], None] = lambda _: None,
) -> tuple[Baseline, float]:
    """Return the machine calibrated with the pulse at another angle (rad), where it explains all lines then.

    As it was, with 0, where it explains them as well, or with no pulse elsewhere, or where each try is a simulation.

    Parameters
    ----------
    found : Baseline
        Calibrated on the lines with the pulse at the machine's zero.
    machine : Machine
        As given.
    lines : OrderLines
    predictor : Predictor
        For their conditions.
    """
    able = predictor.repeats(machine) and all(one.tied for one in lines.conditions)
    if not able:
        return found, 0.0
    _, white, straight = whitened(found, lines, UNSEEN)
    least = straight + PLACE_GAIN if _is_noise(white) else -math.inf
    angle = best_angle(lines, predictor.amplitudes(machine))
    for _ in range(ROUNDS):
        other = placed_at(angle, machine, (), lines, predictor, tell=tell).at_healthy
        _, white, density = whitened(other, turned(lines, angle), UNSEEN)
        if _is_noise(white) and density > least:
            return other, math.remainder(angle, 2 * math.pi)
        angle = best_angle(lines, other.lines)
    return found, 0.0


def _is_noise(white: np.ndarray) -> bool:
    """Return whether only noise is left, the model being as wrong as models are."""
    return float(white @ white) <= white.size + WITHIN * math.sqrt(2 * white.size)
