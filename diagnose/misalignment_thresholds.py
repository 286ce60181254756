"""What misalignment a linear machine bears before it leaves a severity zone: the answer of ``rotorwise thresholds``.

Apart from the command's options, so that ``rotorwise --help`` need not load numpy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..datasets.recording import Channel
from ..datasets.simulated import nameplate_of
from ..datasets.units import parse_unit
from ..simulators.assembly import Probe
from ..simulators.effects.coupling_misalignment import CouplingMisalignment
from ..simulators.errors import InvalidValueError
from ..simulators.machine import Machine
from ..simulators.solvers.floquet import floquet_multipliers
from .misalignment_levels import Levels, fitting, misalignment_levels
from .zones.choose import automatic_table
from .zones.table import ZoneRow, find_table

_CELLS, _FINE_CELLS = 101, 1001
#: Stability is judged with so many steps a turn: the error of the growth is far below any that matters.
_STEPS_A_TURN = 64
#: The picture reaches this far beyond what the most tolerant path bears.
_MARGIN = 1.25


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


@dataclass(frozen=True)
class ThresholdAnswer:
    """A linear machine at one speed with the probes that a zone table can judge.

    Attributes
    ----------
    clearance_m : float or None
        Smallest radial clearance of magnetic bearings.
    probes, rows : list
        Probes that the table's rows can judge, and those rows; the first row gives the scale.
    assumption : str
        What was assumed in choosing the table.
    """

    machine: Machine
    speed_rpm: float
    clearance_m: float | None
    probes: list[Probe]
    rows: list[ZoneRow]
    assumption: str

    @classmethod
    def of(cls, machine: Machine, speed_rpm: float, zones: str, clearance_m: float | None) -> ThresholdAnswer:
        """Return what to judge: ``zones`` names a table, an empty text takes the one that fits the machine.

        Raises
        ------
        InvalidValueError
            A machine without a coupling, one that is unstable, or probes that no row of the table can judge.
        """
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
        """Return the levels over offsets in metres and angles in radians."""
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
        ends, zero = misalignment_bounds(), np.zeros(1)
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
    if not machine.system(speed_rpm=speed_rpm).is_linear:
        return
    stability = floquet_multipliers(machine, speed_rpm=speed_rpm, steps=_STEPS_A_TURN)
    if not stability.is_stable:
        raise InvalidValueError(
            f"Machine {machine.name} ({machine.preset_name}) is unstable at {speed_rpm:g} rpm: a disturbance grows "
            f"with {stability.growth_rate_1_s:.3g} 1/s; allowed: stable machines. Choose another preset, speed or "
            "parameter."
        )


def misalignment_bounds() -> tuple[float, float]:
    """Return the largest offset in metres and the largest angle in radians that the effect takes."""
    ends = {declared.name: declared.bounds[1] for declared in CouplingMisalignment.parameters()}
    return ends["offset_m"], ends["angle_rad"]


def map_grid(
    answer: ThresholdAnswer, offset_max_m: float | None, angle_max_deg: float | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the map's offsets (m) and angles (rad): as asked for, or a little beyond zone C of the most tolerant."""
    ends = misalignment_bounds()
    wanted = [offset_max_m, None if angle_max_deg is None else math.radians(angle_max_deg)]
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
