"""Where the machine's own unbalance points: a model's angle of it is a guess, a real rotor's is what balancing left.

The pulse's place and the unbalance's direction both turn 1X. Other lines with a phase (2X of a coupling, gravity) turn
with the pulse alone, and by another multiple: they part the two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.machine import Machine
from ...simulators.parameter import Parameter, Uniform
from .coordinates import Coordinate
from .predict import Predictor, UnpredictableError

#: A part of the lines belongs to a force that an angle turns where its two components add up, to this share.
ADDS_UP = 0.02
#: An unbalance that makes a smaller share of the lines with phase is of no use here.
LEAST_SHARE = 0.3


@dataclass(frozen=True, eq=False)
class OwnUnbalance:
    """A part of a machine's lines that belongs to a force which an angle among its parameters turns.

    Attributes
    ----------
    angle : Parameter
    lines, across : ndarray (conditions, probes, orders), complex
        What it makes at the angle that the machine has, and a quarter turn further. On a shaft whose stiffness turns
        with it, that is more than another phase.
    """

    angle: Parameter
    lines: np.ndarray
    across: np.ndarray

    def turned_in(self, machine: Machine, by_rad: float) -> Machine:
        """Return the machine with this unbalance turned further."""
        value = math.remainder(machine.values[self.angle.name] + by_rad, 2 * math.pi)
        return machine.with_parameters(**{self.angle.name: value})

    @property
    def coordinate(self) -> Coordinate:
        """The angle as an unknown of the machine: any direction is as likely."""
        return Coordinate(replace(self.angle, prior=Uniform(-math.pi, math.pi)))


def own_unbalance(machine: Machine, predictor: Predictor) -> OwnUnbalance | None:
    """Return the part of a machine's lines that its own unbalance makes; None where that is little or does not turn."""
    if not predictor.repeats(machine):
        return None
    angles = [p for p in machine.definition.parameters if p.unit == "rad"]
    round_the_shaft = [p for p in angles if p.bounds[0] <= -math.pi and p.bounds[1] >= math.pi]
    found = [one for one in (_turning(machine, angle, predictor) for angle in round_the_shaft) if one is not None]
    return max(found, key=lambda one: one[1], default=(None, 0.0))[0]


def _turning(machine: Machine, angle: Parameter, predictor: Predictor) -> tuple[OwnUnbalance, float] | None:
    """Return what an angle turns, and its share of the lines with phase; None if that is little or does not add up."""
    eighth, quarter, half = (
        machine.with_parameters(**{angle.name: math.remainder(machine.values[angle.name] + by, 2 * math.pi)})
        for by in (math.pi / 4, math.pi / 2, math.pi)
    )
    try:
        predictor.prepare([machine, eighth, quarter, half])
        here, between, beside, opposite = (predictor.amplitudes(one) for one in (machine, eighth, quarter, half))
    except UnpredictableError:
        return None
    own, rest = (here - opposite) / 2, (here + opposite) / 2
    across = beside - rest
    with_phase = predictor.phase_orders > 0
    # Displacements and accelerations count alike.
    size = np.sqrt((np.abs(here[..., with_phase]) ** 2).mean(axis=(0, 2), keepdims=True)) + 1e-300

    def share(lines: np.ndarray) -> float:
        return float(
            np.linalg.norm(lines[..., with_phase] / size) / max(np.linalg.norm(here[..., with_phase] / size), 1e-300)
        )

    adds_up = share(between - rest - (own + across) / math.sqrt(2)) < ADDS_UP
    return (OwnUnbalance(angle, own, across), share(own)) if adds_up and share(own) > LEAST_SHARE else None
