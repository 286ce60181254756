"""Which channel of a measured file is which probe of the machine.

What the user says counts first, then the name, then location, direction and quantity, then direction and quantity
alone where only one channel and one probe have them. Quantities must agree: nothing is integrated or differentiated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from ...datasets.channel_names import channel_index
from ...datasets.recording import Channel, Recording
from ...datasets.units import SI_UNIT, parse_unit
from ...simulators.assembly import Probe
from ...simulators.errors import InvalidValueError

#: x is horizontal and y vertical in every machine here.
SAME_WAY = {"horizontal": "x", "vertical": "y"}


@dataclass(frozen=True)
class Matched:
    """The channels of one recording that are probes of the machine.

    Attributes
    ----------
    probes : mapping of int to str
        Probe's name by channel number in the recording, from 0.
    left : mapping of str to str
        Why a channel is not compared, by its name.
    """

    probes: Mapping[int, str]
    left: Mapping[str, str]


def parse_probes(texts: Sequence[str], probes: Sequence[Probe]) -> dict[str, str]:
    """Return the probe by channel (name or number from 1) from texts ``CHANNEL=PROBE``.

    Raises
    ------
    InvalidValueError
        For a text of another form, an unknown probe, or a channel or a probe that is named twice.
    """
    known, found = [probe.name for probe in probes], {}
    for text in texts:
        channel, equals, name = (part.strip() for part in text.rpartition("="))
        channel, name = (channel, name) if equals else ("", text)
        if not channel:
            raise InvalidValueError(f"--probe {text!r}; allowed: CHANNEL=PROBE, with the probes {', '.join(known)}.")
        if name not in known:
            raise InvalidValueError(f"--probe {text!r}: no probe {name!r}; allowed: {', '.join(known)}.")
        if channel in found or name in found.values():
            raise InvalidValueError(f"--probe {text!r}: channel or probe is named twice; allowed: once. Remove one.")
        found[channel] = name
    return found


def match_channels(recording: Recording, probes: Sequence[Probe], *, given: Mapping[str, str]) -> Matched:
    """Return which channel is which probe.

    Parameters
    ----------
    recording : Recording
    probes : sequence of Probe
        The machine's.
    given : mapping of str to str
        From `parse_probes`.

    Raises
    ------
    InvalidValueError
        When a given channel is not there, when quantities disagree, or when no channel is a probe.
    """
    free = {i: one for i, one in enumerate(recording.channels) if one.quantity != "tacho"}
    found = {_given_channel(recording, channel): name for channel, name in given.items()}
    by_name = {probe.name: probe for probe in probes}
    for i, one in free.items():
        if i not in found and one.name in by_name and one.name not in found.values():
            found[i] = one.name
    for i, name in found.items():
        _check_quantity(recording, recording.channels[i], by_name[name])
    for alike in (_same_place, _same_way):
        found |= _alone(free, probes, found, alike)
    left = {one.name: _reason(one, probes, found) for i, one in free.items() if i not in found}
    if not found:
        raise InvalidValueError(
            f"{_origin(recording)}: none of its channels is a probe of the machine. Channels: "
            f"{'; '.join(f'{name} ({why})' for name, why in left.items()) or 'none but the tacho'}. Probes: "
            f"{'; '.join(map(_probe_words, probes))}. Say which is which with --probe CHANNEL=PROBE, or give unit, "
            "direction and location in recording.toml."
        )
    return Matched(dict(sorted(found.items())), left)


def as_probes(recording: Recording, matched: Matched) -> Recording:
    """Return the recording with the matched channels under the probes' names, and its tacho."""
    kept = [i for i, one in enumerate(recording.channels) if i in matched.probes or one.quantity == "tacho"]
    chosen = recording.select(kept)
    names = [matched.probes.get(i, recording.channels[i].name) for i in kept]
    channels = tuple(replace(one, name=name) for one, name in zip(chosen.channels, names, strict=True))
    return replace(chosen, channels=channels)


def probe_quantity(probe: Probe) -> str | None:
    """Return what a recording calls the probe's quantity; None when no recording holds its unit."""
    unit = parse_unit(probe.unit)
    return unit.quantity if unit else None


def _given_channel(recording: Recording, wanted: str) -> int:
    names = [one.name for one in recording.channels]
    found = channel_index(wanted, names)
    if found is not None:
        return found
    raise InvalidValueError(
        f"{_origin(recording)}: --probe names channel {wanted!r}; allowed: {', '.join(names)}, or a number from 1 to "
        f"{len(names)}. Correct it."
    )


def _check_quantity(recording: Recording, channel: Channel, probe: Probe) -> None:
    wanted = probe_quantity(probe)
    if wanted is None:
        raise InvalidValueError(
            f"{_origin(recording)}: probe {probe.name} is in {probe.unit}, which no recording holds; allowed: linear "
            "motion, angle or rotational speed. Choose another probe."
        )
    if channel.quantity == wanted:
        return
    said = f"is {_words(channel.quantity)}" if channel.quantity else "has no known unit"
    remedy = f"Give its unit with --unit ({SI_UNIT[wanted]}, ...)"
    if channel.quantity == "voltage":
        remedy = f"Give its --sensitivity (volts for {SI_UNIT[wanted]})"
    raise InvalidValueError(
        f"{_origin(recording)}: channel {channel.name} {said}; probe {probe.name} measures {_words(wanted)}. Nothing "
        f"is integrated or guessed. {remedy}, or choose another probe with --probe."
    )


def _alone(
    free: Mapping[int, Channel],
    probes: Sequence[Probe],
    found: Mapping[int, str],
    alike: Callable[[Channel, Probe], bool],
) -> dict[int, str]:
    """Return the pairs of channel and probe that are alike and have no other partner."""
    channels = {i: one for i, one in free.items() if i not in found}
    open_probes = [probe for probe in probes if probe.name not in found.values()]
    pairs = [(i, probe.name) for i, one in channels.items() for probe in open_probes if alike(one, probe)]
    numbers, names = [i for i, _ in pairs], [name for _, name in pairs]
    return {i: name for i, name in pairs if numbers.count(i) == 1 and names.count(name) == 1}


def _same_way(channel: Channel, probe: Probe) -> bool:
    way = SAME_WAY.get(channel.direction or "", channel.direction)
    return way == probe.direction and channel.quantity is not None and channel.quantity == probe_quantity(probe)


def _same_place(channel: Channel, probe: Probe) -> bool:
    return _same_way(channel, probe) and _plain(channel.location) == _plain(probe.location)


def _plain(text: str | None) -> str:
    return (text or "").replace("_", " ").strip().casefold()


def _reason(channel: Channel, probes: Sequence[Probe], found: Mapping[int, str]) -> str:
    if channel.quantity is None:
        return "unit not known: give --unit"
    if channel.quantity == "voltage":
        return "in volts: give --sensitivity"
    near = [p.name for p in probes if _same_way(channel, p) and p.name not in found.values()]
    if near:
        return f"could be {' or '.join(near)}: say which with --probe"
    if channel.direction is None:
        return f"{_words(channel.quantity)}, direction not known: say with --probe which probe it is"
    where = f"{channel.direction}, {channel.location}" if channel.location else channel.direction
    return f"{_words(channel.quantity)}, {where}: the machine has no such probe that is free"


def _probe_words(probe: Probe) -> str:
    return f"{probe.name} ({probe.quantity} in {probe.unit}, {probe.direction}, at {probe.location})"


def _words(quantity: str | None) -> str:
    return (quantity or "unknown").replace("_", " ")


def _origin(recording: Recording) -> str:
    return recording.provenance.path or "A recording"
