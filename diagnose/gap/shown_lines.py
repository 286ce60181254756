"""Whether the data show a single one of the lines that an effect states: one that shows none needs no simulation."""

from __future__ import annotations

import numpy as np

from ...simulators.effect import Effect
from ...simulators.errors import RotorwiseError
from ...simulators.machine import Machine
from .evidence import Comparison
from .hypotheses import Candidate
from .wanted_lines import MOST_OF_ONE, is_anywhere, is_locked, same_line

#: A line shows from this many standard deviations on, at any probe and in any condition.
SHOWN = 3.0
#: From so many on it is clear beyond the chance of the many lines compared.
CLEAR = 6.0
#: Of an effect's lines, which it states strongest first, one of so many has to show, or clearly one of the others that
#: are looked at.
STRONGEST = 2


def may_show(candidate: Candidate, machine: Machine, compared: Comparison) -> bool:
    """Return False for an effect all of whose lines lie beside the shaft's orders, when none of them has grown.

    Effects that state a line of the shaft's own orders, or none that is compared, are always looked at: what they do
    there depends on phases and on the machine. Not so one whose lines may lie at any frequency, where none was found.

    Parameters
    ----------
    candidate : Candidate
    machine : Machine
    compared : Comparison
        The lines to explain against what is expected without any effect.
    """
    # A strength that is absent may say where the lines of another lie, as the slip of a bearing does: they are looked
    # for where the whole effect states them, too.
    own, whole = candidate.effect, type(candidate.effect)(at=candidate.effect.at)
    return any(_has_grown(effect, machine, compared) for effect in {own, whole})


def _has_grown(effect: Effect, machine: Machine, compared: Comparison) -> bool:
    try:
        lines = effect.signature(machine)
    except RotorwiseError:
        return True
    if any(is_locked(line) for line in lines):
        return True
    lines = lines[:MOST_OF_ONE]
    speeds = [one.speed_rpm for one in compared.lines.conditions]
    size, compares = sigmas(compared).max(axis=(0, 1)), False
    for number, (order, kind) in enumerate(zip(compared.lines.orders, compared.lines.kinds, strict=True)):
        place = order, kind.frequency_hz
        stated = [same_line((abs(line.order), line.frequency_hz), place, speeds) for line in lines]
        if not kind.phase and any(stated):
            strongest = any(stated[:STRONGEST])
            compares |= strongest
            if size[number] > (SHOWN if strongest else CLEAR):
                return True
    # A line that may lie anywhere and was found nowhere is not there.
    return not compares and (not lines or not all(is_anywhere(effect, line) for line in lines))


def standing_out(compared: Comparison) -> tuple[tuple[float, float], ...]:
    """Return order and added frequency (0) of the lines with phase that clearly differ from what is expected."""
    lines, size = compared.lines, sigmas(compared).max(axis=(0, 1))
    both = zip(lines.orders, lines.kinds, size, strict=True)
    return tuple((order, 0.0) for order, kind, own in both if kind.phase and own > CLEAR)


def sigmas(compared: Comparison) -> np.ndarray:
    """Return each line's distance from what is expected, in standard deviations, shape (conditions, probes, orders).

    0 where a line is not seen.
    """
    lines = compared.lines
    variance = np.diag(compared.covariance)
    real, imaginary = lines.parts
    power = np.zeros(lines.seen.shape)
    power[real] = variance[: real.sum()]
    power[imaginary] += variance[real.sum() :]
    sigma = np.sqrt(power / np.maximum(real.astype(int) + imaginary, 1)) + 1e-300
    return np.where(lines.seen, np.abs(lines.amplitudes - compared.expected) / sigma, 0.0)
