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
    """Return the probe of each channel by name: those that every recording has, and that show something in each.

    Raises
    ------
    InvalidValueError
        When there is no recording or no such channel.
    """
    if not campaign.recordings:
        raise InvalidValueError("The campaign has no recording; allowed: one or more to explain. Give recordings.")
    probes = _probe_names(machine)
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
    dead = _dead(campaign, shared)
    if len(dead) == len(shared):
        raise InvalidValueError(
            f"{', '.join(shared)}: the same value in all samples, or none; allowed: one channel that shows something "
            "in every recording. No sensor, no cable? Leave such recordings out."
        )
    return {name: name for name in shared if name not in dead}


def dead_words(campaign: Campaign, machine: Machine) -> tuple[str, ...]:
    """Return which probes were not compared because they show nothing in some recording."""
    dead = _dead(campaign, _in_all((*campaign.recordings, *campaign.baseline), _probe_names(machine)))
    return tuple(f"{name} has one value all the time in some recording, or none: not compared." for name in dead)


def _dead(campaign: Campaign, names: Sequence[str]) -> list[str]:
    every = (*campaign.recordings, *campaign.baseline)
    return [name for name in names if any(_is_dead(one, name) for one in every)]


def _is_dead(recording: Recording, name: str) -> bool:
    signal = recording.signals[[channel.name for channel in recording.channels].index(name)]
    seen = signal[np.isfinite(signal)]
    return not seen.size or bool(seen.min() == seen.max())


def not_shared(measured: Sequence[str], healthy: Sequence[str]) -> str:
    """Return the message that healthy recordings show nothing of what the others show."""
    return (
        f"The healthy recordings have no probe in common with the others: these have {', '.join(measured)}, the "
        f"healthy ones {', '.join(healthy)}; allowed: one or more in common. Say which channel is which with --probe, "
        "or leave the healthy recordings out."
    )


def _probe_names(machine: Machine) -> list[str]:
    return [probe.name for probe in machine.bare_assembly().probes]


def _in_all(recordings: Sequence[Recording], probes: Sequence[str]) -> list[str]:
    names = [{channel.name for channel in one.channels} for one in recordings]
    return [name for name in probes if all(name in own for own in names)]
