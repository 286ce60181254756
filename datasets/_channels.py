"""Channels of a file with what the user knows of them: names, units, sensitivities; samples to SI."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from .channel_names import channel_index
from .errors import InvalidValueError, MissingMetadataError
from .file_content import FileContent
from .metadata import PER_CHANNEL, ChannelMetadata, Metadata
from .recording import Channel
from .units import Unit, parse_sensitivity, parse_unit, require_unit

#: What a sensor of vibration measures, and no tacho.
VIBRATION = frozenset({"acceleration", "velocity", "displacement"})


@dataclass(frozen=True, eq=False)
class Described:
    """Channels and their samples in SI, shape (channels, samples)."""

    signals: np.ndarray
    channels: tuple[Channel, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _Scaled:
    quantity: str | None
    factor: float
    stored_unit: str | None
    warnings: tuple[str, ...] = ()


def describe_channels(content: FileContent, metadata: Metadata, path: Path) -> Described:
    """Return the channels to keep, named and scaled to SI.

    Raises
    ------
    InvalidValueError
        When a list does not fit the number of channels, or a channel named by the user is not in the file.
    MissingMetadataError
        When a sensitivity is given for a channel whose unit is unknown.
    """
    known = [_known(content, metadata, index, path) for index in range(len(content.channel_names))]
    known = _with_tacho_and_skip(known, content.channel_names, metadata, path)
    kept = [index for index, one in enumerate(known) if not one.skip]
    if not kept:
        raise InvalidValueError(f"{path}: every channel is left out. Channels: {', '.join(content.channel_names)}.")
    signals = np.array(content.signals[kept])
    channels: list[Channel] = []
    warnings = _beyond(metadata, content.channel_names)
    for row, index in enumerate(kept):
        one, file_name = known[index], content.channel_names[index]
        scaled = _scaled(one, content.units[index] or None, file_name, hint=content.quantity_hints[index])
        warnings.extend(scaled.warnings)
        if scaled.factor != 1.0:
            signals[row] *= scaled.factor
        channels.append(
            Channel(
                name=one.name or file_name,
                quantity=scaled.quantity,
                location=one.location,
                direction=one.direction,
                stored_unit=scaled.stored_unit,
            )
        )
    _require_different([one.name for one in channels], path)
    return Described(signals, tuple(channels), tuple(warnings))


def _known(content: FileContent, metadata: Metadata, index: int, path: Path) -> ChannelMetadata:
    name = content.channel_names[index]
    found = ChannelMetadata()
    for rule in metadata.channels:
        if _concerns(rule, name, index):
            stated = {
                one.name: getattr(rule, one.name)
                for one in fields(rule)
                if getattr(rule, one.name) not in (None, False)
            }
            found = replace(found, **stated)
    for many, own in PER_CHANNEL.items():
        value = _entry(getattr(metadata, many), index, content.channel_names, many, path)
        # One entry for all channels is the weaker statement: a channel's own table keeps its say.
        if value and (getattr(found, own) is None or len(getattr(metadata, many)) > 1):
            found = replace(found, **{own: value})
    return found


def _concerns(rule: ChannelMetadata, name: str, index: int) -> bool:
    if rule.match is None:
        return rule.number == index + 1
    # Equality first: brackets in a name ("signals[0]") would otherwise be read as a pattern.
    return rule.match == name or fnmatchcase(name, rule.match)


def _beyond(metadata: Metadata, names: tuple[str, ...]) -> list[str]:
    return [
        f"Metadata for channel {rule.number} is not used: the file has {len(names)} ({', '.join(names)})."
        for rule in metadata.channels
        if rule.match is None and not 1 <= (rule.number or 0) <= len(names)
    ]


def _entry(values: tuple[str, ...], index: int, names: tuple[str, ...], what: str, path: Path) -> str | None:
    if not values:
        return None
    if len(values) == 1 and (len(names) == 1 or what != "channel_names"):
        return values[0]
    if len(values) != len(names):
        allowed = f"{len(names)}" if what == "channel_names" else f"1 or {len(names)}"
        raise InvalidValueError(
            f"{path}: {len(values)} {what.replace('_', ' ')} for {len(names)} channels "
            f"({', '.join(names)}); allowed: {allowed}, "
            'in this order, "" to leave one as it is.'
        )
    return values[index]


def _position(wanted: str, names: tuple[str, ...], known: list[ChannelMetadata], what: str, path: Path) -> int:
    found = channel_index(wanted, names, [one.name for one in known])
    if found is not None:
        return found
    called = [one.name or own for one, own in zip(known, names, strict=True)]
    raise InvalidValueError(
        f"{path}: {what} {wanted!r} is no channel of this file. Allowed: {', '.join(called)}, or a number "
        f"from 1 to {len(names)}."
    )


def _with_tacho_and_skip(
    known: list[ChannelMetadata], names: tuple[str, ...], metadata: Metadata, path: Path
) -> list[ChannelMetadata]:
    out = list(known)
    for wanted in metadata.skip:
        index = _position(wanted, names, known, "skip", path)
        out[index] = replace(out[index], skip=True)
    if metadata.tacho is not None:
        index = _position(metadata.tacho, names, known, "tacho", path)
        out[index] = replace(out[index], tacho=True, skip=False)
    return out


def _scaled(one: ChannelMetadata, file_unit: str | None, name: str, *, hint: str | None) -> _Scaled:
    stored = parse_unit(file_unit)
    warnings: list[str] = []
    unit: Unit | None = stored
    if one.unit is not None:
        unit = require_unit(one.unit)
        if stored is not None and stored != unit and hint != "tacho":
            warnings.append(
                f"Channel {name}: the given unit {unit.text} contradicts the file's {stored.text}; {unit.text} is used."
            )
    elif file_unit is not None and stored is None:
        warnings.append(
            f"Channel {name}: unit {file_unit!r} is not known; amplitudes stay as stored and no severity is stated."
        )
    stated = one.unit or file_unit
    if one.tacho or (hint == "tacho" and not (unit and unit.quantity == "rotational_speed")):
        # Only the instants of the pulses count, so a unit given for all channels does no harm here.
        volts = stored if stored is not None and stored.quantity == "voltage" else None
        return _Scaled("tacho", volts.to_si if volts else 1.0, stated, _vibrates(stored, name))
    if one.sensitivity is not None:
        return _through_sensitivity(one.sensitivity, unit, name, stated, warnings)
    if unit is None:
        return _Scaled(None, 1.0, stated, tuple(warnings))
    return _Scaled(unit.quantity, unit.to_si, stated, tuple(warnings))


def _vibrates(stored: Unit | None, name: str) -> tuple[str, ...]:
    """Return a warning where the file says that a tacho is a channel of vibration: that has a period as well."""
    if stored is None or stored.quantity not in VIBRATION:
        return ()
    return (
        f"Tacho {name} is in {stored.text}, as vibration is, and its phase is no place on the shaft: if it has no "
        "pulses, correct --tacho.",
    )


def _through_sensitivity(text: str, unit: Unit | None, name: str, stated: str | None, warnings: list[str]) -> _Scaled:
    sensitivity = parse_sensitivity(text)
    if unit is None:
        raise MissingMetadataError(
            f"Channel {name}: sensitivity {text!r} is given but not whether the samples are V or mV. "
            'Give the unit too: --unit V, or unit = "V" in recording.toml.'
        )
    if unit.quantity != "voltage":
        warnings.append(f"Channel {name} is in {unit.text}, not in volts; the sensitivity {text} is not applied.")
        return _Scaled(unit.quantity, unit.to_si, stated, tuple(warnings))
    stored = f"{unit.text} at {sensitivity.text}"
    return _Scaled(sensitivity.quantity, unit.to_si / sensitivity.volts_per_si, stored, tuple(warnings))


def _require_different(names: list[str], path: Path) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InvalidValueError(f"{path}: channel name {twice[0]!r} is given twice. Give each channel its own name.")
