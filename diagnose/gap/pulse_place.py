"""Where the tacho's pulse sits on the shaft: a reflective mark or a keyway stands anywhere, a model's angles do not.

A pulse at another angle than the model's zero turns the phase of order k by k times that angle, at every probe and in
every condition, healthy or not. The healthy recordings tell the angle where the machine itself makes lines with a phase
(its residual unbalance, gravity, its coupling); without such lines, or without healthy recordings, it is taken to be 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...simulators.machine import Machine
from .baseline import Baseline, model_error
from .calibration import calibrated, objective
from .coordinates import Coordinate
from .lines import OrderLines
from .predict import Predictor

#: Angles that are tried round the shaft.
ANGLES = np.linspace(-np.pi, np.pi, 720, endpoint=False)
#: By which share the machine as given may miss its lines: a line weighs no more than its square allows.
MISSED = 0.3
#: The turned lines must agree better by so much before anything is computed, and after the calibration by so much in
#: the logarithm of the posterior: an angle out of a full turn has to be paid for.
CLEARLY, LEAST_GAIN = 20.0, 10.0
ROUNDS = 3


def calibrated_with_pulse(
    machine: Machine,
    healthy: OrderLines,
    predictor: Predictor,
    added: Sequence[Coordinate] = (),
    *,
    tell: Callable[[str], None] = lambda _: None,
) -> tuple[Baseline, float]:
    """Return the calibrated machine and the angle (rad) by which it has turned when the pulse comes.

    Parameters
    ----------
    machine : Machine
    healthy : OrderLines
    predictor : Predictor
        For the healthy conditions.
    added : sequence of Coordinate
        Of effects that the machine is given with.
    """
    plain = calibrated(machine, healthy, predictor, added, tell=tell)
    given = predictor.amplitudes(machine)
    angle = _best_angle(healthy, given)
    if _agreement(healthy, given, np.array([angle, 0.0])) @ [1, -1] < CLEARLY:
        return plain, 0.0
    best, kept = _power(plain, healthy), (plain, 0.0)
    for _ in range(ROUNDS):
        tell(f"calibration with the pulse at {np.degrees(angle):.0f} deg")
        here = turned(healthy, angle)
        found = calibrated(machine, here, predictor, added, tell=tell)
        if _power(found, here) > best - LEAST_GAIN * (kept[1] == 0.0):
            break
        best, kept = _power(found, here), (found, angle)
        angle = _best_angle(healthy, found.lines)
    return kept


def turned(lines: OrderLines, angle_rad: float) -> OrderLines:
    """Return lines whose phase is counted from the machine's zero instead of the pulse.

    Conditions that are not tied to the shaft's angle stay as they are.
    """
    factor = np.exp(-1j * lines.phase_orders * angle_rad)
    tied = np.array([one.tied for one in lines.conditions])[:, None, None]
    return replace(lines, amplitudes=lines.amplitudes * np.where(tied, factor, 1.0))


def _best_angle(lines: OrderLines, expected: np.ndarray) -> float:
    return float(ANGLES[np.argmax(_agreement(lines, expected, ANGLES))])


def _agreement(lines: OrderLines, expected: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return how well the phases agree when the lines are turned by each of some angles, shape (angles,)."""
    tied = np.array([one.tied for one in lines.conditions])[:, None, None]
    used = lines.seen & tied & (lines.phase_orders > 0)
    size = np.maximum(np.abs(lines.amplitudes), np.abs(expected))
    variance = np.where(used, lines.deviations, 1.0) ** 2 + (MISSED * size) ** 2
    product = np.where(used, lines.amplitudes * expected.conj() / np.maximum(variance, 1e-300), 0.0).sum(axis=(0, 1))
    return np.real(np.exp(-1j * np.outer(angles, lines.phase_orders)) @ product)


def _power(current: Baseline, healthy: OrderLines) -> float:
    return objective(current, healthy, model_error(current.lines))
