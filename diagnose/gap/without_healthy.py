"""The machine and its tacho's pulse where only the lines to explain are there, and no healthy recording.

Taken to be at the machine's zero, a pulse that is not turns the machine's own lines, and an unbalance that turns them
back would be named on a sound machine. Where the machine with the pulse at another angle misses nothing, that is said,
and as likely as any cause. Where the machine by itself does not explain the lines, its parameters, calibrated all the
same, would make up for what is to be found: it is then taken as given.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline, start, widened_by, without_further
from .calibration import settled
from .healthy_evidence import WITHIN, whitened
from .lines import OrderLines
from .predict import Predictor
from .pulse_place import PLACE_GAIN, best_angle, placed_at, turned

#: By how much more than usual the model may be wrong where no healthy recording shows by how much it is: calibrated,
#: machines of other authors missed 0.1 to 7.5 % of their healthy lines, 3.6 % in the root mean square.
UNSEEN = 3.6
#: How exactly the tacho's pulse is put at the machine's zero, one standard deviation.
PULSE_RAD = 0.05
#: How often another place of the pulse is looked for.
ROUNDS = 2


@dataclass(frozen=True, eq=False)
class OnLines:
    """The machine by the lines to explain alone.

    Attributes
    ----------
    baseline : Baseline
        The machine to look for causes beside.
    elsewhere_rad : float
        Angle by which the machine has turned when the tacho's pulse comes, if that explains all lines; else 0.
    calibrated : Machine
        With its parameters where they explain most without any cause.
    """

    baseline: Baseline
    elsewhere_rad: float
    calibrated: Machine


def on_lines_to_explain(
    machine: Machine,
    lines: OrderLines,
    predictor: Predictor,
    *,
    tell: Callable[[str], None] = lambda _: None,
) -> OnLines:
    """Return the machine calibrated on the lines where it explains them, the pulse at its zero, and where else it does.

    Else as given; and calibrated, the pulse at the machine's zero, where each try is a simulation.

    Parameters
    ----------
    machine : Machine
        As given.
    lines : OrderLines
    predictor : Predictor
        For their conditions.
    """
    given = pulse_doubted(start(machine, predictor, tell=tell), predictor)
    found = settled(given, machine, lines, predictor, tell=tell)
    if not predictor.repeats(machine):
        return OnLines(without_further(found), 0.0, found.machine)
    _, white, straight = whitened(found, lines, UNSEEN)
    explained, elsewhere = _is_noise(white), 0.0
    least = straight + PLACE_GAIN if explained else -math.inf
    angle = best_angle(lines, predictor.amplitudes(machine))
    for _ in range(ROUNDS if all(one.tied for one in lines.conditions) else 0):
        other = placed_at(angle, machine, (), lines, predictor, tell=tell).at_healthy
        _, white, density = whitened(other, turned(lines, angle), UNSEEN)
        if _is_noise(white) and density > least:
            elsewhere = math.remainder(angle, 2 * math.pi)
            break
        angle = best_angle(lines, other.lines)
    return OnLines(without_further(found if explained else given), elsewhere, found.machine)


def pulse_doubted(baseline: Baseline, predictor: Predictor) -> Baseline:
    """Return a machine whose pulse may come a little before or after its zero; ``predictor`` is for its conditions."""
    tied = np.array([one.tied for one in predictor.conditions])[:, None, None]
    return widened_by(baseline, PULSE_RAD * 1j * predictor.phase_orders * np.where(tied, baseline.lines, 0.0)[None])


def _is_noise(white: np.ndarray) -> bool:
    """Return whether only noise is left, the model being as wrong as models are."""
    return float(white @ white) <= white.size + WITHIN * math.sqrt(2 * white.size)
