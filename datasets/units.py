"""Units of vibration signals: the one place where anything is converted to SI.

Units are declared, never guessed: an unknown text stays unknown.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from .errors import InvalidValueError

STANDARD_GRAVITY = 9.80665  # m/s2, exact by definition (CGPM 1901)

#: SI unit of each quantity that a channel can hold.
SI_UNIT = {
    "acceleration": "m/s2",
    "velocity": "m/s",
    "displacement": "m",
    "sound_pressure": "Pa",
    "voltage": "V",
    "tacho": "V",
    "force": "N",
    "torque": "N.m",
    "current": "A",
    "rotational_speed": "rad/s",
    "angle": "rad",
}


@dataclass(frozen=True)
class Unit:
    """A unit: its usual spelling, the quantity it measures and the factor that takes it to SI."""

    text: str
    quantity: str
    to_si: float


_UNITS = (
    (Unit("m/s2", "acceleration", 1.0), "m/s^2 m/s² m/s**2 m/s/s ms-2 ms^-2 m.s-2 mps2 m/sec2 m/sec^2"),
    (Unit("mm/s2", "acceleration", 1e-3), "mm/s^2 mm/s²"),
    (Unit("g", "acceleration", STANDARD_GRAVITY), "gn g0 g's gs gravity"),
    (Unit("mg", "acceleration", STANDARD_GRAVITY * 1e-3), "milli-g"),
    (Unit("m/s", "velocity", 1.0), "m/sec ms-1 ms^-1 mps"),
    (Unit("mm/s", "velocity", 1e-3), "mm/sec mms-1 mms^-1"),
    (Unit("in/s", "velocity", 0.0254), "in/sec ips inch/s"),
    (Unit("m", "displacement", 1.0), "metre meter"),
    (Unit("mm", "displacement", 1e-3), "millimetre millimeter"),
    (Unit("um", "displacement", 1e-6), "µm μm micron microns micrometre micrometer"),
    (Unit("mil", "displacement", 25.4e-6), "mils thou"),
    (Unit("in", "displacement", 0.0254), "inch"),
    (Unit("Pa", "sound_pressure", 1.0), "pascal"),
    (Unit("mPa", "sound_pressure", 1e-3), ""),
    (Unit("V", "voltage", 1.0), "volt volts"),
    (Unit("mV", "voltage", 1e-3), "millivolt millivolts"),
    (Unit("N", "force", 1.0), "newton"),
    (Unit("N.m", "torque", 1.0), "nm n*m n·m"),
    (Unit("A", "current", 1.0), "amp ampere amps"),
    (Unit("rpm", "rotational_speed", 0.10471975511965977), "r/min rev/min 1/min"),
    (Unit("rad/s", "rotational_speed", 1.0), "rad/sec"),
    (Unit("rad", "angle", 1.0), "radian radians"),
    (Unit("mrad", "angle", 1e-3), "milliradian milliradians"),
    (Unit("deg", "angle", math.pi / 180), "° degree degrees"),
)
# Some spellings differ by case only (Pa, mPa, mV against MV): exact spelling first, then without case.
_EXACT = {unit.text: unit for unit, _ in _UNITS}
_FOLDED = {
    spelling.casefold(): unit
    for unit, others in reversed(_UNITS)
    for spelling in (*others.split(" "), unit.text)
    if spelling
}


def parse_unit(text: str | None) -> Unit | None:
    """Return the unit that a text names, or None when it names no unit known here.

    Brackets and blanks around the text are ignored.

    Examples
    --------
    >>> parse_unit("[m/s^2]").text
    'm/s2'
    >>> parse_unit("furlong") is None
    True
    """
    if text is None:
        return None
    bare = text.strip().strip("()[]{}").strip()
    if bare in _EXACT:
        return _EXACT[bare]
    return _FOLDED.get(bare.casefold())


def require_unit(text: str) -> Unit:
    """Return the unit that a text names.

    Raises
    ------
    InvalidValueError
        When it names none; the message lists the units.
    """
    unit = parse_unit(text)
    if unit is None:
        known = ", ".join(_EXACT)
        raise InvalidValueError(f"Unit {text!r} is not known. Allowed: {known}.")
    return unit


@dataclass(frozen=True)
class Sensitivity:
    """Output of a sensor: volts per SI unit of the quantity that it measures."""

    volts_per_si: float
    quantity: str
    text: str


def parse_sensitivity(text: str) -> Sensitivity:
    """Return the sensitivity that a text such as ``"20 mV/g"`` or ``"7.87 V/mm"`` gives.

    Raises
    ------
    InvalidValueError
        When it is not a non-zero number, a voltage unit, a slash and a unit.

    Examples
    --------
    >>> round(parse_sensitivity("100 mV/g").volts_per_si, 6)
    0.010197
    """
    match = re.fullmatch(r"\s*([-+0-9.eE]+)\s*(m?V)\s*/\s*\(?(.+?)\)?\s*", text)
    unit = parse_unit(match.group(3)) if match else None
    try:
        value = float(match.group(1)) if match else 0.0
    except ValueError:
        value = 0.0
    if match is None or unit is None or value == 0.0 or not abs(value) < float("inf"):
        raise InvalidValueError(
            f"Sensitivity {text!r} is not understood. Give a number, V or mV, a slash and a unit, "
            'for example "100 mV/g", "7.87 V/mm", "4 mV/(mm/s)".'
        )
    volts = value * _EXACT[match.group(2)].to_si
    return Sensitivity(volts_per_si=volts / unit.to_si, quantity=unit.quantity, text=text.strip())
