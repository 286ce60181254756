"""What is asked of the engine, checked before any work: names of effects, the machine, recordings with a signal."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Sequence

import numpy as np

from ...datasets.recording import Campaign, Recording
from ...simulators.effect import effect_catalogue
from ...simulators.errors import InvalidValueError
from ...simulators.machine import Machine


def known_effects(names: Collection[str], said: str) -> frozenset[str]:
    """Return the names of effects, checked; ``said`` is what the user calls them ("--without").

    Raises
    ------
    InvalidValueError
        For a name that the catalogue does not have, or one name where several are asked for.
    """
    if isinstance(names, str):
        raise InvalidValueError(f"{said} = {names!r}; allowed: a set of names. Write {{{names!r}}}.")
    catalogue = effect_catalogue() if names else {}
    for name in names:
        if name not in catalogue:
            near = difflib.get_close_matches(str(name), catalogue, n=1)
            advice = f"Did you mean {near[0]}?" if near else "rotorwise effects lists them."
            raise InvalidValueError(f"{said} {name!r}: no such effect; allowed: names of the catalogue. {advice}")
    return frozenset(names)


def check_machine(machine: Machine) -> None:
    """Refuse what is no machine.

    Raises
    ------
    InvalidValueError
    """
    if not isinstance(machine, Machine):
        raise InvalidValueError(
            f"Machine {machine!r}; allowed: a Machine. rotorwise.simulators.machine.find_machine gives one by its name."
        )


def shared_probes(campaign: Campaign, machine: Machine) -> dict[str, str]:
    """Return the probe of each channel by name: those that every recording has.

    Raises
    ------
    InvalidValueError
        When there is no recording, no such channel, or one that shows nothing.
    """
    if not campaign.recordings:
        raise InvalidValueError("The campaign has no recording; allowed: one or more to explain. Give recordings.")
    probes = [probe.name for probe in machine.bare_assembly().probes]
    sets = [_in_all(own, probes) for own in (campaign.recordings, campaign.baseline) if own]
    for own, what in zip(sets, ("recordings", "healthy recordings"), strict=False):
        if not own:
            some = campaign.recordings if what == "recordings" else campaign.baseline
            there = ", ".join(channel.name for channel in some[0].channels)
            raise InvalidValueError(
                f"No channel is a probe of {machine.name} in all {what}: they have {there}; the machine has "
                f"{', '.join(probes)}. Say which is which with --probe CHANNEL=PROBE."
            )
    shared = [name for name in sets[0] if name in sets[-1]]
    if not shared:
        raise InvalidValueError(not_shared(sets[0], sets[1]))
    for one in (*campaign.recordings, *campaign.baseline):
        _check_alive(one, shared)
    return {name: name for name in shared}


def not_shared(measured: Sequence[str], healthy: Sequence[str]) -> str:
    """Return the message that healthy recordings show nothing of what the others show."""
    return (
        f"The healthy recordings have no probe in common with the others: these have {', '.join(measured)}, the "
        f"healthy ones {', '.join(healthy)}; allowed: one or more in common. Say which channel is which with --probe, "
        "or leave the healthy recordings out."
    )


def _in_all(recordings: Sequence[Recording], probes: Sequence[str]) -> list[str]:
    names = [{channel.name for channel in one.channels} for one in recordings]
    return [name for name in probes if all(name in own for own in names)]


def _check_alive(recording: Recording, names: Sequence[str]) -> None:
    for channel, signal in zip(recording.channels, recording.signals, strict=True):
        seen = signal[np.isfinite(signal)] if channel.name in names else None
        if seen is not None and (not seen.size or seen.min() == seen.max()):
            what = "the same value in all samples" if seen.size else "no samples that are numbers"
            raise InvalidValueError(
                f"{recording.provenance.path or 'A recording'}: channel {channel.name} has {what}; allowed: a signal. "
                "No sensor, no cable? Leave the channel out of all recordings, or the recording."
            )
