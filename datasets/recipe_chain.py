"""The measuring chain of a recipe: the settings of `SensorChain`, each a number or a choice."""

from __future__ import annotations

from collections.abc import Collection, Mapping
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
    for name in _WHOLE:
        if name in found and not (found[name].whole or (found[name].values and found[name].values[0] % 1 == 0)):
            raise InvalidValueError(
                f"{where}, {name}: allowed: a whole number, or a range with whole = true. Correct it."
            )
    for index in (0, -1):
        try:
            chain_of({name: choice.ends()[index] for name, choice in found.items()})
        except InvalidValueError as problem:
            raise InvalidValueError(f"{where}: {problem}") from None
    return found


def check_units(where: str, chain: Mapping[str, Choice], units: Collection[str]) -> None:
    """Raise InvalidValueError for noise or a range in a unit that no recorded probe has: it would do nothing."""
    for key in chain:
        name, _, unit = key.partition(".")
        if unit and unit not in units:
            raise InvalidValueError(
                f"{where}, {name}: no recorded probe is in {unit!r}; allowed: {', '.join(sorted(units))}. Correct or "
                "remove it."
            )


def check_tacho(where: str, chain: Mapping[str, Choice], *, speed_rpm: float, rate_hz: float) -> None:
    """Raise InvalidValueError where pulses, or the gaps between them, are shorter than a sample and are lost."""
    for index in (0, -1):
        made = chain_of({name: choice.ends()[index] for name, choice in chain.items()})
        pulses_hz = made.pulses_per_revolution * made.tacho_ratio * speed_rpm / 60
        highest = rate_hz * min(made.pulse_width, 1 - made.pulse_width)
        if pulses_hz > highest:
            raise InvalidValueError(
                f"{where}: the tacho gives {pulses_hz:g} pulses a second at {speed_rpm:g} rpm; allowed at {rate_hz:g} "
                f"Hz: {highest:g}, a sample to each pulse and gap. Lower pulses_per_revolution, or raise rate_hz."
            )


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
