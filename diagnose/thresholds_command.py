"""``rotorwise thresholds``: how much misalignment a linear machine bears before it leaves a severity zone."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from .cli_options import option
from .decimal_option import decimal_option

if TYPE_CHECKING:
    from .misalignment_thresholds import PathLimit, ThresholdAnswer

_USAGE, _OUTPUT_FAILED = 2, 4

MachineName = Annotated[
    str, typer.Argument(help="Name of a shipped machine, or a machine file.", metavar="MACHINE|FILE.toml")
]
Speed = Annotated[float, decimal_option("--speed", value="RPM", text="Shaft speed.")]
Preset = Annotated[str, option("--preset", value="NAME", text="Preset; what a machine file states goes before it.")]
Settings = Annotated[
    list[str] | None, option("--set", value="NAME=VALUE", text="Parameter of the machine, SI units; repeat.")
]
OffsetMax = Annotated[
    float | None, decimal_option("--offset-max", value="M", text="Largest offset of the map, in metres.")
]
AngleMax = Annotated[
    float | None, decimal_option("--angle-max", value="DEG", text="Largest angle of the map, in degrees.")
]
Clearance = Annotated[
    float | None,
    decimal_option("--clearance", value="M", text="Smallest radial clearance; the machine's own when left out."),
]
Zones = Annotated[
    str, option("--zones", value="NAME", text="Zone table, for example 14839-2 or iso20816-3-group2-rigid.")
]
Output = Annotated[Path | None, option("--output", "-o", value="FILE.html", text="Write the maps here.")]
Force = Annotated[bool, option("--force", text="Replace an existing HTML page.")]
AsJson = Annotated[bool, option("--json", text="Print JSON.")]


def thresholds(
    machine: MachineName,
    speed: Speed,
    preset: Preset = "",
    settings: Settings = None,
    offset_max: OffsetMax = None,
    angle_max: AngleMax = None,
    clearance: Clearance = None,
    zones: Zones = "",
    output: Output = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Map the severity zones of a linear machine over parallel and angular misalignment of its coupling."""
    from .misalignment_thresholds import ThresholdAnswer, map_grid
    from .simulate_options import parse_machine
    from .waiting import waiting

    try:
        _check_ranges(offset_max, angle_max, clearance)
        chosen = parse_machine(machine, preset=preset, settings=settings or [], load=None)
        _check_output(output, force)
        with waiting(f"mapping {chosen.name}"):
            answer = ThresholdAnswer.of(chosen, speed, zones, clearance)
            levels = answer.levels(map_grid(answer, offset_max, angle_max))
            limits = answer.limits()
    except RotorwiseError as problem:
        # The zone tables speak of the option that `analyse` has.
        print(f"rotorwise: {problem}".replace("--severity-table", "--zones"), file=sys.stderr)
        raise typer.Exit(_USAGE) from None
    _show(answer, limits, as_json=as_json)
    if output is not None:
        from .report.thresholds_page import write_page

        try:
            write_page(answer.title, answer.words(), answer.assumption, levels, answer.clearance_m, output, force=force)
        except RotorwiseError as problem:
            print(f"rotorwise: {problem}", file=sys.stderr)
            raise typer.Exit(_OUTPUT_FAILED) from None
        print(f"map: {output}", file=sys.stderr if as_json else sys.stdout)


def _check_ranges(offset_max: float | None, angle_max: float | None, clearance: float | None) -> None:
    from .misalignment_thresholds import misalignment_bounds

    ends = misalignment_bounds()
    for name, value, end, unit in (
        ("--offset-max", offset_max, ends[0], "m"),
        ("--angle-max", angle_max, math.degrees(ends[1]), "degrees"),
        ("--clearance", clearance, 0.1, "m"),
    ):
        if value is not None and not 0 < value <= end:
            raise InvalidValueError(f"{name} {value:g}; allowed: more than 0, up to {end:.4g} {unit}. Correct it.")


def _check_output(output: Path | None, force: bool) -> None:
    if output is None:
        return
    if output.suffix.casefold() not in (".html", ".htm"):
        raise InvalidValueError(
            f"{output}: maps are written as HTML; allowed: a name that ends in .html. Save a picture from the page."
        )
    from .report.write import check_free

    check_free(output.resolve(), force=force)


def _show(answer: ThresholdAnswer, limits: list[PathLimit], *, as_json: bool) -> None:
    row = answer.rows[0]
    unit = "um" if row.unit == "C_min" else row.unit
    if as_json:
        content = {
            "machine": answer.machine.name,
            "preset": answer.machine.preset_name,
            "speed_rpm": answer.speed_rpm,
            "zones": row.id,
            "assumption": answer.assumption,
            "unit": unit,
            "boundaries": list(row.limits(speed_rpm=answer.speed_rpm, clearance_m=answer.clearance_m)),
            "paths": [asdict(limit) for limit in limits],
        }
        print(json.dumps(content, indent=2))
        return
    from rich.console import Console
    from rich.table import Table

    from .zones.table import TABLE_UNIT_TO_SI

    console = Console(highlight=False)
    console.print(f"[bold]{answer.title}[/]: largest misalignment in zone B")
    console.print(answer.words() + (f"; {answer.assumption}" if answer.assumption else ""))
    grid = Table(box=None, show_edge=False, padding=(0, 2, 0, 0))
    for heading in ("path", f"aligned ({unit})", "zone", "offset (mm)", "angle (degrees)"):
        grid.add_column(heading, justify="left" if heading in ("path", "zone") else "right")
    for one in limits:
        offset = None if one.largest_offset_m is None else 1e3 * one.largest_offset_m
        level = f"{one.aligned / TABLE_UNIT_TO_SI[unit]:.3g}"
        shown = _words(offset, one.offset_beyond), _words(one.largest_angle_deg, one.angle_beyond)
        grid.add_row(one.path, level, one.aligned_zone, *shown)
    console.print(grid)
    console.print("Offset without angle, angle without offset; linear steady motion.")


def _words(value: float | None, beyond: bool) -> str:
    return "none" if value is None else f"{'over ' if beyond else ''}{value:.3g}"
