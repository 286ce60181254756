"""What a figure of the papers' page holds: traces in several variants, axes, limits; ``papers.js`` draws it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .encode import encode_curve, numbers
from .text import escape

MOST_POINTS = 4000
_ZONE_KEY = '<p class="zone-key">' + "".join(f'<span class="zone zone-{zone}">zone {zone}</span> ' for zone in "ABCD")
_CONTACT_KEY = '<span class="contact">contact</span>'


@dataclass(frozen=True)
class Figure:
    """One figure.

    Parameters
    ----------
    title, note : str
        ``note`` stands below it.
    x, y : str
        Axis titles with units.
    variants : mapping of str to list of dict
        Traces by the name under which the reader chooses them; made by `curve`, `points` and `heights`.
    log : bool
        Whether the vertical axis is logarithmic.
    y_low : float, optional
        Where a logarithmic axis begins.
    x_range : tuple of float, optional
        What is shown at first.
    marks : sequence of (str, float)
        Named vertical lines.
    kind : str
        "curves", "bars" or "zones".
    """

    title: str
    note: str
    x: str
    y: str
    variants: Mapping[str, list[dict[str, Any]]]
    log: bool = False
    y_low: float | None = None
    x_range: tuple[float, float] | None = None
    marks: Sequence[tuple[str, float]] = field(default=())
    kind: str = "curves"

    def payload(self) -> dict[str, Any]:
        """Return what the script reads."""
        return {
            "kind": self.kind,
            "x": self.x,
            "y": self.y,
            "log": self.log,
            "low": self.y_low,
            "range": self.x_range,
            "marks": list(self.marks),
            "variants": list(self.variants.values()),
        }

    def html(self, uid: str) -> str:
        """Return the frame that the script fills; ``uid`` is unique on the page."""
        chooser = ""
        if len(self.variants) > 1:
            items = "".join(f'<option value="{i}">{escape(name)}</option>' for i, name in enumerate(self.variants))
            chooser = f'<div class="controls"><label>Show <select data-role="variant">{items}</select></label></div>'
        return (
            f'<figure class="plot" data-figure="{uid}"><div class="head"><h3>{escape(self.title)}</h3></div>{chooser}'
            f'<div class="canvas" role="img" aria-label="{escape(self.title)}"></div>'
            f"{self._zone_key()}<figcaption>{escape(self.note)}</figcaption></figure>"
        )

    def _zone_key(self) -> str:
        if self.kind != "zones":
            return ""
        touches = any(panel["contact"] is not None for panels in self.variants.values() for panel in panels)
        return f"{_ZONE_KEY}{_CONTACT_KEY if touches else ''}</p>"


def curve(name: str, x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
    """Return a line through many samples, thinned with its peaks kept."""
    return {"name": name, "curve": encode_curve(x, y, limit=MOST_POINTS)}


def points(name: str, x: Sequence[float], y: Sequence[float]) -> dict[str, Any]:
    """Return a line with a mark at each of a few points; NaN makes a gap."""
    return {"name": name, "x": numbers(np.asarray(x, float)), "y": numbers(np.asarray(y, float)), "marked": True}


def heights(name: str, labels: Sequence[str], y: Sequence[float]) -> dict[str, Any]:
    """Return one bar a label."""
    return {"name": name, "x": list(labels), "y": numbers(np.asarray(y, float))}


def spectrum(signal: np.ndarray, *, rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies (Hz) and peak amplitudes of a record through a Hann window.

    A record of a whole number of turns keeps strong lines out of the others.
    """
    window = np.hanning(signal.size + 1)[:-1]
    lines = np.abs(np.fft.rfft((signal - signal.mean()) * window)) * 2 / window.sum()
    return np.fft.rfftfreq(signal.size, 1 / rate_hz), lines
