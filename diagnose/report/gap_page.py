"""The report of ``rotorwise gap``: the verdict, measured against simulated, residuals, candidates, gain."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from ..gap.result import GapResult
from ..gap.words import headline, sentence_of
from ..papers_files import write_whole
from .encode import to_json
from .gap_blocks import (
    calibration_block,
    candidates_block,
    causes_block,
    extended_block,
    gain_block,
    left_out_block,
    limits_block,
    printed,
    residual_table,
    warnings_block,
)
from .gap_figures import gap_figures, gap_payload
from .text import escape
from .whole_page import whole_page
from .write import check_free


def write_gap_page(
    result: GapResult, path: Path, *, title: str = "", notes: Sequence[str] = (), force: bool = False
) -> None:
    """Write a result as one HTML file that needs no network.

    Parameters
    ----------
    result : GapResult
    path : Path
        Its folder must exist.
    title : str
        Name of the campaign.
    notes : sequence of str
        What the reading of the files left out and assumed.
    force : bool
        Whether an existing HTML page may be replaced.

    Raises
    ------
    ReportFileError, TableFileError
        When the file exists and ``force`` is not set, or the place cannot be written to.
    MissingAssetError
        When plotly's script is not installed.
    """
    page = render_gap(result, title=title, notes=notes)
    check_free(path.resolve(), force=force)
    write_whole(path, page)


def render_gap(result: GapResult, *, title: str = "", notes: Sequence[str] = ()) -> str:
    """Return the page; see `write_gap_page`."""
    made = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %z")
    name = " · ".join(filter(None, [title, f"{result.machine.name} ({result.machine.preset_name})"]))
    # The heading says the cause; the rest of the verdict follows it.
    first, whole = headline(result), sentence_of(result)
    rest = " ".join(whole.replace(first, "").split())
    body = (
        '<main><article class="file" data-payload="gap">'
        f'<p class="kicker"><b>rotorwise</b> gap · <span class="path">{escape(name)}</span> · {made}</p>'
        f'<h1 class="verdict">{printed(first)}</h1><p class="lead">{printed(rest)}</p>'
        f"{warnings_block((*notes, *result.remarks))}"
        f'<div class="answer"><section><h2>Cause</h2>{causes_block(result)}</section>'
        f"<section><h2>Candidates</h2>{candidates_block(result)}<h2>Gain</h2>{gain_block(result)}</section></div>"
        f"<section><h2>Measured and simulated</h2>{gap_figures(result)}</section>"
        f"<section><h2>Largest residuals</h2>{residual_table(result)}</section>"
        f"<section><h2>What was not compared, and why</h2>{left_out_block(result)}"
        f"{limits_block(result)}</section>"
        f"<section><h2>The machine</h2>{calibration_block(result)}{extended_block(result)}</section></article></main>"
    )
    data = f'<script type="application/json" id="data-gap">{to_json(gap_payload(result))}</script>'
    return whole_page(body, [data], title=f"Gap: {name}", scripts=("gap.js", "report.js"), styles=("gap.css",))
