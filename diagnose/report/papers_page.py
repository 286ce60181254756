"""The page of `rotorwise papers --report`: claims by paper with their verdicts, and the curves behind them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from datetime import datetime
from importlib import import_module
from itertools import groupby
from pathlib import Path

from ...simulators.papers.claim import VERDICTS, Claim
from ..papers import TITLES, count, rows
from ..papers_files import write_whole
from .encode import to_json
from .text import escape
from .whole_page import whole_page
from .write import check_free


def write_page(claims: Sequence[Claim], path: Path, *, force: bool) -> None:
    """Compute the curves of the papers that the claims are of, and write the page as one HTML file.

    Parameters
    ----------
    claims : sequence of Claim
        Paper by paper.
    path : Path
        Its folder must exist.
    force : bool
        Whether an existing HTML page may be replaced.

    Raises
    ------
    ReportFileError, TableFileError
        When the file exists and ``force`` is not set, or the place cannot be written to.
    MissingAssetError
        When plotly's script is not installed.
    """
    page = render_page(claims)
    check_free(path.resolve(), force=force)
    write_whole(path, page)


def render_page(claims: Sequence[Claim]) -> str:
    """Return the page; the curves are computed here."""
    blocks, scripts = [], []
    for paper, own in groupby(claims, key=lambda claim: claim.paper):
        module = import_module(f".papers_{paper}", __package__)
        drawn = {f"p{paper}-{i}": figure for i, figure in enumerate(module.figures())}
        blocks.append(_paper(paper, list(own), "".join(figure.html(uid) for uid, figure in drawn.items())))
        content = to_json({uid: figure.payload() for uid, figure in drawn.items()})
        scripts.append(f'<script type="application/json" class="figures">{content}</script>')
    body = f"<main>{_head(claims)}{''.join(blocks)}</main>"
    return whole_page(body, scripts, title="Claims of the papers", scripts=("papers.js",), styles=("papers.css",))


def _head(claims: Sequence[Claim]) -> str:
    made = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %z")
    seen = Counter(claim.verdict for claim in claims)
    chips = "".join(f"<li>{_pill(verdict)} {seen[verdict]}</li>" for verdict in VERDICTS if seen[verdict])
    papers = dict.fromkeys(claim.paper for claim in claims)
    links = "".join(f'<li><a href="#paper-{paper}">{paper}: {_title(paper)}</a></li>' for paper in papers)
    return (
        f'<p class="kicker"><b>rotorwise</b> papers · {made}</p>'
        "<h1>What the source papers claim, and what comes out</h1>"
        f"<p>{escape(count(claims))}</p>"
        f'<ul class="chips">{chips}</ul>'
        "<p>As printed: the paper taken literally, misprints included. Corrected: the same machine with its misprints "
        "put right and plausible values where the paper gives none. Extra effect: what has to be added for the claim "
        "to appear.</p>"
        f"<nav><ul>{links}</ul></nav>"
    )


def _paper(paper: str, claims: Sequence[Claim], figures: str) -> str:
    cards = "".join(f"<li>{_card(claim)}</li>" for claim in claims)
    return (
        f'<section id="paper-{escape(paper)}"><h2>Paper {escape(paper)}: {_title(paper)}</h2>'
        f'<p>{escape(count(claims))}</p><ul class="claims">{cards}</ul>{figures}</section>'
    )


def _card(claim: Claim) -> str:
    said, *found = rows(claim)
    facts = "".join(f"<dt>{escape(label)}</dt><dd>{_words(text)}</dd>" for label, text in found)
    return (
        f'<article class="card {_css(claim.verdict)}"><h3>{escape(claim.place)} {_pill(claim.verdict)}</h3>'
        f'<p>{_words(said[1])}</p><dl class="facts">{facts}</dl></article>'
    )


def _words(text: str) -> str:
    return re.sub(r"\bum\b", "µm", escape(text)).replace("+-", "±").replace("-&gt;", "→").replace("m/s2", "m/s²")


def _pill(verdict: str) -> str:
    return f'<span class="pill {_css(verdict)}">{escape(verdict)}</span>'


def _css(verdict: str) -> str:
    return f"verdict-{VERDICTS.index(verdict)}"


def _title(paper: str) -> str:
    return escape(TITLES.get(paper, ""))
