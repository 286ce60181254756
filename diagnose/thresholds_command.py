"""``rotorwise thresholds``: how much misalignment a linear machine bears before it leaves a severity zone."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from ..simulators.errors import InvalidValueError, RotorwiseError
from .cli_options import option
from .decimal_option import decimal_option

if TYPE_CHECKING:
    from ..simulators.machine import Machine
    from .misalignment_levels import Levels

_USAGE, _OUTPUT_FAILED = 2, 4
_CELLS, _FINE_CELLS = 101, 1001
#: Stability is judged with so many steps a turn: the error of the growth is far below any that matters.
_STEPS_A_TURN = 64
#: The picture reaches this far beyond what the most tolerant path bears.
_MARGIN = 1.25

MachineName = Annotated[
    str, typer.Argument(help="Name of a shipped machine, or a machine file.", metavar="MACHINE|FILE.toml")
]
Speed = Annotated[float, decimal_option("--speed", value="RPM", text="Shaft speed.")]
Preset = Annotated[str, option("--preset", value="NAME", text="Preset of the machine.")]
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


@dataclass(frozen=True)
class PathLimit:
    """What one probe bears: the largest offset without angle and the largest angle without offset within zone B.

    None where even the aligned machine is beyond; at the end of the range when ``..._beyond`` is set.
    """

    path: str
    aligned: float
    aligned_zone: str
    largest_offset_m: float | None
    offset_beyond: bool
    largest_angle_deg: float | None
    angle_beyond: bool


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
    from .simulate_options import parse_machine
    from .waiting import waiting

    try:
        _check_ranges(offset_max, angle_max, clearance)
        chosen = parse_machine(machine, preset=preset, settings=settings or [], load=None)
        _check_output(output, force)
        with waiting(f"mapping {chosen.name}"):
            answer = _Answer.of(chosen, speed, zones, clearance)
            levels = answer.levels(_grid(answer, offset_max, angle_max))
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


@dataclass(frozen=True)
class _Answer:
    machine: Machine
    speed_rpm: float
    clearance_m: float | None
    probes: list[Any]
    rows: list[Any]
    assumption: str

    @classmethod
    def of(cls, machine: Machine, speed_rpm: float, zones: str, clearance_m: float | None) -> _Answer:
        from ..datasets.recording import Channel
        from ..datasets.simulated import nameplate_of
        from ..datasets.units import parse_unit
        from .misalignment_levels import fitting
        from .zones.choose import automatic_table
        from .zones.table import find_table

        assembly = machine.assembly(speed_rpm=speed_rpm)
        # Before the table: a machine without a coupling has nothing to misalign, whatever its zones.
        assembly.component("coupling")
        _check_stable(machine, speed_rpm)
        plate = nameplate_of(machine)
        linear = [p for p in assembly.probes if p.unit in ("m", "m/s", "m/s2")]
        if zones:
            chosen = find_table(zones if zones[:1].isalpha() else f"iso{zones}")
        else:
            unit = parse_unit(linear[0].unit) if linear else None
            chosen = automatic_table(Channel("probe", unit.quantity if unit else None), plate)
        probes, rows = fitting(chosen.rows, linear, speed_rpm=speed_rpm)
        own = plate.magnetic_bearing_clearance_m if clearance_m is None else clearance_m
        return cls(machine, speed_rpm, own, probes, rows, chosen.assumption.replace("--severity-table", "--zones"))

    def levels(self, grid: tuple[np.ndarray, np.ndarray]) -> Levels:
        from .misalignment_levels import misalignment_levels

        return misalignment_levels(
            self.machine,
            speed_rpm=self.speed_rpm,
            offsets_m=grid[0],
            angles_rad=grid[1],
            probes=self.probes,
            rows=self.rows,
            clearance_m=self.clearance_m,
        )

    @cached_property
    def axes(self) -> tuple[Levels, Levels]:
        """Return the levels along both axes, as far as the effect's bounds reach."""
        ends, zero = _bounds(), np.zeros(1)
        fine = np.linspace(0.0, 1.0, _FINE_CELLS) ** 2
        return self.levels((ends[0] * fine, zero)), self.levels((zero, ends[1] * fine))

    def limits(self) -> list[PathLimit]:
        """Return what each path bears."""
        along_offset, along_angle = self.axes
        bound = along_offset.limits[1]
        offsets, angles = along_offset.map.peaks[:, :, 0], along_angle.map.peaks[:, 0, :]
        found = []
        for i, name in enumerate(along_offset.map.probes):
            offset, offset_beyond = largest(offsets[i], along_offset.map.offsets_m, bound)
            angle, angle_beyond = largest(angles[i], along_angle.map.angles_rad, bound)
            zone = "ABCD"[int(np.searchsorted(along_offset.limits, offsets[i, 0]))]
            degrees = None if angle is None else math.degrees(angle)
            found.append(PathLimit(name, float(offsets[i, 0]), zone, offset, offset_beyond, degrees, angle_beyond))
        return found

    @property
    def title(self) -> str:
        """Heading of table and page."""
        return f"{self.machine.name} ({self.machine.preset_name}) at {self.speed_rpm:g} rpm"

    def words(self) -> str:
        """Return what is judged by what."""
        rows = "; ".join(f"{row.quantity}, {row.detector}" for row in self.rows)
        return f"{self.rows[0].standard}, {self.rows[0].table} ({rows})"


def largest(levels: np.ndarray, values: np.ndarray, limit: float) -> tuple[float | None, bool]:
    """Return the largest value up to which the level stays within a limit, and whether that is the last value.

    Between two values the level is taken as straight. None when the first level is beyond already.

    Examples
    --------
    >>> largest(np.array([1.0, 2.0, 4.0]), np.array([0.0, 1.0, 2.0]), 3.0)
    (1.5, False)
    """
    beyond = np.flatnonzero(levels > limit)
    if not beyond.size:
        return float(values[-1]), True
    first = int(beyond[0])
    if first == 0:
        return None, False
    share = (limit - levels[first - 1]) / (levels[first] - levels[first - 1])
    return float(values[first - 1] + share * (values[first] - values[first - 1])), False


def _check_stable(machine: Machine, speed_rpm: float) -> None:
    """Raise InvalidValueError for an unstable machine: its steady motion can be computed, but no machine runs so.

    Misalignment only adds a force to a linear machine, so that it stays as stable as it is. Machines that are not
    linear are refused later, with the force that makes them so.
    """
    from ..simulators.solvers.floquet import floquet_multipliers

    if not machine.system(speed_rpm=speed_rpm).is_linear:
        return
    stability = floquet_multipliers(machine, speed_rpm=speed_rpm, steps=_STEPS_A_TURN)
    if not stability.is_stable:
        raise InvalidValueError(
            f"Machine {machine.name} ({machine.preset_name}) is unstable at {speed_rpm:g} rpm: a disturbance grows "
            f"with {stability.growth_rate_1_s:.3g} 1/s; allowed: stable machines. Choose another preset, speed or "
            "parameter."
        )


def _bounds() -> tuple[float, float]:
    from ..simulators.effects.coupling_misalignment import CouplingMisalignment

    ends = {declared.name: declared.bounds[1] for declared in CouplingMisalignment.parameters()}
    return ends["offset_m"], ends["angle_rad"]


def _grid(answer: _Answer, offset_max: float | None, angle_max: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the map's offsets and angles: as asked for, or a little beyond zone C of the most tolerant path."""
    ends = _bounds()
    wanted = [offset_max, None if angle_max is None else math.radians(angle_max)]
    if None in wanted:
        along = answer.axes
        borne = [
            [
                largest(row, values, levels.limits[2])[0] or 0.0
                for row in levels.map.peaks.reshape(len(levels.map.probes), -1)
            ]
            for levels, values in zip(along, (along[0].map.offsets_m, along[1].map.angles_rad), strict=True)
        ]
        reach = [min(_MARGIN * max(found) or end, end) for found, end in zip(borne, ends, strict=True)]
        wanted = [own if asked is None else asked for asked, own in zip(wanted, reach, strict=True)]
    offset, angle = (float(end) for end in wanted if end is not None)
    return np.linspace(0.0, offset, _CELLS), np.linspace(0.0, angle, _CELLS)


def _check_ranges(offset_max: float | None, angle_max: float | None, clearance: float | None) -> None:
    ends = _bounds()
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


def _show(answer: _Answer, limits: list[PathLimit], *, as_json: bool) -> None:
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
