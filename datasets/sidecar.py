"""Sidecar files: ``recording.toml``, what a file lacks, written once for a folder of recordings.

Looked for, the first found counts: the path given explicitly; ``FILE.toml`` beside ``FILE.csv``;
``recording.toml`` in the file's folder. All keys are optional; an unknown key is an error.

``docs/recording.toml`` holds every key with its meaning.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from .errors import InvalidValueError, UnreadableFileError
from .metadata import ChannelMetadata, Metadata, parse_bearing
from .recording import DIRECTIONS, GearPair, MountedBearing

FOLDER_SIDECAR = "recording.toml"

_NUMBER = "a number"
_TEXT = "a text"
_TEXTS = "a list of texts"
_NAME = "a channel name or number"
_NAMES = "a list of channel names or numbers"
_WHOLE = "a whole number"
_FLAG = "true or false"

_RECORDING = {
    "rate_hz": _NUMBER,
    "unit": _TEXT,
    "units": _TEXTS,
    "sensitivity": _TEXT,
    "sensitivities": _TEXTS,
    "channel_names": _TEXTS,
    "directions": _TEXTS,
    "locations": _TEXTS,
    "skip": _NAMES,
    "tacho": _NAME,
    "pulses_per_revolution": _NUMBER,
    "speed_rpm": _NUMBER,
    "load": _NUMBER,
    "load_unit": _TEXT,
    "temperature_celsius": _NUMBER,
    "label": _TEXT,
}
_CHANNEL = {
    "match": _TEXT,
    "number": _WHOLE,
    "name": _TEXT,
    "unit": _TEXT,
    "sensitivity": _TEXT,
    "direction": _TEXT,
    "location": _TEXT,
    "tacho": _FLAG,
    "skip": _FLAG,
}
_MACHINE = {
    "name": _TEXT,
    "line_frequency_hz": _NUMBER,
    "severity_table": _TEXT,
    "mounting": _TEXT,
    "power_kw": _NUMBER,
    "shaft_height_mm": _NUMBER,
    "magnetic_bearing_clearance_m": _NUMBER,
}
_BEARING = {
    "designation": _TEXT,
    "balls": _WHOLE,
    "ball_diameter_mm": _NUMBER,
    "pitch_diameter_mm": _NUMBER,
    "contact_angle_deg": _NUMBER,
    "location": _TEXT,
    "shaft_ratio": _NUMBER,
}
_GEAR = {"driver_teeth": _WHOLE, "driven_teeth": _WHOLE, "driver_ratio": _NUMBER}


def find_sidecar(path: Path, explicit: Path | str | None = None) -> Path | None:
    """Return the sidecar that belongs to a recording, or None when there is none.

    Raises
    ------
    UnreadableFileError
        When the explicit path does not exist.
    """
    if explicit is not None:
        if not Path(explicit).is_file():
            raise UnreadableFileError(f"Sidecar {explicit}: no such file. Check --sidecar.")
        return Path(explicit)
    stems = [path.with_suffix(".toml")]
    if path.suffix == ".gz":
        stems.append(path.with_suffix("").with_suffix(".toml"))
    return next((one for one in (*stems, path.parent / FOLDER_SIDECAR) if one.is_file() and one != path), None)


def read_sidecar(sidecar: Path | str, path: Path | str | None = None) -> Metadata:
    """Return what a sidecar says about one recording (or, without ``path``, about all).

    Raises
    ------
    UnreadableFileError
        When it is no TOML.
    InvalidValueError
        On an unknown key or a value of the wrong kind; the message names the key and what is allowed.
    """
    sidecar = Path(sidecar)
    try:
        document = tomllib.loads(sidecar.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        raise UnreadableFileError(f"{sidecar}: cannot be read as TOML ({error}). Correct it or remove it.") from error
    _check_keys(document, ("recording", "channel", "machine", "file"), sidecar, "top level")
    recording = dict(_table(document, "recording", _RECORDING, sidecar))
    for override in _tables(document, "file", {"match": _TEXT, **_RECORDING}, sidecar):
        if "match" not in override:
            raise InvalidValueError(f'{sidecar}: [[file]] without match. Give one, for example match = "1800_*.csv".')
        if path is not None and fnmatchcase(Path(path).name, str(override["match"])):
            recording.update({key: value for key, value in override.items() if key != "match"})
    channels = _channels(_tables(document, "channel", _CHANNEL, sidecar), sidecar)
    return Metadata(**_recording_fields(recording), channels=channels, **_machine(document, sidecar))


def _recording_fields(table: Mapping[str, Any]) -> dict[str, Any]:
    found = dict(table)
    if "unit" in found:
        only = found.pop("unit")
        found.setdefault("units", [only])
    if "sensitivity" in found:
        only = found.pop("sensitivity")
        found.setdefault("sensitivities", [only])
    for key in ("units", "sensitivities", "channel_names", "directions", "locations", "skip"):
        if key in found:
            found[key] = tuple(str(item) for item in found[key])
    if "tacho" in found:
        found["tacho"] = str(found["tacho"])
    return found


def _channels(tables: list[Mapping[str, Any]], sidecar: Path) -> tuple[ChannelMetadata, ...]:
    out: list[ChannelMetadata] = []
    for position, table in enumerate(tables, start=1):
        if table.get("direction") not in (None, *DIRECTIONS):
            raise InvalidValueError(f"{sidecar}: direction = {table['direction']!r}; allowed: {', '.join(DIRECTIONS)}.")
        placed = table if "match" in table or "number" in table else {**table, "number": position}
        out.append(ChannelMetadata(**placed))
    return tuple(out)


def _machine(document: Mapping[str, Any], sidecar: Path) -> dict[str, Any]:
    machine = document.get("machine", {})
    if not isinstance(machine, dict):
        raise InvalidValueError(f"{sidecar}: machine must be a table: write [machine].")
    plain = {key: value for key, value in machine.items() if key not in ("bearing", "gear")}
    found = dict(_table({"machine": plain}, "machine", _MACHINE, sidecar, also=("bearing", "gear")))
    found["bearings"] = tuple(_bearing(one, sidecar) for one in _tables(machine, "bearing", _BEARING, sidecar))
    found["gears"] = tuple(_gear(one, sidecar) for one in _tables(machine, "gear", _GEAR, sidecar))
    return found


def _bearing(table: Mapping[str, Any], sidecar: Path) -> MountedBearing:
    sizes = ("balls", "ball_diameter_mm", "pitch_diameter_mm")
    if "designation" in table:
        parsed = parse_bearing(table["designation"])
    elif all(key in table for key in sizes):
        parsed = parse_bearing(",".join(str(table[key]) for key in sizes) + f",{table.get('contact_angle_deg', 0)}")
    else:
        raise InvalidValueError(f"{sidecar}: [[machine.bearing]] needs designation, or {', '.join(sizes)}.")
    ratio = float(table.get("shaft_ratio", parsed.shaft_ratio))
    if not ratio > 0:
        raise InvalidValueError(f"{sidecar}: shaft_ratio = {ratio}; allowed: a number above 0.")
    return MountedBearing(parsed.geometry, table.get("location", parsed.location), ratio)


def _gear(table: Mapping[str, Any], sidecar: Path) -> GearPair:
    if "driver_teeth" not in table:
        raise InvalidValueError(f"{sidecar}: [[machine.gear]] needs driver_teeth.")
    return GearPair(**table)


def _tables(
    document: Mapping[str, Any], name: str, allowed: Mapping[str, str], sidecar: Path
) -> list[Mapping[str, Any]]:
    found = document.get(name, [])
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise InvalidValueError(f"{sidecar}: {name} must be a list of tables: write it with double brackets, [[...]].")
    return [_table({name: one}, name, allowed, sidecar) for one in found]


def _table(
    document: Mapping[str, Any],
    name: str,
    allowed: Mapping[str, str],
    sidecar: Path,
    also: tuple[str, ...] = (),
) -> Mapping[str, Any]:
    table = document.get(name, {})
    if not isinstance(table, dict):
        raise InvalidValueError(f"{sidecar}: {name} must be a table: write [{name}].")
    _check_keys(table, (*allowed, *also), sidecar, f"[{name}]")
    for key, value in table.items():
        if not _fits(value, allowed[key]):
            raise InvalidValueError(f"{sidecar}: {key} = {value!r} in [{name}]; allowed: {allowed[key]}.")
    return table


def _check_keys(table: Mapping[str, Any], allowed: tuple[str, ...], sidecar: Path, where: str) -> None:
    unknown = [key for key in table if key not in allowed]
    if unknown:
        raise InvalidValueError(f"{sidecar}: unknown key {unknown[0]!r} in {where}. Allowed: {', '.join(allowed)}.")


def _fits(value: object, kind: str) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    whole = isinstance(value, int) and not isinstance(value, bool)
    items = value if isinstance(value, list) else []
    checks = {
        _NUMBER: number,
        _WHOLE: whole,
        _TEXT: isinstance(value, str),
        _FLAG: isinstance(value, bool),
        _NAME: isinstance(value, str) or whole,
        _TEXTS: isinstance(value, list) and all(isinstance(item, str) for item in items),
        _NAMES: isinstance(value, list)
        and all(isinstance(item, str | int) and not isinstance(item, bool) for item in items),
    }
    return checks[kind]
