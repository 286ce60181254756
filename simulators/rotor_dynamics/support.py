"""A support of a shaft or housing: springs and dampers in x and y that effects may change."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..assembly import Assembly, MissingPartError
from ..errors import InvalidValueError
from ..law import Direction


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
