"""``rotorwise envelope``: kurtogram, envelope spectrum and its lines, named by bearing and shaft."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from ..simulators.errors import InvalidValueError
from . import cli_options as options
from .cli_options import option
from .look_options import AsJson, File, Force, Request, SpeedRange, Start, Stop, speed_range_hz

if TYPE_CHECKING:
    from .look import Answer, Looked

#: What may be done to a signal before its envelope is taken.
PREPARATIONS = ("none", "random", "prewhiten")

Band = Annotated[
    str | None, option("--band", value="LOW-HIGH", text="Band in Hz: 2000-4000. Left out: the kurtogram's choice.")
]
Prepare = Annotated[
    str,
    option(
        "--prepare", value="NAME", text="none; random: without exactly repeating lines; prewhiten: all lines equal."
    ),
]


def envelope(
    file: File,
    band: Band = None,
    prepare: Prepare = "none",
    bearing: options.Bearing = None,
    speed_range: SpeedRange = None,
    start: Start = 0.0,
    stop: Stop = None,
    speed: options.Speed = None,
    tacho: options.Tacho = None,
    pulses_per_revolution: options.Pulses = None,
    rate: options.Rate = None,
    unit: options.Unit = None,
    sensitivity: options.Sensitivity = None,
    channel_name: options.ChannelName = None,
    skip: options.Skip = None,
    sidecar: options.Sidecar = None,
    report: options.Report = None,
    as_json: AsJson = False,
    force: Force = False,
) -> None:
    """Show the envelope of a recording: kurtogram, best band, squared envelope spectrum with named lines.

    Bearing orders come from --bearing or from a recording.toml beside the file.
    """
    record = options.record_metadata(rate, speed, tacho, pulses_per_revolution)
    channels = options.channel_metadata(unit, sensitivity, channel_name, None, skip)
    machine = options.machine_metadata(bearing, None, None, None, None, None, None)
    if prepare not in PREPARATIONS:
        raise InvalidValueError(f"Preparation {prepare!r}; allowed: {', '.join(PREPARATIONS)}.")
    limits, speeds = band_hz(band), speed_range_hz(speed_range)
    request = Request(
        file, record.merged_over(channels).merged_over(machine), sidecar, report, as_json, force, start, stop
    )

    def work(looked: Looked) -> Answer:
        from .envelopes import measure
        from .report.envelope_page import answer

        found = measure(looked, band_hz=limits, prepare=prepare, range_hz=speeds)
        return answer(request.file.name, looked, found)

    from .look import carry_out

    raise typer.Exit(carry_out(request, work))


def band_hz(text: str | None) -> tuple[float, float] | None:
    """Return a band given as ``2000-4000`` Hz.

    Raises
    ------
    InvalidValueError
        For anything else.
    """
    if text is None:
        return None
    try:
        low, high = (float(part) for part in text.replace("\u2013", "-").split("-"))
    except ValueError:
        low = high = float("nan")
    if not 0 <= low < high < float("inf"):
        raise InvalidValueError(f"Band {text!r}; allowed: two numbers, the lower one first. Write 2000-4000.")
    return low, high
