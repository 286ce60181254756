"""The contract of a physical effect, and the catalogue found by scanning the `effects` folder.

An effect is a frozen dataclass in a file of its own. It declares its parameters with `parameter(...)`, says which part
of a machine it needs, changes an `Assembly`, and states its signature. No effect knows another.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import pkgutil
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from .errors import InvalidValueError
from .parameter import Parameter, parameters_of

if TYPE_CHECKING:
    from .assembly import Assembly
    from .machine import Machine

STAGES = ("structure", "force", "sensor")


@dataclass(frozen=True)
class Line:
    """A spectral line that an effect adds or raises.

    Parameters
    ----------
    order : float
        Multiple of the reference-shaft speed.
    direction : str
        "lateral", "x", "y", "axial" or "torsion": the probes that should show it; "any" for all.
    speed_exponent : float, optional
        The exciting force grows as speed to this power, away from resonances. None when it has no such law.
    load_exponent : float, optional
        The same for load.
    """

    order: float
    direction: str = "lateral"
    speed_exponent: float | None = None
    load_exponent: float | None = None


@dataclass(frozen=True, kw_only=True)
class Effect:
    """Base class of all effects. Subclasses set the class variables and `contribute`.

    Attributes
    ----------
    NAME : str
        As in machine files and on the command line.
    STAGE : str
        "structure" changes masses, dampers, springs or their angle harmonics; "force" adds an interface force;
        "sensor" changes the recorded signal.
    ROLE : str
        The part it acts on: a role of a place or a component (see `Assembly`).
    MEANING, CHECK : str
        What it does, and the question to ask or the check to make on the real machine.
    RIVALS : mapping of str to str
        Effects that look alike, by name, and the measurement that separates them.
    REFERENCES : tuple of str
    at : str
        Name of the part; empty for the machine's first one with the role.
    """

    NAME: ClassVar[str] = ""
    STAGE: ClassVar[str] = ""
    ROLE: ClassVar[str] = ""
    MEANING: ClassVar[str] = ""
    CHECK: ClassVar[str] = ""
    RIVALS: ClassVar[Mapping[str, str]] = {}
    REFERENCES: ClassVar[tuple[str, ...]] = ()

    at: str = ""

    def __post_init__(self) -> None:
        for declared in parameters_of(type(self)):
            value = declared.checked(getattr(self, declared.name))
            object.__setattr__(self, declared.name, value)

    def contribute(self, assembly: Assembly) -> None:
        """Change the assembly. Called once, before its components are finished."""
        raise NotImplementedError

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the lines that this effect adds to this machine, strongest first."""
        raise NotImplementedError

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """Return the declared parameters."""
        return parameters_of(cls)

    def values(self) -> dict[str, float]:
        """Return the parameters' values by name."""
        return {declared.name: getattr(self, declared.name) for declared in self.parameters()}

    def with_values(self, **values: float) -> Effect:
        """Return a copy with some values changed."""
        _check_names(type(self), values)
        return dataclasses.replace(self, **values)

    def at_zero(self) -> Effect:
        """Return a copy of zero strength: every strength at the value where the effect is absent."""
        return dataclasses.replace(self, **{p.name: p.zero for p in self.parameters() if p.zero is not None})


@functools.cache
def effect_catalogue() -> dict[str, type[Effect]]:
    """Return all effects by name: every `Effect` subclass defined in the modules of the `effects` folder.

    Modules whose name starts with an underscore are shared helpers.
    """
    package = importlib.import_module(".effects", __package__)
    found: dict[str, type[Effect]] = {}
    for info in sorted(pkgutil.iter_modules(package.__path__), key=lambda info: info.name):
        if info.name.startswith("_"):
            continue
        module = importlib.import_module(f".effects.{info.name}", __package__)
        for item in vars(module).values():
            if isinstance(item, type) and issubclass(item, Effect) and item.__module__ == module.__name__:
                found[item.NAME] = item
    return found


def make_effect(name: str, values: Mapping[str, object], *, at: str = "") -> Effect:
    """Return the effect of this name with these values; unnamed parameters keep their default.

    Raises
    ------
    InvalidValueError
        For an unknown effect or parameter, or a value out of bounds.
    """
    catalogue = effect_catalogue()
    if name not in catalogue:
        raise InvalidValueError(f"Effect {name!r} is unknown; allowed: {', '.join(sorted(catalogue))}.")
    _check_names(catalogue[name], values)
    return catalogue[name](at=at, **values)  # type: ignore[arg-type]


def _check_names(effect: type[Effect], values: Mapping[str, object]) -> None:
    known = [declared.name for declared in effect.parameters()]
    for name in values:
        if name not in known:
            raise InvalidValueError(f"Effect {effect.NAME} has no parameter {name!r}; allowed: {', '.join(known)}.")
