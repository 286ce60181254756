"""The measuring chain of a recipe: the settings of `SensorChain`, each a number or a choice."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

from ..simulators.sensor_chain import SensorChain
from .errors import InvalidValueError
from .recipe_values import Choice, parse_choice

_BY_UNIT = ("noise", "full_scale")
_WHOLE = ("bits", "anti_alias_order", "pulses_per_revolution")
#: These decide which columns a table has.
_SAME_FOR_ALL = ("pulses_per_revolution", "tacho_ratio")


def parse_chain(where: str, given: object) -> dict[str, Choice]:
    """Return the choices of a chain by setting; noise and range by unit, as ``noise.m/s2``.

    Raises
    ------
    InvalidValueError
        For an unknown setting or a value that is not allowed.
    """
    if not isinstance(given, dict):
        raise InvalidValueError(f"{where} = {given!r}; allowed: a table [chain]. Correct it.")
    known = [one.name for one in fields(SensorChain)]
    found: dict[str, Choice] = {}
    for name, value in given.items():
        if name not in known:
            raise InvalidValueError(f"{where} has no setting {name!r}; allowed: {', '.join(known)}. Correct it.")
        if name not in _BY_UNIT:
            found[name] = parse_choice(f"{where}, {name}", value, cells=False)
            continue
        if not isinstance(value, dict):
            raise InvalidValueError(f'{where}, {name} = {value!r}; allowed: {{ "m/s2" = 3e-4 }}. Correct it.')
        for unit, one in value.items():
            found[f"{name}.{unit}"] = parse_choice(f"{where}, {name}.{unit}", one, cells=False)
    for name in _SAME_FOR_ALL:
        if name in found and not found[name].is_fixed:
            raise InvalidValueError(f"{where}, {name}: allowed: one number for all signals. Give one.")
    for index in (0, -1):
        chain_of({name: choice.ends()[index] for name, choice in found.items()})
    return found


def chain_of(values: Mapping[str, float]) -> SensorChain:
    """Return the measuring chain with these settings.

    Raises
    ------
    InvalidValueError
        For a value that is not allowed.
    """
    settings: dict[str, object] = {}
    for key, value in values.items():
        name, _, unit = key.partition(".")
        if name in _BY_UNIT:
            before = settings.setdefault(name, {})
            assert isinstance(before, dict)
            before[unit] = value
        else:
            settings[name] = round(value) if name in _WHOLE else value
    return SensorChain(**settings)  # type: ignore[arg-type]
