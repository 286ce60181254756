"""The options of ``rotorwise analyse`` and the metadata that they make."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from ..datasets.metadata import Metadata


def option(*names: str, text: str, value: str | None = None) -> Any:
    """Return a typer option that shows no default; ``value`` is what the help calls its value."""
    return typer.Option(*names, help=text, metavar=value, show_default=False)


Files = Annotated[
    list[Path], typer.Argument(help="Recordings or folders of recordings.", metavar="FILE...", show_default=False)
]
Speed = Annotated[
    float | None, option("--speed", value="RPM", text="Nominal shaft speed. A hint: the true one is looked for.")
]
Baseline = Annotated[
    list[Path] | None,
    option("--baseline", value="FILE", text="Healthy record of the same machine; repeat for several speeds."),
]
Bearing = Annotated[
    list[str] | None,
    option(
        "--bearing",
        value="TEXT",
        text="6205, or balls,ball mm,pitch mm[,angle deg], or BPFO=3.05,BPFI=4.95; LOCATION= in front; repeat.",
    ),
]
Teeth = Annotated[
    str | None, option("--teeth", value="TEXT", text="Gear teeth, driver/driven: 23/46; several pairs: 23/46,12/40.")
]
Rate = Annotated[
    float | None, option("--rate", value="HZ", text="Sampling rate, when the file has none or a wrong one.")
]
Unit = Annotated[
    list[str] | None,
    option("--unit", value="UNIT", text="g, m/s2, mm/s, um, V, ...; repeat: one a channel, in the file's order."),
]
Sensitivity = Annotated[
    list[str] | None,
    option("--sensitivity", value="TEXT", text='Of a sensor in volts: "100 mV/g"; repeat: one a channel.'),
]
ChannelName = Annotated[list[str] | None, option("--channel-name", value="NAME", text="Name; repeat: one a channel.")]
Direction = Annotated[
    list[str] | None,
    option("--direction", value="NAME", text="horizontal, vertical, axial, ...; repeat: one a channel."),
]
Skip = Annotated[
    list[str] | None, option("--skip", value="CHANNEL", text="Channel to leave out, name or number; repeat.")
]
Tacho = Annotated[str | None, option("--tacho", value="CHANNEL", text="Channel with speed pulses, name or number.")]
Pulses = Annotated[float | None, option("--pulses-per-revolution", value="NUMBER", text="Of the tacho.")]
LineFrequency = Annotated[float | None, option("--line-frequency", value="HZ", text="Electrical supply.")]
SeverityTable = Annotated[
    str | None, option("--severity-table", value="NAME", text="Zone table, for example iso20816-3-group2.")
]
Mounting = Annotated[str | None, option("--mounting", value="NAME", text="rigid or flexible.")]
Power = Annotated[float | None, option("--power", value="KW", text="Rated power: chooses the zone table.")]
ShaftHeight = Annotated[
    float | None, option("--shaft-height", value="MM", text="Shaft height: chooses the zone table.")
]
Sidecar = Annotated[
    Path | None, option("--sidecar", value="FILE", text="recording.toml to use instead of the one beside the file.")
]
Report = Annotated[Path | None, option("--report", value="FILE", text="Write an HTML report here.")]
AsJson = Annotated[bool, option("--json", text="Print JSON: a list with one object a file.")]
Recursive = Annotated[bool, option("--recursive", text="Look into sub-folders too.")]
Force = Annotated[bool, option("--force", text="Replace an existing report.")]
Output = Annotated[Path, option("--output", "-o", value="FOLDER", text="Folder for the example and its report.")]
DemoPump = Annotated[
    bool, option("--analyse", text="Instead: make recordings of a pump with three faults and diagnose each.")
]
DemoForce = Annotated[bool, option("--force", text="Replace an earlier demonstration.")]
Version = Annotated[bool, option("--version", text="Print the version and leave.")]

Texts = list[str] | None
Number = float | None


def record_metadata(rate: Number, speed: Number, tacho: str | None, pulses_per_revolution: Number) -> Metadata:
    """Return what the options say of the record."""
    from ..datasets.metadata import Metadata

    return Metadata(rate_hz=rate, speed_rpm=speed, tacho=tacho, pulses_per_revolution=pulses_per_revolution)


def channel_metadata(units: Texts, sensitivities: Texts, names: Texts, directions: Texts, skip: Texts) -> Metadata:
    """Return what the options say of the channels."""
    from ..datasets.metadata import Metadata

    return Metadata(
        units=tuple(units or ()),
        sensitivities=tuple(sensitivities or ()),
        channel_names=tuple(names or ()),
        directions=tuple(directions or ()),
        skip=tuple(skip or ()),
    )


def machine_metadata(
    bearings: Texts,
    teeth: str | None,
    line_frequency: Number,
    severity_table: str | None,
    mounting: str | None,
    power: Number,
    shaft_height: Number,
) -> Metadata:
    """Return what the options say of the machine."""
    from ..datasets.metadata import Metadata, parse_bearing, parse_gears

    return Metadata(
        bearings=tuple(parse_bearing(one) for one in bearings or ()),
        gears=parse_gears(teeth) if teeth else (),
        line_frequency_hz=line_frequency,
        severity_table=severity_table,
        mounting=mounting,
        power_kw=power,
        shaft_height_mm=shaft_height,
    )
