"""The sidecar of a written recording: all that is known of it, in the words of :mod:`rotorwise.datasets.sidecar`."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import fields

from ..simulators.errors import RotorwiseError
from ..simulators.rotor_dynamics.rolling_bearing import BearingGeometry, find_bearing
from .recording import Channel, GearPair, MountedBearing, Recording

#: A sidecar that starts so was made here, and may be replaced with its recording.
FIRST_WORDS = "# Written by rotorwise with "


def sidecar_text(recording: Recording, *, file_name: str, remarks: str = "") -> str:
    """Return a sidecar that gives back everything of a recording but its samples.

    Parameters
    ----------
    recording : Recording
    file_name : str
        Of the recording, for the reader of the text.
    remarks : str
        Further lines, put in as comments.
    """
    said = recording.condition
    lines = [f"{FIRST_WORDS}{file_name}.", *(f"# {line}".rstrip() for line in remarks.splitlines()), ""]
    lines += _table(
        "[recording]",
        {
            "rate_hz": recording.rate_hz,
            "speed_rpm": said.speed_rpm,
            "load": said.load,
            "load_unit": said.load_unit,
            "temperature_celsius": said.temperature_celsius,
            "label": recording.label,
            "pulses_per_revolution": recording.pulses_per_revolution if _has_tacho(recording) else None,
        },
    )
    for number, one in enumerate(recording.channels, start=1):
        lines += _table("[[channel]]", _channel(number, one))
    plate = recording.nameplate
    plain = {one.name: getattr(plate, one.name) for one in fields(plate) if one.name not in ("bearings", "gears")}
    lines += _table("[machine]", plain)
    for bearing in plate.bearings:
        lines += _table("[[machine.bearing]]", _bearing(bearing))
    for gear in plate.gears:
        lines += _table("[[machine.gear]]", _gear(gear))
    return "\n".join(lines).rstrip() + "\n"


def _has_tacho(recording: Recording) -> bool:
    return any(one.quantity == "tacho" for one in recording.channels)


def _channel(number: int, one: Channel) -> dict[str, object]:
    tacho = one.quantity == "tacho"
    return {
        "number": number,
        "name": one.name,
        "unit": None if tacho else one.unit,
        "direction": one.direction,
        "location": one.location,
        "tacho": True if tacho else None,
    }


def _bearing(bearing: MountedBearing) -> dict[str, object]:
    geometry = bearing.geometry
    common = {"location": bearing.location, "shaft_ratio": bearing.shaft_ratio}
    if _in_catalogue(geometry):
        return {"designation": geometry.designation, **common}
    return {
        "balls": geometry.balls,
        "ball_diameter_mm": geometry.ball_diameter_m * 1e3,
        "pitch_diameter_mm": geometry.pitch_diameter_m * 1e3,
        "contact_angle_deg": math.degrees(geometry.contact_angle_rad),
        **common,
    }


def _in_catalogue(geometry: BearingGeometry) -> bool:
    try:
        return bool(geometry.designation) and find_bearing(geometry.designation) == geometry
    except RotorwiseError:
        return False


def _gear(gear: GearPair) -> dict[str, object]:
    return {one.name: getattr(gear, one.name) for one in fields(gear)}


def _table(heading: str, values: Mapping[str, object]) -> list[str]:
    known = [f"{key} = {_value(value)}" for key, value in values.items() if value is not None]
    return [heading, *known, ""] if known else []


def _value(value: object) -> str:
    if isinstance(value, str):
        # JSON's escapes are TOML's, but for DEL, which JSON leaves bare.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(float(value)) if isinstance(value, float) else str(value)
