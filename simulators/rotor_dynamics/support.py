"""A support of a shaft or housing: springs and dampers in x and y that effects may change."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from ..assembly import Assembly, MissingPartError
from ..effect import Line
from ..errors import InvalidValueError
from ..law import Direction
from .harmonic_force import harmonic_force

#: A joint without static load still beds down over this force.
LEAST_ROUNDING_N = 1.0


@dataclass
class Support:
    """Linear spring and damper in x and in y: F = -k d - c d'. A component with the role "support".

    Parameters
    ----------
    name : str
    along_x, along_y : Direction
        Elongation in x and in y: {"rotor.x": 1} against the ground, {"rotor.x": 1, "housing.x": -1} between parts.
    stiffness_x_n_m, stiffness_y_n_m : float
        N/m.
    damping_x_n_s_m, damping_y_n_s_m : float
        N.s/m.
    roles : frozenset of str
    """

    name: str
    along_x: Direction
    along_y: Direction
    stiffness_x_n_m: float
    stiffness_y_n_m: float
    damping_x_n_s_m: float = 0.0
    damping_y_n_s_m: float = 0.0
    roles: frozenset[str] = frozenset({"support"})
    #: Loss, hold and rounding of each `loosen`.
    _loose: list[tuple[float, float, float]] = field(default_factory=list)
    _drawn_down_m: list[float] = field(default_factory=list)

    def loosen(self, *, loss: float, hold: float, rounding: float) -> None:
        """Take the part ``loss`` of the vertical stiffness away when the support is pulled from where it rests.

        Of several loosenings each takes its part of what the others leave.

        Parameters
        ----------
        loss : float
            From 0 to 1.
        hold : float
            Share of the machine's static load that must be overcome before the joint opens: 0 for a foot that just
            touches, 1 for one that stands by its load, more where bolts still help, negative for one with a gap.
        rounding : float
            The corner is rounded over this share of the static load (at least `LEAST_ROUNDING_N`) to both sides.
        """
        if not (0.0 <= loss <= 1.0 and rounding > 0.0):
            raise InvalidValueError(
                f"Support {self.name}: loss {loss:g}, rounding {rounding:g}; allowed: 0 to 1, above 0. Correct them."
            )
        self._loose.append((loss, hold, rounding))

    def draw_down(self, *, gap_m: float) -> None:
        """Shorten the unloaded support by ``gap_m`` in y: a bolt that pulls it down onto a gap; gaps add."""
        self._drawn_down_m.append(gap_m)

    def scale_stiffness(self, *, x: float = 1.0, y: float = 1.0) -> None:
        """Multiply the stiffness in x and y; factors of several effects multiply."""
        self._check("stiffness", x, y)
        self.stiffness_x_n_m *= x
        self.stiffness_y_n_m *= y

    def scale_damping(self, *, x: float = 1.0, y: float = 1.0) -> None:
        """Multiply the damping in x and y; factors of several effects multiply."""
        self._check("damping", x, y)
        self.damping_x_n_s_m *= x
        self.damping_y_n_s_m *= y

    def finish(self, assembly: Assembly) -> None:
        """Add springs and dampers to the linear core."""
        assembly.add_spring(self.along_x, stiffness=self.stiffness_x_n_m, damping=self.damping_x_n_s_m)
        assembly.add_spring(self.along_y, stiffness=self.stiffness_y_n_m, damping=self.damping_y_n_s_m)
        if self._drawn_down_m:
            pull = -self.stiffness_y_n_m * sum(self._drawn_down_m)
            name = f"{self.name} drawn down"
            assembly.forces.append(harmonic_force(name, (self.along_y,), order=0.0, cos=(pull,), sin=(0.0,)))
        # A support without stiffness has nothing to lose.
        if self._loose and self.stiffness_y_n_m > 0:
            self._finish_loose(assembly)

    def _finish_loose(self, assembly: Assembly) -> None:
        from .bilinear_spring import loosened
        from .static_load import static_motion

        parts = list(assembly.components.values())
        behind = parts[[part is self for part in parts].index(True) + 1 :]
        rest = float(static_motion(assembly, behind, (self.along_y,))[0])
        stiffness = self.stiffness_y_n_m
        left = math.prod(1.0 - loss for loss, _, _ in self._loose)
        total = sum(loss for loss, _, _ in self._loose)
        for number, (loss, hold, rounding) in enumerate(self._loose, start=1):
            share = loss * (1.0 - left) / total if total else 0.0
            assembly.forces.append(
                loosened(
                    f"{self.name} loose {number}",
                    self.along_y,
                    lost_n_m=share * stiffness,
                    lift_m=rest + hold * abs(rest),
                    width_m=max(rounding * abs(rest), LEAST_ROUNDING_N / stiffness),
                )
            )

    def _check(self, what: str, x: float, y: float) -> None:
        if not (0.0 <= x < 1e6 and 0.0 <= y < 1e6):
            raise InvalidValueError(
                f"Support {self.name}: {what} times {x:g} in x and {y:g} in y; allowed: factors from 0 to 1e6. "
                "Correct the factor."
            )


def chosen_supports(assembly: Assembly, name: str = "") -> Iterator[Support]:
    """Yield the support of this name, or every support when the name is empty.

    Raises
    ------
    MissingPartError
        When the machine has no such support.
    """
    if name:
        yield assembly.component("support", name)
        return
    found = [part for part in assembly.components.values() if "support" in part.roles]
    if not found:
        raise MissingPartError("This machine has no support that can change. Use a machine that has one.")
    yield from found


def mesh_lines(assembly: Assembly) -> tuple[Line, ...]:
    """Return the mesh line of each gear pair: with gears, every change of a support or shaft changes it most."""
    meshes = (part for part in assembly.components.values() if "mesh" in part.roles)
    return tuple(Line(part.mesh_order) for part in meshes)
