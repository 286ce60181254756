"""What was understood of a campaign's files: speed, load, length of each, and which channel is which probe."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.recording import Recording
from ..terminal import escape
from .campaign import ReadCampaign, has_pulses
from .lines import ALIKE
from .observe import shaft_speed_rpm
from .plausible_sizes import unlike_words

if TYPE_CHECKING:
    from rich.console import Console

HEALTHY, EXPLAINED = "healthy", "to explain"
NO_HEALTHY = (
    "No recordings of the healthy machine: what differs from the model may be the model. Name some with --baseline, "
    "if there are any."
)
ONE_SPEED = (
    "All recordings to explain are of one speed: causes of one order (unbalance, bow, misaligned coupling) are told "
    "apart by their shape alone. Record at another speed as well, if the machine can."
)


def lacking_words(taken: ReadCampaign) -> list[str]:
    """Return what a campaign lacks, that an answer to it will be less sure of."""
    speeds = sorted(shaft_speed_rpm(one) for one in taken.campaign.recordings)
    said = [] if taken.campaign.baseline else [NO_HEALTHY]
    said += [ONE_SPEED] if speeds[-1] <= ALIKE * speeds[0] else []
    unlike = unlike_words(taken.campaign, taken.probes)
    return said + ([unlike] if unlike else [])


def campaign_data(taken: ReadCampaign) -> dict[str, Any]:
    """Return what was understood, as JSON types."""
    sets = ((EXPLAINED, taken.campaign.recordings), (HEALTHY, taken.campaign.baseline))
    return {
        "channels": dict(taken.channels),
        "sizes": _sizes(taken),
        "recordings": [_row(one, role) for role, recordings in sets for one in recordings],
        "notes": list(taken.notes),
        "unreadable": list(taken.unreadable),
    }


def _sizes(taken: ReadCampaign) -> dict[str, dict[str, Any]]:
    """Return quantity, unit and rms about the mean of each probe, the median of the recordings of each role."""
    campaign, found = taken.campaign, {}
    for name in taken.probes:
        channel = next(one for one in campaign.recordings[0].channels if one.name == name)
        own = {"quantity": channel.quantity, "unit": channel.unit, "rms": _rms(campaign.recordings, name)}
        found[name] = own | ({"healthy_rms": _rms(campaign.baseline, name)} if campaign.baseline else {})
    return found


def _rms(recordings: Sequence[Recording], name: str) -> float:
    rows = [[channel.name for channel in one.channels].index(name) for one in recordings]
    return float(np.median([np.nanstd(one.signals[row]) for one, row in zip(recordings, rows, strict=True)]))


def _size_words(one: dict[str, Any]) -> str:
    healthy = f", healthy {one['healthy_rms']:.3g}" if "healthy_rms" in one else ""
    return f"{one['rms']:.3g} {one['unit']} rms{healthy}"


def _row(one: Recording, role: str) -> dict[str, Any]:
    return {
        "file": Path(one.provenance.path or "").name,
        "role": role,
        "speed_rpm": shaft_speed_rpm(one),
        "speed_from": f"tacho, {one.pulses_per_revolution:g} a turn" if has_pulses(one) else "vibration",
        "load": one.condition.load,
        "load_unit": one.condition.load_unit,
        "duration_s": one.duration_s,
        "rate_hz": one.rate_hz,
    }


def show_campaign(taken: ReadCampaign, console: Console) -> None:
    """Print the recordings, the channels, and what was left out; in 80 columns."""
    from rich.table import Table

    data = campaign_data(taken)
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False)
    table.add_column("file", overflow="fold")
    for head in ("", "rpm", "from", "load", "s", "Hz"):
        table.add_column(head, justify="left" if head in ("", "from") else "right")
    for one in data["recordings"]:
        load = "" if one["load"] is None else f"{one['load']:g} {one['load_unit'] or ''}".rstrip()
        table.add_row(
            escape(one["file"]),
            one["role"],
            f"{one['speed_rpm']:.1f}",
            one["speed_from"],
            load,
            f"{one['duration_s']:.4g}",
            f"{one['rate_hz']:.6g}",
        )
    console.print(table)
    sized = (f"{taken.channels[name]} is {name} ({_size_words(one)})" for name, one in data["sizes"].items())
    console.print(f"channels: {escape(', '.join(sized))}")
    for note in data["notes"]:
        console.print(f"[dim]- {escape(note)}[/]")


def channel_words(taken: ReadCampaign) -> str:
    """Return which channel is which probe."""
    return ", ".join(f"{channel} is {probe}" for probe, channel in taken.channels.items())


def read_words(taken: ReadCampaign) -> str:
    """Return one sentence: how many recordings at which speeds, and which channel is which probe."""
    counts = [_counted(taken.campaign.recordings, "recording")]
    if taken.campaign.baseline:
        counts.append(_counted(taken.campaign.baseline, "healthy one"))
    return f"{'; '.join(counts)}; {channel_words(taken)}"


def _counted(recordings: Sequence[Recording], what: str) -> str:
    speeds = sorted(shaft_speed_rpm(one) for one in recordings)
    where = f"{speeds[0]:.0f}" if len(speeds) == 1 else f"{speeds[0]:.0f} to {speeds[-1]:.0f}"
    return f"{len(recordings)} {what}{'s' if len(recordings) > 1 else ''} at {where} rpm"
