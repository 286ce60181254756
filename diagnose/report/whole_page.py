"""The frame of every page: one HTML file that needs no network and runs nothing but its own scripts."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from functools import cache
from importlib.resources import files

from .assets import plotly_script, safe_script, style_sheet
from .text import escape

_OWN_FILES = files(__package__ or "rotorwise.diagnose.report")


def whole_page(
    body: str, data: Sequence[str], *, title: str, scripts: Sequence[str], styles: Sequence[str] = ()
) -> str:
    """Return a whole page.

    Parameters
    ----------
    body : str
        HTML with the places of the figures.
    data : sequence of str
        Script elements that hold the figures' numbers.
    title : str
        Not yet escaped.
    scripts, styles : sequence of str
        Names of the files here that draw, after plots.js, and that style, after report.css.

    Raises
    ------
    MissingAssetError
        When plotly's script is not installed.
    """
    drawing = _script(tuple(scripts))
    style = style_sheet() + "".join(_OWN_FILES.joinpath(name).read_text(encoding="utf-8") for name in styles)
    return "\n".join(
        [
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{_policy(drawing)}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            '<meta name="color-scheme" content="light dark">',
            f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>",
            body,
            "<noscript><p>The plots need JavaScript; the words and the tables do not.</p></noscript>",
            *data,
            f"<script>{plotly_script()}</script>",
            f"<script>{drawing}</script>",
            "</body>\n</html>\n",
        ]
    )


@cache
def _script(names: tuple[str, ...]) -> str:
    parts = (_OWN_FILES.joinpath(name).read_text(encoding="utf-8") for name in ("plots.js", *names))
    return safe_script("\n".join(parts))


@cache
def _policy(drawing: str) -> str:
    """Return a content policy that allows the two scripts by their hash and nothing else.

    No network, and no script that a hostile file name might have smuggled in.
    """
    digests = (hashlib.sha256(script.encode("utf-8")).digest() for script in (plotly_script(), drawing))
    hashes = " ".join(f"'sha256-{base64.b64encode(digest).decode('ascii')}'" for digest in digests)
    return (
        f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; "
        "form-action 'none'"
    )
