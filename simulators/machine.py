"""A machine: a definition, parameter values and effects; as text (TOML) and as matrices (`System`)."""

from __future__ import annotations

import difflib
import functools
import importlib
import json
import pkgutil
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .assembly import Assembly
from .effect import Effect, make_effect
from .errors import InvalidValueError
from .parameter import Parameter
from .speed_profile import SpeedProfile, as_profile

if TYPE_CHECKING:
    from .solvers.simulate import Simulation
    from .system import System

FILE_FORMAT = 1
#: Changed parameters and effects that an error names.
MOST_NAMED = 6


@dataclass(frozen=True)
class Preset:
    """A named set of parameter values.

    Parameters
    ----------
    meaning : str
    values : mapping of str to float
        Where it differs from the parameters' defaults.
    switches : frozenset of str
        Variants of the equations that the definition's build function knows, such as a misprint taken literally.
    """

    meaning: str
    values: Mapping[str, float] = field(default_factory=dict)
    switches: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False)
class MachineDefinition:
    """What all machines of one kind share.

    Parameters
    ----------
    name, meaning : str
    parameters : tuple of Parameter
    presets : mapping of str to Preset
        "plausible" (the default) and "as_printed".
    build : callable
        ``build(assembly, values, switches)`` fills an empty assembly.
    step_s : float
        Default integration step: relative error of the probes about 1e-3 or better.
    settle_s : float
        Time after which a run from rest has lost its transient.
    load_parameter : str
        Name of the parameter that is the machine's load; empty when it has none.
    references : tuple of str
    """

    name: str
    meaning: str
    parameters: tuple[Parameter, ...]
    presets: Mapping[str, Preset]
    build: Callable[[Assembly, Mapping[str, float], frozenset[str]], None]
    step_s: float
    settle_s: float
    load_parameter: str = ""
    references: tuple[str, ...] = ()


@dataclass(frozen=True)
class Machine:
    """A machine with its parameter values and effects. Immutable: `with_...` methods return a new one.

    Parameters
    ----------
    definition : MachineDefinition
    preset_name : str
    changed : mapping of str to float
        Parameter values that differ from the preset's.
    effects : tuple of Effect
    """

    definition: MachineDefinition
    preset_name: str = "plausible"
    changed: Mapping[str, float] = field(default_factory=dict)
    effects: tuple[Effect, ...] = ()

    def __post_init__(self) -> None:
        if self.preset_name not in self.definition.presets:
            raise InvalidValueError(
                f"Machine {self.name} has no preset {self.preset_name!r}; "
                f"allowed: {', '.join(self.definition.presets)}."
            )
        known = {declared.name: declared for declared in self.definition.parameters}
        for name in self.changed:
            if name not in known:
                raise InvalidValueError(
                    f"Machine {self.name} has no parameter {name!r}; allowed: {', '.join(known)}. "
                    f"{_nearest(name, known)}"
                )
        checked = {name: known[name].checked(value) for name, value in self.changed.items()}
        object.__setattr__(self, "changed", checked)

    @property
    def name(self) -> str:
        """Name of the definition."""
        return self.definition.name

    @property
    def in_short(self) -> str:
        """Name, preset, and the first few parameters and effects that differ from it, without their values."""
        own = [*self.changed, *(one.NAME for one in self.effects)]
        more = f" and {len(own) - MOST_NAMED} more" if len(own) > MOST_NAMED else ""
        besides = f" with {', '.join(own[:MOST_NAMED])}{more}" if own else ""
        return f"{self.name} ({self.preset_name}){besides}"

    @property
    def switches(self) -> frozenset[str]:
        """Variants of the equations that the preset asks for."""
        return self.definition.presets[self.preset_name].switches

    @property
    def values(self) -> dict[str, float]:
        """Every parameter's value by name."""
        values = {declared.name: declared.default for declared in self.definition.parameters}
        return {**values, **self.definition.presets[self.preset_name].values, **self.changed}

    def preset(self, name: str) -> Machine:
        """Return the machine with another preset, without changed values, with the same effects."""
        return replace(self, preset_name=name, changed={})

    def with_parameters(self, **values: float) -> Machine:
        """Return the machine with some parameter values changed."""
        return replace(self, changed={**self.changed, **values})

    def with_effects(self, *effects: Effect) -> Machine:
        """Return the machine with further effects. The order does not matter."""
        return replace(self, effects=(*self.effects, *effects))

    def without_effects(self) -> Machine:
        """Return the machine without any effect."""
        return replace(self, effects=())

    def assembly(self, *, speed_rpm: float | SpeedProfile) -> Assembly:
        """Return the assembled machine before it becomes matrices, with effects and components in place."""
        assembly = self._built(as_profile(speed_rpm).mean_speed_rad_s)
        for effect in self.effects:
            effect.contribute(assembly)
        for component in assembly.components.values():
            component.finish(assembly)
        return assembly

    def bare_assembly(self) -> Assembly:
        """Return the machine's parts without effects or forces: places, components, coordinates."""
        return self._built(0.0)

    @functools.cached_property
    def shaft_ratios(self) -> Mapping[str, float]:
        """Speed of the shaft at each place over the reference shaft's, by the place's name."""
        return {place.name: place.shaft_ratio for place in self.bare_assembly().places.values()}

    def _built(self, speed_rad_s: float) -> Assembly:
        values = self.definition, tuple(self.values.items()), self.switches
        built = _built(*values, 0.0)
        if built.follows_speed:
            return _built(*values, speed_rad_s).copy()
        made = built.copy()
        made.speed_rad_s = speed_rad_s
        return made

    def system(self, *, speed_rpm: float | SpeedProfile) -> System:
        """Return the matrices at this speed (for a changing speed, at its middle)."""
        from .system import build_system

        return build_system(self.assembly(speed_rpm=speed_rpm), steady=as_profile(speed_rpm).is_steady)

    def simulate(
        self,
        *,
        speed_rpm: float | SpeedProfile,
        duration_s: float,
        rate_hz: float,
        **options: Any,
    ) -> Simulation:
        """Return the machine's signals; options as in `simulate` of `rotorwise.simulators.solvers.simulate`."""
        from .solvers.simulate import simulate

        return simulate(self, speed_rpm=speed_rpm, duration_s=duration_s, rate_hz=rate_hz, **options)

    def to_toml(self) -> str:
        """Return the machine as text that `machine_from_toml` reads back unchanged."""
        return self._toml

    @functools.cached_property
    def _toml(self) -> str:
        lines = [f"format = {FILE_FORMAT}", f"machine = {json.dumps(self.name)}"]
        lines += [f"preset = {json.dumps(self.preset_name)}", "", "[parameters]"]
        lines += [f"{name} = {_number(value)}" for name, value in self.changed.items()]
        for effect in self.effects:
            lines += ["", "[[effects]]", f"effect = {json.dumps(effect.NAME)}"]
            lines += [f"at = {json.dumps(effect.at)}"] if effect.at else []
            lines += [f"{name} = {_number(value)}" for name, value in effect.values().items()]
        return "\n".join(lines) + "\n"


@functools.lru_cache(maxsize=128)
def _built(
    definition: MachineDefinition, values: tuple[tuple[str, float], ...], switches: frozenset[str], speed_rad_s: float
) -> Assembly:
    """Return a built assembly, to be copied: a copy comes ten times faster than building anew."""
    by_name = dict(values)
    assembly = Assembly(speed_rad_s=speed_rad_s, load=by_name.get(definition.load_parameter))
    definition.build(assembly, by_name, switches)
    return assembly


def machine_from_toml(source: str | Path) -> Machine:
    """Return the machine that a TOML text, or the file at a path, describes.

    Raises
    ------
    InvalidValueError
        For text that is not TOML, an unknown machine, preset, effect or name, or a value out of bounds.
    """
    where = f"Machine file {source}" if isinstance(source, Path) else "Machine text"
    try:
        content = tomllib.loads(source.read_text(encoding="utf-8-sig") if isinstance(source, Path) else source)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InvalidValueError(f"{where} is not valid TOML: {error}. Correct it at that place.") from None
    except OSError as error:
        raise InvalidValueError(f"{where} cannot be read: {error.strerror or error}. Check the path.") from None
    _check_keys(where, content, {"format", "machine", "preset", "parameters", "effects"})
    if content.get("format") != FILE_FORMAT:
        found = f"format {content['format']!r}" if "format" in content else "no format"
        raise InvalidValueError(
            f"{where} has {found}; allowed: {FILE_FORMAT}. Write format = {FILE_FORMAT} at its top."
        )
    parameters, effects = content.get("parameters", {}), content.get("effects", [])
    if not isinstance(parameters, dict) or not isinstance(effects, list):
        raise InvalidValueError(f"{where}: allowed: a table [parameters] and tables [[effects]]. Correct the headings.")
    if "machine" not in content:
        raise InvalidValueError(f'{where} names no machine; allowed: machine = "test_rig", ... Write it at its top.')
    found = [_effect(where, entry) for entry in effects]
    name, preset = (_text(where, content, *one) for one in (("machine", ""), ("preset", "plausible")))
    try:
        return find_machine(name).preset(preset).with_parameters(**parameters).with_effects(*found)
    except InvalidValueError as problem:
        raise InvalidValueError(f"{where}: {problem}") from None


def _effect(where: str, entry: dict[str, Any]) -> Effect:
    if not isinstance(entry, dict) or "effect" not in entry:
        raise InvalidValueError(
            f'{where}: an entry of [[effects]] has no name; allowed: effect = "unbalance", ... Give it.'
        )
    values = {key: value for key, value in entry.items() if key not in ("effect", "at")}
    name, at = (_text(where, entry, key, "") for key in ("effect", "at"))
    try:
        return make_effect(name, values, at=at)
    except InvalidValueError as problem:
        raise InvalidValueError(f"{where}: {problem}") from None


def _text(where: str, content: Mapping[str, object], key: str, default: str) -> str:
    value = content.get(key, default)
    if not isinstance(value, str):
        raise InvalidValueError(f"{where}: {key} = {value!r}; allowed: a name in quotes. Correct it.")
    return value


def _check_keys(where: str, content: Mapping[str, object], allowed: set[str]) -> None:
    for key in content:
        if key not in allowed:
            raise InvalidValueError(
                f"{where} has an unknown entry {key!r}; allowed: {', '.join(sorted(allowed))}. Correct or remove it."
            )


@functools.cache
def machine_catalogue() -> dict[str, Machine]:
    """Return the shipped machines by name: every module in `machines` with a `DEFINITION`."""
    package = importlib.import_module(".machines", __package__)
    found: dict[str, Machine] = {}
    for info in sorted(pkgutil.iter_modules(package.__path__), key=lambda info: info.name):
        module = importlib.import_module(f".machines.{info.name}", __package__)
        definition = getattr(module, "DEFINITION", None)
        if isinstance(definition, MachineDefinition):
            found[definition.name] = Machine(definition)
    return found


def find_machine(name: str) -> Machine:
    """Return the shipped machine of this name with its plausible preset, or raise InvalidValueError."""
    catalogue = machine_catalogue()
    if name not in catalogue:
        raise InvalidValueError(
            f"Machine {name!r} is unknown; allowed: {', '.join(catalogue)}. {_nearest(name, catalogue)}"
        )
    return catalogue[name]


def _nearest(name: str, known: Iterable[str]) -> str:
    """Return what to do about a wrong name."""
    near = difflib.get_close_matches(name, list(known), n=1)
    return f"Did you mean {near[0]}?" if near else "Correct the name."


def _number(value: float) -> str:
    return repr(float(value))
