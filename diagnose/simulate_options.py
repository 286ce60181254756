"""Texts of the command line to machines, effects, speeds and measuring chains."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..simulators.errors import InvalidValueError
from ..simulators.sensor_chain import SensorChain

if TYPE_CHECKING:
    from ..simulators.effect import Effect
    from ..simulators.machine import Machine
    from ..simulators.speed_profile import SpeedProfile

#: Healthy measuring chains. "accelerometer": industrial piezo-electric, 100 mV/g, +-50 g (data sheet PCB 603C01: noise
#: 4 ug/sqrt(Hz) at 1 kHz and 8 at 10 Hz, resonance 25 kHz) on 24 bits. "mems": ADXL1002 (25 ug/sqrt(Hz), +-50 g,
#: resonance 21 kHz) on 16 bits.
CHAINS = {
    "ideal": SensorChain(),
    "accelerometer": SensorChain(
        mounting_hz=25_000.0,
        high_pass_hz=0.5,
        noise={"m/s2": 3.9e-5},
        noise_corner_hz=30.0,
        full_scale={"m/s2": 490.0},
        bits=24,
    ),
    "mems": SensorChain(mounting_hz=21_000.0, noise={"m/s2": 2.5e-4}, full_scale={"m/s2": 490.0}, bits=16),
}
_WHOLE = ("bits", "anti_alias_order", "pulses_per_revolution")
_BY_UNIT = ("noise", "full_scale")


def parse_machine(text: str, *, preset: str, settings: Sequence[str], load: float | None) -> Machine:
    """Return a shipped machine by name, or the one of a TOML file, with preset, changed values and load.

    Raises
    ------
    InvalidValueError
        For an unknown machine, preset or parameter, a value out of bounds, or a load on a machine without one.
    """
    from ..simulators.machine import find_machine, machine_from_toml

    is_file = text.casefold().endswith(".toml")
    machine = machine_from_toml(Path(text)) if is_file else find_machine(text)
    if preset:
        machine = replace(machine, preset_name=preset)
    machine = machine.with_parameters(**_pairs(settings, "--set"))  # type: ignore[arg-type]
    if load is None:
        return machine
    name = machine.definition.load_parameter
    if not name:
        raise InvalidValueError(f"Load {load:g}: machine {machine.name} has no load. Leave --load out.")
    return machine.with_parameters(**{name: load})


def parse_effect(text: str) -> Effect:
    """Return the effect of ``EFFECT[@PLACE][:param=value,...]``.

    Raises
    ------
    InvalidValueError
        For an unknown effect or parameter, or a value out of bounds.

    Examples
    --------
    >>> effect = parse_effect("unbalance@disc:moment_kg_m=2e-4")
    >>> effect.NAME, effect.at, effect.moment_kg_m
    ('unbalance', 'disc', 0.0002)
    """
    from ..simulators.effect import make_effect

    head, _, tail = text.partition(":")
    name, where, at = head.partition("@")
    if where and not at.strip():
        raise InvalidValueError(f"--with {text}: no place after '@'; allowed: EFFECT or EFFECT@PLACE. Name it.")
    return make_effect(name.strip(), _pairs(tail.split(",") if tail else (), f"--with {text}"), at=at.strip())


def parse_speed(text: str, *, duration_s: float) -> float | SpeedProfile:
    """Return a constant speed in revolutions a minute, or for ``FROM..TO`` a run-up over the duration.

    Raises
    ------
    InvalidValueError
        For anything that is not one or two speeds above 0.

    Examples
    --------
    >>> parse_speed("1800", duration_s=1.0)
    1800.0
    """
    from ..simulators.speed_profile import ramp, steady

    parts = text.split("..")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2):
        raise InvalidValueError(
            f"Speed {text!r}; allowed: revolutions a minute, or a run-up FROM..TO. Write --speed 1800 or "
            "--speed 600..3000."
        )
    if len(numbers) == 1:
        steady(speed_rpm=numbers[0])
        return numbers[0]
    return ramp(start_rpm=numbers[0], stop_rpm=numbers[1], duration_s=duration_s)


def parse_chain(text: str, *, pulses_per_revolution: int) -> SensorChain:
    """Return the measuring chain of ``NAME[:setting=value,...]``; noise and range are set as ``noise.m/s2=3e-4``.

    Raises
    ------
    InvalidValueError
        For an unknown chain or setting, or a value that is not allowed.

    Examples
    --------
    >>> parse_chain("ideal:bits=12,noise.m/s2=1e-3", pulses_per_revolution=1).noise
    {'m/s2': 0.001}
    """
    name, _, tail = text.partition(":")
    if name not in CHAINS:
        raise InvalidValueError(f"Chain {name!r} is unknown; allowed: {', '.join(CHAINS)}. Name one of them.")
    changes: dict[str, object] = {}
    known = [one.name for one in fields(SensorChain) if one.name not in (*_BY_UNIT, "pulses_per_revolution")]
    for key, value in _pairs(tail.split(",") if tail else (), f"--chain {text}").items():
        field, _, unit = key.partition(".")
        number = _number(key, value)
        if field in _BY_UNIT and unit in ("m", "m/s", "m/s2", "rad/s"):
            before = changes.get(field, getattr(CHAINS[name], field))
            changes[field] = {**before, unit: number}  # type: ignore[dict-item]
        elif key not in known:
            raise InvalidValueError(
                f"Chain setting {key!r} is unknown; allowed: {', '.join(known)}, noise.UNIT, full_scale.UNIT with "
                "the units m, m/s, m/s2, rad/s."
            )
        elif key in _WHOLE and number != round(number):
            raise InvalidValueError(f"{key} = {value}; allowed: a whole number. Correct it.")
        else:
            changes[key] = round(number) if key in _WHOLE else number
    return replace(CHAINS[name], pulses_per_revolution=pulses_per_revolution, **changes)  # type: ignore[arg-type]


def _pairs(items: Sequence[str], where: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for item in items:
        name, equals, value = (part.strip() for part in item.partition("="))
        if not (name and equals and value):
            raise InvalidValueError(f"{where}: {item!r} is not understood; allowed: name=value. Correct it.")
        if name in found:
            raise InvalidValueError(f"{where}: {name} is given twice; allowed: once. Remove one.")
        found[name] = value
    return found


def _number(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InvalidValueError(f"{name} = {text!r} is not a number; allowed: a finite number. Correct it.")
    return value
