"""``rotorwise sidebands``: families of sidebands, found blindly or looked for, and the shafts that they belong to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from ..simulators.errors import InvalidValueError
from . import cli_options as options
from .cli_options import option
from .look_options import AsJson, File, Force, Request, SpeedRange, Start, Stop, speed_range_hz

if TYPE_CHECKING:
    from .look import Answer, Looked

Carrier = Annotated[
    float | None, option("--carrier", value="HZ", text="Line to look at, with --spacing; found blindly when left out.")
]
Spacing = Annotated[float | None, option("--spacing", value="HZ", text="Distance of its sidebands.")]


def sidebands(
    file: File,
    carrier: Carrier = None,
    spacing: Spacing = None,
    teeth: options.Teeth = None,
    bearing: options.Bearing = None,
    line_frequency: options.LineFrequency = None,
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
    """Show the sidebands of a recording: carriers, spacings, which shaft has that speed, modulation index.

    Shafts come from --teeth or from a recording.toml beside the file.
    """
    record = options.record_metadata(rate, speed, tacho, pulses_per_revolution)
    channels = options.channel_metadata(unit, sensitivity, channel_name, None, skip)
    machine = options.machine_metadata(bearing, teeth, line_frequency, None, None, None, None)
    given = asked(carrier, spacing)
    speeds = speed_range_hz(speed_range)
    request = Request(
        file, record.merged_over(channels).merged_over(machine), sidecar, report, as_json, force, start, stop
    )

    def work(looked: Looked) -> Answer:
        from .line_families import measure
        from .report.sidebands_page import answer

        return answer(request.file.name, looked, measure(looked, asked=given, range_hz=speeds))

    from .look import carry_out

    raise typer.Exit(carry_out(request, work))


def asked(carrier_hz: float | None, spacing_hz: float | None) -> tuple[float, float] | None:
    """Return carrier and spacing where both are given, None where none is.

    Raises
    ------
    InvalidValueError
        When only one is given, or a value is not above 0.
    """
    if carrier_hz is None and spacing_hz is None:
        return None
    if carrier_hz is None or spacing_hz is None or not 0 < spacing_hz < carrier_hz < 1e9:
        raise InvalidValueError(
            f"Carrier {carrier_hz} Hz and spacing {spacing_hz} Hz; allowed: the carrier above the spacing, both "
            "above 0, or neither."
        )
    return carrier_hz, spacing_hz
