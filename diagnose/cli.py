"""The ``rotorwise`` command.

Exit codes: 0 all files analysed; 1 a bug in rotorwise; 2 wrong usage; 3 at least one file could not be analysed (the
others were); 4 an output file could not be written.
"""

from __future__ import annotations

import sys
from pathlib import Path

import typer

from . import cli_options as options
from .dataset_command import dataset
from .effects_command import effects
from .envelope_command import envelope
from .evaluate_command import evaluate
from .gap_command import gap
from .machines_command import machines
from .orders_command import orders
from .papers import papers
from .severity_command import severity
from .sidebands_command import sidebands
from .simulate_command import simulate
from .thresholds_command import thresholds
from .train_command import train
from .trials_command import trials

_FILES_IN_FULL = 3  # more files than this are shown as one table
_USAGE, _OUTPUT, _INTERRUPTED = 2, 4, 130

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Condition monitoring of rotating machines: from a vibration file to a ranked diagnosis with its evidence.",
    epilog="Exit codes: 0 done, 2 wrong usage, 3 a file could not be analysed, 4 an output could not be written.",
)


@app.callback(invoke_without_command=True)
def _about(version: options.Version = False) -> None:
    if version:
        from importlib.metadata import version as installed

        typer.echo(installed("rotorwise"))
        raise typer.Exit


@app.command()
def analyse(
    files: options.Files,
    speed: options.Speed = None,
    baseline: options.Baseline = None,
    bearing: options.Bearing = None,
    teeth: options.Teeth = None,
    rate: options.Rate = None,
    unit: options.Unit = None,
    sensitivity: options.Sensitivity = None,
    channel_name: options.ChannelName = None,
    direction: options.Direction = None,
    skip: options.Skip = None,
    tacho: options.Tacho = None,
    pulses_per_revolution: options.Pulses = None,
    line_frequency: options.LineFrequency = None,
    severity_table: options.SeverityTable = None,
    mounting: options.Mounting = None,
    power: options.Power = None,
    shaft_height: options.ShaftHeight = None,
    sidecar: options.Sidecar = None,
    report: options.Report = None,
    as_json: options.AsJson = False,
    recursive: options.Recursive = False,
    force: options.Force = False,
) -> None:
    """Diagnose recordings: ranked faults with evidence, severity zone, data quality.

    What a file lacks comes from these options or from a recording.toml beside it.
    """
    record = options.record_metadata(rate, speed, tacho, pulses_per_revolution)
    channels = options.channel_metadata(unit, sensitivity, channel_name, direction, skip)
    machine = options.machine_metadata(bearing, teeth, line_frequency, severity_table, mounting, power, shaft_height)
    from .run import Request, run

    request = Request(
        files=tuple(files),
        metadata=record.merged_over(channels).merged_over(machine),
        sidecar=sidecar,
        baseline=tuple(baseline or ()),
        report=report,
        as_json=as_json,
        recursive=recursive,
        force=force,
        files_in_full=_FILES_IN_FULL,
    )
    raise typer.Exit(run(request))


@app.command()
def demo(
    output: options.Output = Path("rotorwise-demo"),
    pump: options.DemoPump = False,
    force: options.DemoForce = False,
) -> None:
    """Find out what a simulated rotor lacks from shipped recordings of one whose fault is sealed; write the report."""
    from .demo import DemoFolderError, run_demo, run_pump

    try:
        code = run_pump(output, force=force) if pump else run_demo(output, force=force)
    except DemoFolderError as problem:
        typer.echo(f"rotorwise: {problem}", err=True)
        raise typer.Exit(_OUTPUT) from None
    raise typer.Exit(code)


app.add_typer(dataset, name="dataset")
app.add_typer(severity, name="severity")
app.command()(papers)
app.command()(effects)
app.command()(envelope)
app.command()(evaluate)
app.command()(gap)
app.command()(machines)
app.command()(orders)
app.command()(sidebands)
app.command()(simulate)
app.command()(thresholds)
app.command()(train)
app.command()(trials)


def main() -> None:
    """Run the command; errors of rotorwise become a message and an exit code, never a traceback."""
    from ..simulators.errors import RotorwiseError

    for stream in (sys.stdout, sys.stderr):
        # A file name that the terminal's character set lacks is shown with marks, not as a crash.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # pyright: ignore[reportAttributeAccessIssue]
    try:
        app()
        sys.stdout.flush()
    except SystemExit as leaving:
        # typer and rich answer a broken pipe with 1, which is our code for a bug.
        if isinstance(leaving.__context__, BrokenPipeError):
            _leave(0)
        try:
            # What is still to be written would fail when Python ends, where nothing can answer it.
            sys.stdout.flush()
        except BrokenPipeError:
            _leave(leaving.code if isinstance(leaving.code, int) else 0)
        raise
    except RotorwiseError as problem:
        typer.echo(f"rotorwise: {problem}", err=True)
        sys.exit(_USAGE)
    except KeyboardInterrupt:
        typer.echo("rotorwise: stopped.", err=True)
        sys.exit(_INTERRUPTED)
    except BrokenPipeError:
        # The reader of our output left (for example `| head`); nothing is wrong.
        _leave(0)
    except OSError as problem:
        typer.echo(f"rotorwise: output cannot be written: {problem.strerror or problem}.", err=True)
        _leave(_OUTPUT)


def _leave(code: int) -> None:
    """Leave at once: flushing what cannot be written would raise again."""
    import os

    os._exit(code)
