"""Which lines to look at: those that the shaft shows, and those that any effect of the catalogue says it makes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...simulators.effect import Effect, Line, effect_catalogue
from ...simulators.errors import InvalidValueError, RotorwiseError
from ...simulators.machine import Machine
from .line_sizes import HALVES_TO, WANDER, least_seconds
from .lines import Condition, LineKind

#: Always looked at: what shafts show, and the half orders of a nonlinear support.
USUAL_ORDERS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
#: Orders that are multiples of this fraction of a turn keep their phase to the shaft.
LOCKED_FRACTION = 1 / 6
#: Lines of one effect that are looked at, its strongest first, beside those that keep their phase.
MOST_OF_ONE = 3
#: Lines closer than this share of their order are one.
SAME = 0.01
#: Parts whose defects are struck rhythms: their lines stand clearest in the envelope's spectrum.
STRUCK = ("bearing",)

Wanted = tuple[tuple[float, ...], tuple[LineKind, ...]]


def wanted_lines(machine: Machine, *, highest: float, speeds_rpm: Sequence[float]) -> Wanted:
    """Return orders and kinds of the lines to look at.

    Lines with phase are the usual orders and the phase-locked lines that effects state, up to ``highest``. Of all other
    lines that effects state only the size is looked at: above that order a small error of the tacho's place spoils the
    phase, and lines beside the shaft's orders have none.

    Parameters
    ----------
    machine : Machine
    highest : float
        Highest order with phase.
    speeds_rpm : sequence of float
        That will be looked at: lines at fixed frequencies must not coincide with others there.

    Raises
    ------
    InvalidValueError
        Without speeds: all lines would lie together.
    """
    if not speeds_rpm:
        raise InvalidValueError("No speed; allowed: one or more. Give the speeds that will be looked at.")
    stated = _stated(machine)
    locked = set(USUAL_ORDERS)
    for _, lines in stated:
        locked |= {line.order for line in lines if is_locked(line) and line.order <= highest + 1e-9}
    orders = sorted(round(order, 6) for order in locked if 0 < order <= highest + 1e-9)
    sizes: list[tuple[float, LineKind]] = []
    for effect, lines in stated:
        free = [line for line in lines if not is_locked(line) or line.order > highest][:MOST_OF_ONE]
        free = [line for line in free if not is_anywhere(effect, line)]
        for line in free:
            one = size_line(type(effect), line)
            if not any(_alike(one, other, speeds_rpm) for other in sizes):
                sizes.append(one)
    sizes.sort(key=lambda one: (one[1].envelope, one[1].frequency_hz, one[0]))
    kinds = (LineKind(),) * len(orders) + tuple(kind for _, kind in sizes)
    return (*orders, *(order for order, _ in sizes)), kinds


def _stated(machine: Machine) -> list[tuple[Effect, tuple[Line, ...]]]:
    """Return the lines that each effect states at each of its places: those of a gear go by its own shaft."""
    found = []
    for _, effect in sorted(effect_catalogue().items()):
        places = [effect(at=at) for at in parts_of(machine, effect)]
        try:
            places[0].contribute(machine.bare_assembly())
            found += [(one, one.signature(machine)) for one in places]
        except RotorwiseError:
            continue
    return found


def parts_of(machine: Machine, effect: type[Effect]) -> list[str]:
    """Return the names of the parts of a machine that an effect may act at; one empty name where it needs none.

    Of parts that share the effect only the first.
    """
    assembly = machine.bare_assembly()
    parts = [*assembly.places.values(), *assembly.components.values()]
    names = list(dict.fromkeys(part.name for part in parts if effect.ROLE in part.roles)) or [""]
    return names[:1] if effect.SHARED else names


def is_anywhere(effect: Effect, line: Line) -> bool:
    """Return whether a line lies at a frequency that the effect is free to choose: it is found, not looked for."""
    values = effect.values()
    return not line.order and any(
        one.unit == "Hz" and one.prior is not None and values[one.name] == abs(line.frequency_hz)
        for one in effect.parameters()
    )


def _alike(one: tuple[float, LineKind], other: tuple[float, LineKind], speeds_rpm: Sequence[float]) -> bool:
    if one[1].envelope != other[1].envelope:
        return False
    # A line of the spectrum is as wide as it wanders: 1 % of a mesh would hold the sidebands of a gear's own speed.
    within = SAME if one[1].envelope else WANDER
    return same_line((one[0], one[1].frequency_hz), (other[0], other[1].frequency_hz), speeds_rpm, within=within)


def same_line(
    one: tuple[float, float], other: tuple[float, float], speeds_rpm: Sequence[float], *, within: float = SAME
) -> bool:
    """Return whether two lines, each an order and a frequency in Hz added to it, lie together at all the speeds.

    ``within`` is the share of their order by which they may differ.
    """
    places = [[abs(order + 60 * added / speed) for order, added in (one, other)] for speed in speeds_rpm]
    return all(abs(a - b) <= within * max(a, b) for a, b in places)


def size_line(effect: type[Effect], line: Line) -> tuple[float, LineKind]:
    """Return a line that an effect states as one of which the size is looked at: its order and its kind."""
    return abs(line.order), LineKind(phase=False, envelope=effect.ROLE in STRUCK, frequency_hz=line.frequency_hz)


def is_locked(line: Line) -> bool:
    """Return whether a line keeps its phase to the shaft."""
    turns = line.order / LOCKED_FRACTION
    return line.frequency_hz == 0 and abs(turns - round(turns)) < 1e-6


def unstated_beside(machine: Machine, orders: Sequence[float], kinds: Sequence[LineKind]) -> np.ndarray:
    """Return which lines stand a few Hz beside an order that is not taken off first (a gear mesh), shape (orders,).

    None where some effect of the machine states lines at a fixed distance from an order.
    """
    away = [kind.frequency_hz != 0 and not kind.envelope for kind in kinds]
    found = np.array(away, dtype=bool) & (np.array(orders) > HALVES_TO)
    if not found.any():
        return found
    stated = [line for effect in machine.effects for line in effect.signature(machine)]
    return found & (not any(line.order and line.frequency_hz for line in stated))


def least_lengths(machine: Machine, conditions: Sequence[Condition]) -> tuple[float, ...]:
    """Return for each condition how long (s) a record must be for the lines that the machine's effects state."""
    stated = [(type(effect), line) for effect in machine.effects for line in effect.signature(machine)]
    sizes = [size_line(effect, line) for effect, line in stated if not is_locked(line)]
    speeds = [condition.speed_rpm / 60 for condition in conditions]
    return tuple(max((least_seconds(*one, speed) for one in sizes), default=0.0) for speed in speeds)
