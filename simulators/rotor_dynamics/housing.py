"""Bearing housing as a chain of masses: each stage stands on the one below it and brings one mode a direction.

The lowest stage is the body that holds the bearing's outer ring; its spring stands for pedestal and bolts. The stages
above it are the cap and whatever the accelerometer sits on. In each direction stage i is held by

    k_i = (m_i + m_{i+1} + ...) (2 pi f_i)^2,     c_i = 2 zeta_i k_i / (2 pi f_i),

so that f_i is the natural frequency of stage i with everything above it rigid and everything below it at rest: what an
impact test of that part alone would show. The coupled frequencies differ (for two stages their product is f_1 f_2
times sqrt(1 + m_2 / m_1)).

Source: chain of oscillators as in any textbook (e.g. J. P. Den Hartog, "Mechanical Vibrations", 4th ed., McGraw-Hill
1956, section 3.2); the numbers belong to the machine.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..assembly import Assembly, difference
from ..errors import InvalidValueError
from ..law import Direction
from .shaft_parts import require_positive
from .support import Support

#: Directions in which a housing moves.
DIRECTIONS = ("x", "y", "axial")


@dataclass(frozen=True)
class HousingStage:
    """One mass of a housing, with its own natural frequency in each direction.

    Parameters
    ----------
    mass_kg : float
        Above 0.
    frequency_hz : mapping of str to float
        Natural frequency f_i in "x", "y" and "axial", above 0.
    damping_ratio : float
        zeta_i, the same in all directions, at least 0.
    """

    mass_kg: float
    frequency_hz: Mapping[str, float]
    damping_ratio: float

    def __post_init__(self) -> None:
        require_positive("Mass of a housing's stage in kg", self.mass_kg)
        for direction in DIRECTIONS:
            if direction not in self.frequency_hz:
                raise InvalidValueError(
                    f"Housing stage with frequencies {dict(self.frequency_hz)}; allowed: one for each of "
                    f"{', '.join(DIRECTIONS)}. Add {direction!r}."
                )
            require_positive(f"Frequency of a housing's stage in {direction} in Hz", self.frequency_hz[direction])
        if not 0.0 <= self.damping_ratio < math.inf:
            raise InvalidValueError(f"Damping ratio {self.damping_ratio}; allowed: at least 0. 0.02 is 2 %.")

    def stiffness_n_m(self, direction: str, *, carried_kg: float) -> float:
        """Return k_i in N/m for this stage with ``carried_kg`` on top of it."""
        return (self.mass_kg + carried_kg) * (2 * math.pi * self.frequency_hz[direction]) ** 2

    def damping_n_s_m(self, direction: str, *, carried_kg: float) -> float:
        """Return c_i in N.s/m for this stage with ``carried_kg`` on top of it."""
        mass = self.mass_kg + carried_kg
        return 2 * self.damping_ratio * mass * 2 * math.pi * self.frequency_hz[direction]


def add_housing(
    assembly: Assembly, name: str, *, base: Mapping[str, Direction], stages: Sequence[HousingStage]
) -> tuple[dict[str, dict[str, float]], ...]:
    """Add a housing to an assembly and return the motion of each stage, from the lowest to the highest.

    The spring of the lowest stage in x and y is a `Support` named "<name> pedestal", which effects may change.

    Parameters
    ----------
    assembly : Assembly
    name : str
        Its coordinates are "<name>_1.x", "<name>_1.y", "<name>_1.axial", "<name>_2.x", ...
    base : mapping of str to Direction
        Motion, by direction, of the point on which the housing stands; an empty mapping is rigid ground.
    stages : sequence of HousingStage
        At least one, from below.

    Returns
    -------
    tuple of mapping
        For each stage the directions "x", "y" and "axial".
    """
    if not stages:
        raise InvalidValueError(f"Housing {name} has 0 stages; allowed: at least 1. Give a list of HousingStage.")
    below: Mapping[str, Direction] = base
    motions = []
    for number, stage in enumerate(stages, start=1):
        motion = {direction: {f"{name}_{number}.{direction}": 1.0} for direction in DIRECTIONS}
        for direction in DIRECTIONS:
            assembly.add_coordinate(f"{name}_{number}.{direction}", mass=stage.mass_kg, vertical=direction == "y")
        along = {direction: difference(motion[direction], below.get(direction, {})) for direction in DIRECTIONS}
        carried = sum(other.mass_kg for other in stages[number:])
        _add_springs(assembly, f"{name} pedestal" if number == 1 else "", along, stage, carried)
        motions.append(motion)
        below = motion
    return tuple(motions)


def _add_springs(
    assembly: Assembly, support: str, along: Mapping[str, Direction], stage: HousingStage, carried_kg: float
) -> None:
    """Add one stage's springs; with a name, those in x and y as a component of that name."""
    stiffness = {d: stage.stiffness_n_m(d, carried_kg=carried_kg) for d in DIRECTIONS}
    damping = {d: stage.damping_n_s_m(d, carried_kg=carried_kg) for d in DIRECTIONS}
    plain = DIRECTIONS
    if support:
        pedestal = Support(
            name=support,
            along_x=along["x"],
            along_y=along["y"],
            stiffness_x_n_m=stiffness["x"],
            stiffness_y_n_m=stiffness["y"],
            damping_x_n_s_m=damping["x"],
            damping_y_n_s_m=damping["y"],
        )
        assembly.add_component(pedestal)
        plain = ("axial",)
    for direction in plain:
        assembly.add_spring(along[direction], stiffness=stiffness[direction], damping=damping[direction])
