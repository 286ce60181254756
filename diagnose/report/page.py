"""The page as a whole."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any

from ...simulators.errors import InvalidValueError
from ..result import Analysis
from .encode import to_json
from .figures import figures
from .findings import facts_block, findings_block, remarks_block, speed_block, warnings_block
from .gauge import severity_block
from .payload import build_payload, point_limit, short_name
from .tables import evidence_table, feature_table, sortable_table
from .text import escape
from .trend import blocks_trend, files_trend, overview_table_rows, trend_figure
from .whole_page import whole_page

_OVERVIEW_HEADS = ("No.", "File", "Speed (rpm)", "Top finding", "Probability", "Zone", "Warnings")


def render_report(analyses: Sequence[Analysis], *, title: str | None = None) -> str:
    """Return a report as one HTML page that needs no network.

    One analysis gives its page; several give a table of files, trends over the files in the order given, and
    one section a file.

    Parameters
    ----------
    analyses : sequence of Analysis
        In the order in which the trends shall show them.
    title : str, optional
        The file name, or the number of files, when left out.

    Raises
    ------
    InvalidValueError
        When there is no analysis, or a curve's arrays differ in length.
    MissingAssetError
        When plotly's script is not installed.
    """
    if len(analyses) == 0:
        raise InvalidValueError("0 analyses; allowed: 1 or more. Analyse at least one file before writing a report.")
    if len(analyses) == 1:
        heading = short_name(analyses[0]) if title is None else title
        return _page(heading, *_single(analyses[0], heading))
    heading = f"{len(analyses)} vibration files" if title is None else title
    return _page(heading, *_folder(analyses, heading))


def _single(analysis: Analysis, heading: str) -> tuple[str, list[str]]:
    verdict = f'{_kicker(heading)}<h1 class="verdict">{escape(analysis.verdict)}</h1>'
    body, data = _file_body(analysis, "f0", 2, point_limit(1))
    return f'<main><article class="file" data-payload="f0">{verdict}{body}</article></main>', [data]


def _folder(analyses: Sequence[Analysis], heading: str) -> tuple[str, list[str]]:
    trend = files_trend(analyses)
    picture = trend_figure(trend, "all-trend", "Trend", 3) if trend["series"] else _NO_TREND
    table = sortable_table(_OVERVIEW_HEADS, overview_table_rows(analyses), caption="Files", css="overview")
    blocks = [
        f"{_kicker('overview')}<h1>{escape(heading)}</h1>",
        f'<section><h2>Files at a glance</h2>{table}</section><section class="file" data-payload="all">',
        f"<h2>Trend over the files</h2>{picture}",
        "</section><h2>File by file</h2>",
    ]
    scripts = [_data("all", {"trend": trend})]
    for index, analysis in enumerate(analyses):
        body, data = _file_body(analysis, f"f{index}", 3, point_limit(len(analyses)))
        blocks.append(
            f'<details class="file" id="file-{index}" data-payload="f{index}"><summary><b>{index + 1}</b> '
            f'<span class="path">{escape(short_name(analysis))}</span></summary>'
            f'<p class="verdict">{escape(analysis.verdict)}</p>{body}</details>'
        )
        scripts.append(data)
    return f"<main>{''.join(blocks)}</main>", scripts


_NO_TREND = "<p>Nothing to draw: no finding, severity, speed or feature.</p>"


def _file_body(analysis: Analysis, uid: str, level: int, limit: int) -> tuple[str, str]:
    payload = build_payload(analysis, limit=limit)
    payload["trend"] = blocks_trend(analysis.blocks)
    plots = figures(payload, uid, level + 1)
    if payload["trend"]:
        plots += trend_figure(payload["trend"], f"{uid}-trend", "Trend over the recording", level + 1)
    heading = f"<h{level}>{{}}</h{level}>"
    body = (
        f"{warnings_block(analysis)}"
        f'<div class="answer"><section>{heading.format("Findings")}'
        f"{findings_block(analysis, level + 1)}{remarks_block(analysis)}</section>"
        f"<section>{heading.format('Severity')}{severity_block(analysis)}"
        f"{heading.format('Shaft speed')}{speed_block(analysis.speed)}</section></div>"
        f"<section>{heading.format('Curves')}{plots or '<p>This analysis holds no curves.</p>'}</section>"
        f"<section>{heading.format('Evidence')}{evidence_table(analysis)}</section>"
        f"<section>{heading.format('Features and file')}{feature_table(analysis)}"
        f"{facts_block(analysis)}</section>"
    )
    return body, _data(uid, payload)


def _data(uid: str, payload: dict[str, Any]) -> str:
    return f'<script type="application/json" id="data-{uid}">{to_json(payload)}</script>'


def _kicker(text: str) -> str:
    made = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %z")
    return f'<p class="kicker"><b>rotorwise</b> report · <span class="path">{escape(text)}</span> · {made}</p>'


def _page(title: str, body: str, data: list[str]) -> str:
    return whole_page(body, data, title=title, scripts=("report.js",))
