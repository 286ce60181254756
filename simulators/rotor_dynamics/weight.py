"""The weight of a machine's parts."""

from __future__ import annotations

from dataclasses import dataclass

from ..assembly import Assembly, MissingPartError
from .harmonic_force import harmonic_force


@dataclass
class Weight:
    """F = -g M v on everything that has weight. A component, so that masses that effects add are weighed too.

    Parameters
    ----------
    gravity_m_s2 : float
        g.
    """

    gravity_m_s2: float
    name: str = "weight"
    roles: frozenset[str] = frozenset({"weight"})

    def finish(self, assembly: Assembly) -> None:
        """Add one constant force whose shares are the parts' masses."""
        shares: dict[str, float] = {}
        for (row, column), mass in assembly.mass.items():
            if column in assembly.vertical:
                shares[row] = shares.get(row, 0.0) + mass * assembly.vertical[column]
        if not shares:
            raise MissingPartError("Nothing in this machine has weight (no vertical motion). Use another machine.")
        assembly.forces.append(harmonic_force(self.name, (shares,), order=0.0, cos=(-self.gravity_m_s2,), sin=(0.0,)))
