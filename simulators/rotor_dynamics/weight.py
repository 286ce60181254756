"""The weight of a machine: a constant force on every mass that can move up and down."""

from __future__ import annotations

from dataclasses import dataclass

from ..assembly import Assembly
from .harmonic_force import harmonic_force


@dataclass
class Weight:
    """Gravity on everything that has weight. A component, so that it also pulls at masses that effects add.

    The generalised force is -M v g with v the unit vertical translation (`Assembly.vertical`): for a finite-element
    shaft this includes the moments of the distributed weight.

    Parameters
    ----------
    name : str
    gravity_m_s2 : float
    """

    name: str
    gravity_m_s2: float
    roles: frozenset[str] = frozenset({"weight"})

    def finish(self, assembly: Assembly) -> None:
        """Add the weight as one constant force."""
        pull: dict[str, float] = {}
        for (row, column), mass in assembly.mass.items():
            if column in assembly.vertical:
                pull[row] = pull.get(row, 0.0) - mass * assembly.vertical[column]
        assembly.forces.append(harmonic_force(self.name, (pull,), order=0.0, cos=(self.gravity_m_s2,), sin=(0.0,)))
