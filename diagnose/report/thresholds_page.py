"""The page of ``rotorwise thresholds``: a map of severity zones over misalignment, one panel a path."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import numpy as np

from ..misalignment_levels import Levels
from ..papers_files import write_whole
from ..zones.table import TABLE_UNIT_TO_SI
from .encode import numbers, to_json
from .papers_figure import Figure
from .text import escape
from .whole_page import whole_page
from .write import check_free


def write_page(
    title: str, judged_by: str, assumption: str, levels: Levels, clearance_m: float | None, path: Path, *, force: bool
) -> None:
    """Write the maps as one HTML file that needs no network.

    Parameters
    ----------
    title, judged_by, assumption : str
        Machine and speed; zone table and what it measures; what was assumed to choose it.
    levels : Levels
    clearance_m : float or None
        Beyond it parts touch; drawn as a line where displacements are judged.
    path : Path
        Its folder must exist.
    force : bool
        Whether an existing HTML page may be replaced.

    Raises
    ------
    ReportFileError, TableFileError
        When the file exists and ``force`` is not set, or the place cannot be written to.
    """
    figure = _figure(levels, clearance_m)
    made = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %z")
    body = (
        f'<main><p class="kicker"><b>rotorwise</b> thresholds · {made}</p>'
        f"<h1>How much misalignment {escape(title)} bears</h1>"
        f"<p>{escape(judged_by)}{escape('; ' + assumption if assumption else '')}.</p>{figure.html('map')}</main>"
    )
    content = to_json({"map": figure.payload()})
    script = f'<script type="application/json" class="figures">{content}</script>'
    page = whole_page(body, [script], title=f"Misalignment: {title}", scripts=("papers.js",), styles=("papers.css",))
    check_free(path.resolve(), force=force)
    write_whole(path, page)


def _figure(levels: Levels, clearance_m: float | None) -> Figure:
    row, made = levels.rows[0], levels.map
    unit = "um" if row.unit == "C_min" else row.unit
    scale = TABLE_UNIT_TO_SI[unit]
    limits = [limit / scale for limit in levels.limits]
    touches = clearance_m is not None and row.quantity == "displacement"
    panels = [
        {
            "name": name,
            "x": numbers(1e3 * made.offsets_m),
            "y": numbers(np.degrees(made.angles_rad)),
            "z": [numbers(line) for line in own.T / scale],
            "limits": limits,
            "contact": clearance_m / scale if touches and clearance_m is not None else None,
            "unit": unit,
        }
        for name, own in zip(made.probes, made.peaks, strict=True)
    ]
    words = ", ".join(f"{limit:.4g}" for limit in limits)
    others = [f"{other.quantity}, {other.detector}" for other in levels.rows[1:]]
    note = (
        f"Steady motion of the linear machine, {row.quantity}, {row.detector}. Zones A to D with limits at {words} "
        f"{unit}. Offset and angle have the same phase."
    )
    if others:
        note += f" {'; '.join(others)} is judged too, on the same scale; the worse counts."
    if touches and clearance_m is not None:
        note += f" Beyond the thick line, {clearance_m / scale:.4g} {unit}, parts touch and the model no longer holds."
    return Figure("Severity over misalignment", note, "Offset (mm)", "Angle (degrees)", {"": panels}, kind="zones")
