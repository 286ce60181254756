"""The contract of a physical effect, and the catalogue found by scanning the `effects` folder.

An effect is a frozen dataclass in a file of its own. It declares its parameters with `parameter(...)`, says which part
of a machine it needs, changes an `Assembly`, and states its signature. No effect knows another.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import pkgutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from .assembly import MissingPartError
from .errors import InvalidValueError
from .parameter import Parameter, parameters_of

if TYPE_CHECKING:
    import numpy as np

    from .assembly import Assembly, Probe
    from .machine import Machine
    from .sensor_record import SensorRecord

STAGES = ("speed", "structure", "force", "sensor")


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
    frequency_hz : float
        Added to the order's frequency: the line lies at order x speed + frequency_hz, on the positive side.
    """

    order: float
    direction: str = "lateral"
    speed_exponent: float | None = None
    load_exponent: float | None = None
    frequency_hz: float = 0.0

    def order_at(self, speed_rpm: float) -> float:
        """Return the line's place as a multiple of the reference-shaft speed, at one speed."""
        return abs(self.order + 60 * self.frequency_hz / speed_rpm)


@dataclass(frozen=True, kw_only=True)
class Effect:
    """Base class of all effects. Subclasses set the class variables and `contribute`.

    Attributes
    ----------
    NAME : str
        As in machine files and on the command line.
    STAGE : str
        "speed" changes the shaft's speed (`SpeedEffect`); "structure" changes masses, dampers, springs or their angle
        harmonics; "force" adds an interface force; "sensor" changes the recorded signal (`SensorEffect`).
    ROLE : str
        The part it acts on: a role of a place or a component (see `Assembly`).
    MEANING, CHECK : str
        What it does, and the question to ask or the check to make on the real machine.
    RIVALS : mapping of str to str
        Effects that look alike, by name, and the measurement that separates them.
    REFERENCES : tuple of str
    EMPIRICAL : bool
        It describes what was measured and explains nothing: it is never offered as a cause.
    IDEALISED : bool
        The form of its law is an idealisation, as that of a contact or of a crack that opens: the harmonics of a real
        one differ from it by tens of per cent, and by how much changes with the speed.
    PERMANENT : bool
        It acts on every machine of the kind, the healthy one as well: it does not explain what has changed since.
    SHARED : bool
        All parts with its role share it, and which of them is named makes no difference: both gears of a worn mesh.
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
    EMPIRICAL: ClassVar[bool] = False
    IDEALISED: ClassVar[bool] = False
    PERMANENT: ClassVar[bool] = False
    SHARED: ClassVar[bool] = False

    at: str = ""

    def __post_init__(self) -> None:
        for declared in parameters_of(type(self)):
            value = declared.checked(getattr(self, declared.name))
            object.__setattr__(self, declared.name, value)

    def contribute(self, assembly: Assembly) -> None:
        """Change the assembly. Called once, before its components are finished."""
        raise NotImplementedError

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the lines that this effect adds to this machine with the effects that it has, strongest first.

        Where two effects act on one part, one changes which lines the other makes: an elongation of a coupling makes
        other lines once its stiffness varies. `parts` shows the parts as the other effects leave them.
        """
        raise NotImplementedError

    def parts(self, machine: Machine) -> Assembly:
        """Return the machine's parts as its other effects leave them: not finished, and without this effect."""
        assembly = machine.bare_assembly()
        for effect in machine.effects:
            if effect != self:
                effect.contribute(assembly)
        return assembly

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


@dataclass(frozen=True, kw_only=True)
class SpeedEffect(Effect):
    """Base class of effects on the speed of the reference shaft; they act before the machine is simulated.

    Harmonic balance, Floquet analysis and everything else at constant speed do not see them.
    """

    STAGE = "speed"
    ROLE = "shaft speed"

    def contribute(self, assembly: Assembly) -> None:
        """Change nothing: the effect is in the speed."""

    def speed_change(self, *, duration_s: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Return knots (s, from 0) and the relative change of speed at each; None when the effect is absent."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class SensorEffect(Effect):
    """Base class of effects on the recorded signal; they act after the physics. Subclasses set `LINK` and `apply`.

    Strengths are in the channel's unit, or a share of its measuring range (`SensorRecord.full_scale`), which is the
    largest distance from the mean in the healthy record unless a `SensorChain` states it.

    Attributes
    ----------
    LINK : str
        The link of the measuring chain on which it acts, one of `sensor_record.LINKS`.
    QUANTITIES : tuple of str
        The quantities of the probes that it can act on.
    at : str
        Name of a probe, or of a location for all its probes; empty for all probes that fit.
    """

    STAGE = "sensor"
    ROLE = "probe"
    LINK: ClassVar[str] = ""
    QUANTITIES: ClassVar[tuple[str, ...]] = ("displacement", "velocity", "acceleration")

    @property
    def is_random(self) -> bool:
        """Whether `apply` draws random numbers, so that the simulation needs a seed."""
        return False

    def demand(self, *, rate_hz: float, duration_s: float) -> tuple[int, float]:
        """Return the multiple of the output rate that the record needs before the filter, and extra seconds."""
        return 1, 0.0

    def fits(self, probe: Probe) -> bool:
        """Return whether the effect can act on a probe of this kind."""
        return probe.quantity in self.QUANTITIES

    def chosen(self, probes: Sequence[Probe]) -> list[int]:
        """Return the numbers of the probes on which the effect acts.

        Raises
        ------
        MissingPartError
            When there is none.
        """
        able = [i for i, probe in enumerate(probes) if self.fits(probe)]
        found = [i for i in able if self.at in ("", probes[i].name, probes[i].location)]
        if not found:
            names = ", ".join(dict.fromkeys(name for i in able for name in (probes[i].name, probes[i].location)))
            raise MissingPartError(
                f"Effect {self.NAME} finds no probe{f' {self.at!r}' if self.at else ''} that fits it (it acts on "
                f"{', '.join(self.QUANTITIES)}); allowed: {names or 'none on this machine'}. Choose one of them."
            )
        return found

    def contribute(self, assembly: Assembly) -> None:
        """Change nothing in the machine, but check that it has such a probe."""
        self.chosen(assembly.probes)

    def mixing(self, channels: Sequence[Probe]) -> np.ndarray | None:
        """Return the matrix by which the effect makes all signals from all; None when it does more than mix and add."""
        return None

    def added(self, channels: Sequence[Probe]) -> Mapping[int, np.ndarray]:
        """Return what one that only mixes adds: complex amplitudes (channels,) by order of the channel's shaft."""
        return {}

    @property
    def adds_up_to_hz(self) -> float | None:
        """Highest frequency of what the effect adds to signals, whatever they are; None when it does anything else."""
        return None

    def apply(self, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Return the record as this effect leaves it; ``generator`` is the effect's own stream of random numbers."""
        raise NotImplementedError


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
