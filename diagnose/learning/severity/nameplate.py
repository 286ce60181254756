"""What the estimators' machine is known to be, where a recording does not say: both zones are then of one table."""

from __future__ import annotations

from dataclasses import fields, replace

from ....datasets.recording import Channel, Recording
from ....datasets.simulated import channel_of, nameplate_of
from ....simulators.machine import Machine


def of_machine(recording: Recording, machine: Machine) -> Recording:
    """Return a recording with the machine's nameplate and its probes' places where it says nothing of its own."""
    own, known = recording.nameplate, nameplate_of(machine)
    missing = {one.name: getattr(known, one.name) for one in fields(own) if not getattr(own, one.name)}
    probes = {probe.name: channel_of(probe) for probe in machine.bare_assembly().probes}
    channels = tuple(_placed(channel, probes.get(channel.name)) for channel in recording.channels)
    return replace(recording, nameplate=replace(own, **missing), channels=channels)


def _placed(channel: Channel, probe: Channel | None) -> Channel:
    if probe is None:
        return channel
    return replace(channel, location=channel.location or probe.location, direction=channel.direction or probe.direction)
