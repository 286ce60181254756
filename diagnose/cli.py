"""The ``rotorwise`` command.

Exit codes: 0 all files analysed; 1 a bug in rotorwise; 2 wrong usage; 3 at least one file could not be analysed (the
others were); 4 an output file could not be written.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

_FILES_IN_FULL = 3  # more files than this are shown as one table

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Condition monitoring of rotating machines: from a vibration file to a ranked diagnosis with its evidence.",
    epilog="Exit codes: 0 done, 2 wrong usage, 3 a file could not be analysed, 4 an output could not be written.",
)

Files = Annotated[list[Path], typer.Argument(help="Recordings or folders of recordings.", show_default=False)]
Text = str | None
Number = float | None


def _option(*names: str, text: str) -> Any:
    return typer.Option(*names, help=text, show_default=False)


@app.callback(invoke_without_command=True)
def _about(
    version: Annotated[bool, _option("--version", text="Print the version and leave.")] = False,
) -> None:
    if version:
        from importlib.metadata import version as installed

        typer.echo(installed("rotorwise"))
        raise typer.Exit


@app.command()
def analyse(
    files: Files,
    speed: Annotated[
        Number, _option("--speed", text="Nominal shaft speed, rpm. A hint: the true one is looked for.")
    ] = None,
    baseline: Annotated[
        list[Path] | None,
        _option("--baseline", text="Healthy record of the same machine; repeat for several speeds."),
    ] = None,
    bearing: Annotated[
        list[str] | None,
        _option(
            "--bearing",
            text="6205, or balls,ball mm,pitch mm[,angle deg], or BPFO=3.05,BPFI=4.95; LOCATION= in front; repeat.",
        ),
    ] = None,
    teeth: Annotated[Text, _option("--teeth", text="Gear teeth, driver/driven: 23/46.")] = None,
    rate: Annotated[Number, _option("--rate", text="Sampling rate, Hz, when the file has none.")] = None,
    unit: Annotated[
        list[str] | None, _option("--unit", text="g, m/s2, mm/s, um, V, ...; repeat: one a channel.")
    ] = None,
    sensitivity: Annotated[
        list[str] | None,
        _option("--sensitivity", text='Of a sensor in volts: "100 mV/g"; repeat: one a channel.'),
    ] = None,
    channel_name: Annotated[list[str] | None, _option("--channel-name", text="Name; repeat: one a channel.")] = None,
    direction: Annotated[
        list[str] | None,
        _option("--direction", text="horizontal, vertical, axial, ...; repeat: one a channel."),
    ] = None,
    skip: Annotated[list[str] | None, _option("--skip", text="Channel to leave out, name or number; repeat.")] = None,
    tacho: Annotated[Text, _option("--tacho", text="Channel with speed pulses, name or number.")] = None,
    pulses_per_revolution: Annotated[Number, _option("--pulses-per-revolution", text="Of the tacho.")] = None,
    line_frequency: Annotated[Number, _option("--line-frequency", text="Electrical supply, Hz.")] = None,
    severity_table: Annotated[
        Text, _option("--severity-table", text="Zone table, for example iso20816-3-group2.")
    ] = None,
    mounting: Annotated[Text, _option("--mounting", text="rigid or flexible.")] = None,
    power: Annotated[Number, _option("--power", text="Rated power, kW: chooses the zone table.")] = None,
    shaft_height: Annotated[Number, _option("--shaft-height", text="Shaft height, mm: chooses the zone table.")] = None,
    sidecar: Annotated[
        Path | None, _option("--sidecar", text="recording.toml to use instead of the one beside the file.")
    ] = None,
    report: Annotated[Path | None, _option("--report", text="Write an HTML report here.")] = None,
    as_json: Annotated[bool, _option("--json", text="Print JSON: a list with one object a file.")] = False,
    recursive: Annotated[bool, _option("--recursive", text="Look into sub-folders too.")] = False,
    force: Annotated[bool, _option("--force", text="Replace an existing report.")] = False,
) -> None:
    """Diagnose recordings: ranked faults with evidence, severity zone, data quality.

    What a file lacks comes from these options or from a recording.toml beside it.
    """
    from ..datasets.metadata import Metadata, parse_bearing, parse_gears

    metadata = Metadata(
        rate_hz=rate,
        units=tuple(unit or ()),
        sensitivities=tuple(sensitivity or ()),
        channel_names=tuple(channel_name or ()),
        directions=tuple(direction or ()),
        skip=tuple(skip or ()),
        tacho=tacho,
        pulses_per_revolution=pulses_per_revolution,
        speed_rpm=speed,
        bearings=tuple(parse_bearing(one) for one in bearing or ()),
        gears=parse_gears(teeth) if teeth else (),
        line_frequency_hz=line_frequency,
        severity_table=severity_table,
        mounting=mounting,
        power_kw=power,
        shaft_height_mm=shaft_height,
    )
    from .run import Request, run

    raise typer.Exit(
        run(
            Request(
                files=tuple(files),
                metadata=metadata,
                sidecar=sidecar,
                baseline=tuple(baseline or ()),
                report=report,
                as_json=as_json,
                recursive=recursive,
                force=force,
                files_in_full=_FILES_IN_FULL,
            )
        )
    )


@app.command()
def demo(
    output: Annotated[Path, _option("--output", "-o", text="Folder for the example and its report.")] = Path(
        "rotorwise-demo"
    ),
    force: Annotated[bool, _option("--force", text="Replace an earlier demonstration.")] = False,
) -> None:
    """Make an example machine with three faults, diagnose it and write the report."""
    from ..datasets.metadata import Metadata
    from .demo import write_demo
    from .run import Request, run

    files = write_demo(output, force=force)
    report = output / "report.html"
    code = run(
        Request(
            files=tuple(files[1:]),
            metadata=Metadata(),
            baseline=(files[0],),
            report=report,
            force=force,
            files_in_full=4,
        )
    )
    raise typer.Exit(code)


def main() -> None:
    """Run the command; errors of rotorwise become a message and an exit code, never a traceback."""
    from ..simulators.errors import RotorwiseError

    try:
        app()
    except RotorwiseError as problem:
        typer.echo(f"rotorwise: {problem}", err=True)
        sys.exit(2)
    except KeyboardInterrupt:
        typer.echo("rotorwise: stopped.", err=True)
        sys.exit(130)
    except BrokenPipeError:
        # The reader of our output left (for example `| head`); nothing is wrong.
        sys.stderr.close()
        sys.exit(0)
