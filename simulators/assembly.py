"""The workbench on which a machine is put together: degrees of freedom, matrices, components, forces, probes.

A machine definition fills an `Assembly`, effects then change it, `Assembly.build` turns it into a `System`.
Everything is addressed by name, so that an effect needs to know a place or a component, never a matrix index.
"""

from __future__ import annotations

import copy
import functools
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import FunctionType
from typing import Any, Protocol

import numpy as np

from .errors import InvalidValueError
from .law import Direction, InterfaceForce


class MissingPartError(InvalidValueError):
    """The machine has no part of the kind that was asked for."""


@dataclass(frozen=True)
class Place:
    """A point of a machine where something can act.

    Parameters
    ----------
    name : str
    roles : frozenset of str
        What it is: "rotor", "disc", "gear", "coupling", "bearing", "housing", "motor", "load".
    directions : mapping of str to Direction
        Motion of the point, by name: "x", "y" (vertical, up), "axial", "angle_x", "angle_y", "torsion".
    shaft_ratio : float
        Speed of the part over the speed of the reference shaft; 0 for a part that does not turn.
    """

    name: str
    roles: frozenset[str]
    directions: Mapping[str, Direction]
    shaft_ratio: float = 1.0


@dataclass(frozen=True)
class Probe:
    """A sensor position: a linear combination of displacements, velocities or accelerations.

    Parameters
    ----------
    name : str
    quantity : str
        "displacement", "velocity" or "acceleration" (linear or angular).
    unit : str
    location, direction : str
    row : Direction
        The combination of degrees of freedom that it sees.
    limit, limit_message : float and str, optional
        Largest absolute value for which the model holds, and what it means to pass it.
    """

    name: str
    quantity: str
    unit: str
    location: str
    direction: str
    row: Direction
    limit: float | None = None
    limit_message: str = ""


@dataclass(frozen=True)
class StateBlock:
    """A linear subsystem with states of its own, between a displacement and a force: a controller, a filter.

    z' = A z + b w, force = c z + d w, with w = ``input`` (displacements); the force acts along ``output``.
    """

    name: str
    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: float
    input: Direction
    output: Direction


class Component(Protocol):
    """A part with a law of its own (coupling, bearing, gear mesh) that effects may change before the build."""

    name: str
    roles: frozenset[str]

    def finish(self, assembly: Assembly) -> None:
        """Add the part's matrices and forces to the assembly; called once, after all effects."""
        ...


#: Up to so many rows a matrix is gone through entry by entry.
FEW_ROWS = 4
#: What cannot be changed, and functions.
_UNCHANGING = frozenset({float, int, str, bool, complex, bytes, type(None), frozenset, FunctionType})


class _WatchedSpeed:
    """The speed of an assembly, which notes whether anybody asked for it."""

    def __get__(self, assembly: Any, owner: type) -> float:
        if assembly is None:
            # For the dataclass: a field without a default.
            raise AttributeError
        assembly.follows_speed = True
        return assembly.own_speed_rad_s

    def __set__(self, assembly: Any, value: float) -> None:
        assembly.own_speed_rad_s, assembly.follows_speed = value, False


@dataclass
class Assembly:
    """A machine being put together. See the module's docstring.

    Attributes
    ----------
    speed_rad_s : float
        Reference-shaft speed about which the linear core is formed.
    mass, damping, stiffness : dict
        Entries of symmetric or general matrices by pair of degrees of freedom.
    gyroscopic : dict
        Entries multiplied by the reference-shaft speed.
    own_speed_rad_s : float
        The same, for those who only pass it on.
    follows_speed : bool
        Whether a part or an effect asked for ``speed_rad_s``. Else the same assembly serves all speeds.
    """

    speed_rad_s: _WatchedSpeed = _WatchedSpeed()
    own_speed_rad_s: float = field(init=False, repr=False)
    follows_speed: bool = field(default=False, init=False, repr=False, compare=False)
    coordinates: list[str] = field(default_factory=list)
    mass: dict[tuple[str, str], float] = field(default_factory=dict)
    damping: dict[tuple[str, str], float] = field(default_factory=dict)
    stiffness: dict[tuple[str, str], float] = field(default_factory=dict)
    gyroscopic: dict[tuple[str, str], float] = field(default_factory=dict)
    state_blocks: list[StateBlock] = field(default_factory=list)
    forces: list[InterfaceForce] = field(default_factory=list)
    places: dict[str, Place] = field(default_factory=dict)
    components: dict[str, Any] = field(default_factory=dict)
    probes: list[Probe] = field(default_factory=list)
    #: Unit vertical translation of everything that has weight: coordinate name to 1.
    vertical: dict[str, float] = field(default_factory=dict)
    #: Coordinates that are angles of turning parts, with their speed over the reference shaft's.
    torsional: dict[str, float] = field(default_factory=dict)
    #: The machine's load, in the unit of its load parameter; None for a machine without one.
    load: float | None = None
    #: Remarks for the user about this machine with these parameters and effects.
    notes: list[str] = field(default_factory=list)

    def copy(self) -> Assembly:
        """Return an independent copy: components can change, everything else they are made of is frozen."""
        made = Assembly(
            self.own_speed_rad_s,
            **{
                item.name: copy.copy(getattr(self, item.name))
                for item in fields(self)
                if item.init and item.name not in ("speed_rad_s", "components")
            },
            components=_independent(self.components),
        )
        made.follows_speed = self.follows_speed
        return made

    # -- coordinates and matrices ------------------------------------------------------------------------------

    def add_coordinate(
        self, name: str, *, mass: float = 0.0, vertical: bool = False, torsion_ratio: float | None = None
    ) -> None:
        """Add a degree of freedom with its own mass (kg) or inertia (kg.m2)."""
        if name in self.coordinates:
            raise InvalidValueError(f"Degree of freedom {name!r} exists already; allowed: new names. Rename one.")
        self.coordinates.append(name)
        if mass:
            self.mass[name, name] = mass
        if vertical:
            self.vertical[name] = 1.0
        if torsion_ratio is not None:
            self.torsional[name] = torsion_ratio

    def add_matrix(self, kind: str, names: list[str], matrix: np.ndarray) -> None:
        """Add ``matrix`` (len(names) square) to "mass", "damping", "stiffness" or "gyroscopic"."""
        entries = getattr(self, kind)
        matrix = np.asarray(matrix, dtype=float)
        if len(names) > FEW_ROWS:
            rows, columns = np.nonzero(matrix)
            places = zip(rows.tolist(), columns.tolist(), matrix[rows, columns].tolist(), strict=True)
        else:
            # numpy takes longer over matrices of two or three rows.
            places = ((i, j, value) for i, row in enumerate(matrix.tolist()) for j, value in enumerate(row) if value)
        for i, j, value in places:
            entries[names[i], names[j]] = entries.get((names[i], names[j]), 0.0) + value

    def add_spring(self, along: Direction, *, stiffness: float = 0.0, damping: float = 0.0) -> None:
        """Add a linear spring and damper whose elongation is the combination ``along``.

        {"a": 1, "b": -1} connects a to b; {"a": 1} connects a to the ground. N/m and N.s/m, or N.m/rad and N.m.s/rad.
        """
        for strength, entries in ((stiffness, self.stiffness), (damping, self.damping)):
            for first, a in along.items():
                for second, b in along.items():
                    value = float(strength * (a * b))
                    if value:
                        entries[first, second] = entries.get((first, second), 0.0) + value

    # -- finding parts -----------------------------------------------------------------------------------------

    def add_place(self, place: Place) -> None:
        """Declare a place; its name must be new."""
        if place.name in self.places:
            raise InvalidValueError(f"Place {place.name!r} exists already; allowed: new names. Rename one.")
        self.places[place.name] = place

    def add_component(self, component: Component) -> None:
        """Declare a component; its name must be new."""
        if component.name in self.components:
            raise InvalidValueError(f"Component {component.name!r} exists already; allowed: new names. Rename one.")
        self.components[component.name] = component

    def place(self, role: str, name: str = "") -> Place:
        """Return the place of this name, or the first one with this role when the name is empty."""
        return _find("place", self.places, role, name)

    def component(self, role: str, name: str = "") -> Any:
        """Return the component of this name, or the first one with this role when the name is empty."""
        return _find("component", self.components, role, name)


def _independent(part: Any) -> Any:
    """Return a copy that can be changed without changing ``part``, which may be shared as far as it is frozen.

    As `copy.deepcopy`, which takes several times as long: it keeps a record of all objects to find those that hold
    themselves. None of ours does.
    """
    kind = type(part)
    if _may_be_shared(kind):
        return part
    if kind is dict:
        # Most are numbers: asking here spares most of the calls.
        return {key: own if type(own) in _UNCHANGING else _independent(own) for key, own in part.items()}
    if kind in (list, tuple):
        return kind([_independent(value) for value in part])
    if kind is np.ndarray:
        return part.copy()
    if kind.__module__.startswith(f"{__package__}.") and hasattr(part, "__dict__"):
        made = object.__new__(kind)
        made.__dict__.update(_independent(part.__dict__))
        return made
    return copy.deepcopy(part)


@functools.cache
def _may_be_shared(kind: type) -> bool:
    options = getattr(kind, "__dataclass_params__", None)
    return kind in _UNCHANGING or (options is not None and options.frozen)


def _find(kind: str, parts: Mapping[str, Any], role: str, name: str) -> Any:
    fitting = [part for part in parts.values() if role in part.roles]
    if not name:
        if fitting:
            return fitting[0]
        raise MissingPartError(
            f"This machine has no {kind} of the kind {role!r}; it has "
            f"{', '.join(sorted({r for part in parts.values() for r in part.roles})) or 'none'}. "
            "Use a machine that has one."
        )
    for part in fitting:
        if part.name == name:
            return part
    raise MissingPartError(
        f"{name!r} is no {role} of this machine; allowed: {', '.join(part.name for part in fitting) or 'none'}. "
        "Correct the place."
    )


def difference(first: Direction, second: Direction) -> dict[str, float]:
    """Return the combination ``first - second``."""
    return combination((1.0, first), (-1.0, second))


def combination(*terms: tuple[float, Direction]) -> dict[str, float]:
    """Return the weighted sum of directions."""
    total: dict[str, float] = {}
    for weight, direction in terms:
        for name, value in direction.items():
            total[name] = total.get(name, 0.0) + weight * value
    return total
