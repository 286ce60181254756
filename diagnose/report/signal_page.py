"""The pages of ``rotorwise orders``, ``envelope`` and ``sidebands``: maps, curves, spectra and tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import numpy as np

from .encode import RawJson, encode_curve, numbers, pool_map, to_json
from .figures import figure, figures
from .tables import sortable_table
from .text import cell, clean, display_unit, escape, number
from .whole_page import whole_page

_POINTS = 6000
_MAP_ROWS, _MAP_COLUMNS = 220, 250
_EMPTY = {"spectrum": [], "envelope": [], "waveform": [], "map": None, "orbit": None, "cursors": [], "speedHz": None}


@dataclass
class SignalPage:
    """A page that is put together figure by figure.

    Parameters
    ----------
    command, file_name, headline : str
    facts, warnings : sequence of str
        Lines below the headline.
    """

    command: str
    file_name: str
    headline: str
    facts: Sequence[str] = ()
    warnings: Sequence[str] = ()
    payload: dict[str, Any] = field(default_factory=lambda: dict(_EMPTY))
    blocks: list[str] = field(default_factory=list)

    def heat(
        self,
        title: str,
        channels: Sequence[dict[str, Any]],
        *,
        x: str,
        y: str,
        unit: str,
        note: str = "",
        ticks: tuple[list[float], list[str]] | None = None,
    ) -> None:
        """Add a map; each channel is made by `heat_map`."""
        kind = self._next("heat")
        self.payload[kind] = {"channels": list(channels), "x": x, "y": y, "unit": unit, "ticks": ticks}
        chooser = _chooser("channel", "Channel", [one["name"] for one in channels])
        self.blocks.append(figure(kind, title, chooser, note, 3))

    def graph(self, title: str, variants: Sequence[dict[str, Any]], *, label: str = "Show", note: str = "") -> None:
        """Add curves; each variant is made by `graph_of`."""
        kind = self._next("graph")
        self.payload[kind] = list(variants)
        chooser = _chooser("series", label, [one["name"] for one in variants])
        self.blocks.append(figure(kind, title, chooser, note, 3))

    def table(self, heads: tuple[str, ...], rows: Sequence[Sequence[Any]], *, caption: str) -> None:
        """Add a table; numbers sort as numbers, None is a dash."""
        body = ["<tr>" + "".join(_cell(value) for value in row) + "</tr>" for row in rows]
        self.blocks.append(sortable_table(heads, body, caption=caption))

    def html(self) -> str:
        """Return the page."""
        made = datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %z")
        facts = "".join(f"<p>{escape(line)}</p>" for line in self.facts)
        warned = "".join(f"<li>{escape(line)}</li>" for line in self.warnings)
        warned = f'<ul class="warnings">{warned}</ul>' if warned else ""
        body = (
            '<main><article class="file" data-payload="f0">'
            f'<p class="kicker"><b>rotorwise</b> {self.command} · <span class="path">{escape(self.file_name)}</span> · '
            f'{made}</p><h1 class="verdict">{escape(self.headline)}</h1>{facts}{warned}'
            f"<section>{''.join(self.blocks)}{figures(self.payload, 'f0', 3)}</section></article></main>"
        )
        data = f'<script type="application/json" id="data-f0">{to_json(self.payload)}</script>'
        return whole_page(body, [data], title=f"{self.command}: {self.file_name}", scripts=("signal.js", "report.js"))

    def _next(self, kind: str) -> str:
        return f"{kind}-{1 + sum(key.startswith(kind) for key in self.payload)}"


def heat_map(name: str, x: np.ndarray, y: np.ndarray, z: np.ndarray, *, note: str = "") -> dict[str, Any]:
    """Return one channel's map, pooled to at most 250 x 220 cells by their highest value.

    Parameters
    ----------
    x : numpy.ndarray, shape (columns,)
    y : numpy.ndarray, shape (rows,)
    z : numpy.ndarray, shape (rows, columns)
    """
    pooled, per_row, per_column = pool_map(np.asarray(z, dtype=float), _MAP_ROWS, _MAP_COLUMNS)
    return {
        "name": clean(name),
        "x": numbers(_centres(x, per_column), digits=6),
        "y": numbers(_centres(y, per_row), digits=6),
        "z": [RawJson(numbers(row, digits=4)) for row in pooled],
        "note": note,
    }


def graph_of(
    name: str,
    traces: Sequence[tuple[str, np.ndarray, np.ndarray]],
    *,
    x: str,
    y: str,
    value_range: tuple[float, float] | None = None,
    note: str = "",
) -> dict[str, Any]:
    """Return one variant of a graph: named traces over x."""
    return {
        "name": clean(name),
        "x": x,
        "y": y,
        "range": value_range,
        "note": note,
        "traces": [{"name": clean(own), "curve": encode_curve(at, value, limit=_POINTS)} for own, at, value in traces],
    }


def spectral_channel(
    name: str,
    frequency_hz: np.ndarray,
    amplitude: np.ndarray,
    floor: np.ndarray | None,
    *,
    unit: str | None,
    lines: Sequence[tuple[float, float, str]] = (),
    note: str = "",
) -> dict[str, Any]:
    """Return a spectrum for the report's spectral figure; lines are frequency, amplitude and text of a ring."""
    factor, shown = display_unit(unit)
    return {
        "channel": clean(name),
        "name": "",
        "xUnit": "Hz",
        "unit": shown or "unit unknown",
        "note": note,
        "curve": encode_curve(
            frequency_hz, factor * amplitude, limit=_POINTS, floor=None if floor is None else factor * floor
        ),
        "lines": [{"f": place, "a": factor * height, "text": clean(text)} for place, height, text in lines],
    }


def cursors(groups: Sequence[tuple[str, bool, Sequence[tuple[str, float]]]]) -> list[dict[str, Any]]:
    """Return groups of named frequencies: name, whether shown at first, and (label, Hz) pairs."""
    return [
        {"group": clean(name), "on": on, "items": [[clean(label), place] for label, place in items]}
        for name, on, items in groups
    ]


def _centres(values: np.ndarray, size: int) -> np.ndarray:
    positions = np.asarray(values, dtype=float)
    starts = np.arange(0, positions.size, size)
    return np.add.reduceat(positions, starts) / np.diff(starts, append=positions.size)


def _chooser(role: str, label: str, names: Sequence[str]) -> str:
    if len(names) < 2:
        return f'<span class="only">{label} <b>{escape(names[0])}</b></span>' if names and names[0] else ""
    options = "".join(f'<option value="{index}">{escape(name)}</option>' for index, name in enumerate(names))
    return f'<label>{label} <select data-role="{role}">{options}</select></label>'


def _cell(value: Any) -> str:
    if isinstance(value, int):
        return cell(str(value), float(value))
    if value is None or isinstance(value, float | np.floating):
        shown = None if value is None else float(value)
        return cell(number(shown, digits=5), shown)
    return f"<td>{escape(value)}</td>"
