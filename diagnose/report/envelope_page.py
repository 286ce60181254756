"""The answer of ``rotorwise envelope``: JSON, table for the terminal, page."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..envelope_zoom import EnvelopeZoom
from ..envelopes import ChannelEnvelope, Envelopes
from ..look import Answer, Looked
from .encode import numbers
from .signal_page import SignalPage, cursors, graph_of, heat_map, spectral_channel
from .text import clean, decibels, number

_HEADS = ("Channel", "Hz", "Order", "Name", "Depth", "Over noise (dB)")
_COLUMNS = 192
_PREPARED = {"none": "", "random": "random part only", "prewhiten": "prewhitened"}


def answer(name: str, looked: Looked, found: Envelopes) -> Answer:
    """Return what the command prints and draws."""
    rows = _rows(looked, found)
    data = {
        "speed": None if found.shaft is None else found.shaft.data(),
        "prepared": found.prepared,
        "channels": [_channel_data(looked, one) for one in found.channels],
    }
    lines = [f"speed  {found.shaft.words}" if found.shaft else "speed  not found: lines have no order and no name"]
    lines += [_band_words(looked, one) for one in found.channels]
    if _PREPARED[found.prepared]:
        lines.append(f"signal  {_PREPARED[found.prepared]}")
    return Answer(data, tuple(lines), (_table(rows),), lambda: _page(name, looked, found, rows))


def _channel_data(looked: Looked, one: ChannelEnvelope) -> dict[str, Any]:
    best = one.kurtogram.best
    return {
        "channel": looked.recording.channels[one.channel].name,
        "band_hz": [one.low_hz, one.high_hz],
        "kurtosis": float(one.kurtogram.kurtosis[best]),
        "kurtosis_significant": one.kurtogram.is_significant,
        "lines": [
            {
                "frequency_hz": line.frequency_hz,
                "order": line.order,
                "name": line.name or None,
                "depth": line.depth,
                "signal_to_noise_db": 10 * float(np.log10(line.power_ratio)),
            }
            for line in one.lines
        ],
    }


def _band_words(looked: Looked, one: ChannelEnvelope) -> str:
    kurtogram = one.kurtogram
    best = kurtogram.best
    own = (one.low_hz, one.high_hz) == (float(kurtogram.low_hz[best]), float(kurtogram.high_hz[best]))
    text = f"{looked.recording.channels[one.channel].name}  {one.low_hz:.0f}-{one.high_hz:.0f} Hz"
    if not own:
        return text
    words = "" if kurtogram.is_significant else ", no more than noise: no band is impulsive"
    return f"{text}, spectral kurtosis {kurtogram.kurtosis[best]:.2f}{words}"


def _rows(looked: Looked, found: Envelopes) -> list[list[Any]]:
    return [
        [
            looked.recording.channels[one.channel].name,
            line.frequency_hz,
            line.order,
            line.name,
            line.depth,
            decibels(float(np.sqrt(line.power_ratio))),
        ]
        for one in found.channels
        for line in one.lines
    ]


def _table(rows: list[list[Any]]) -> Any:
    from rich.table import Table

    from ..terminal import escape

    if not rows:
        return "No line of the envelopes stands out of the noise."
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False)
    for head in _HEADS:
        left = head in ("Channel", "Name")
        table.add_column(head.lower().replace("(db)", "dB").replace("hz", "Hz"), justify="left" if left else "right")
    for channel, frequency, order, label, depth, over in rows:
        shown_order = "" if order is None else f"{order:.3f}"
        table.add_row(escape(channel), f"{frequency:.2f}", shown_order, escape(label), number(depth), f"{over:.1f}")
    return table


def _page(name: str, looked: Looked, found: Envelopes, rows: list[list[Any]]) -> str:
    facts = [f"Speed: {found.shaft.words}." if found.shaft else "Speed not found."]
    facts += [f"{_band_words(looked, one)}." for one in found.channels]
    if _PREPARED[found.prepared]:
        facts.append(f"Signal: {_PREPARED[found.prepared]}.")
    page = SignalPage("envelope", name, _headline(found), facts, looked.warnings)
    if rows:
        page.table(_HEADS, rows, caption="Lines of the squared envelope above the noise, strongest first")
    maps = [_kurtogram_map(looked, one) for one in found.channels]
    levels = np.unique(found.channels[0].kurtogram.level)
    ticks = [float(i) for i in range(levels.size)], [f"{round(2**level)}" for level in levels]
    page.heat(
        "Kurtogram", maps, x="Frequency (Hz)", y="Parts of the band", unit="kurtosis", ticks=ticks,
        note="0 is Gaussian noise; high is rare bursts.",
    )  # fmt: skip
    page.payload["speedHz"] = None if found.shaft is None else found.shaft.mean_hz
    page.payload["envelope"] = [_spectrum(looked, one) for one in found.channels]
    page.payload["cursors"] = _cursors(found)
    zooms = [_zoom(looked, one, zoom) for one in found.channels for zoom in one.zooms]
    if zooms:
        page.graph("Lines of the envelope, close", zooms, label="Line", note="Ten points a bin.")
    return page.html()


def _headline(found: Envelopes) -> str:
    named = [line for one in found.channels for line in one.lines if " x " in line.name]
    if named:
        best = max(named, key=lambda line: line.depth)
        return f"{best.name} at {best.frequency_hz:.2f} Hz"
    anything = any(one.lines for one in found.channels)
    return "Envelope lines, none of a known bearing" if anything else "No line in the envelope"


def _kurtogram_map(looked: Looked, one: ChannelEnvelope) -> dict[str, Any]:
    kurtogram = one.kurtogram
    levels = np.unique(kurtogram.level)
    centres = (np.arange(_COLUMNS) + 0.5) * float(kurtogram.high_hz.max()) / _COLUMNS
    table = np.full((levels.size, _COLUMNS), np.nan)
    for level, low, high, value in zip(
        kurtogram.level, kurtogram.low_hz, kurtogram.high_hz, kurtogram.kurtosis, strict=True
    ):
        table[int(np.searchsorted(levels, level)), (centres >= low) & (centres < high)] = max(float(value), 0.0)
    name = looked.recording.channels[one.channel].name
    return heat_map(name, centres, np.arange(levels.size), table, note=f"Taken: {one.low_hz:.0f}-{one.high_hz:.0f} Hz.")


def _spectrum(looked: Looked, one: ChannelEnvelope) -> dict[str, Any]:
    lines = [
        (
            line.frequency_hz,
            line.depth,
            f"{line.name or 'line'}, {10 * np.log10(line.power_ratio):.1f} dB above the noise",
        )
        for line in one.lines
    ]
    channel = looked.recording.channels[one.channel].name
    spectrum = one.spectrum
    made = spectral_channel(
        channel, spectrum.frequency_hz[2:], spectrum.amplitude[0, 2:], spectrum.floor[0, 2:], unit=None, lines=lines,
        note=f"Squared envelope of {one.low_hz:.0f}-{one.high_hz:.0f} Hz over its mean.",
    )  # fmt: skip
    return made | {"unit": "of the mean"}


def _zoom(looked: Looked, one: ChannelEnvelope, zoom: EnvelopeZoom) -> dict[str, Any]:
    channel = looked.recording.channels[one.channel].name
    inside = (one.spectrum.frequency_hz >= zoom.frequency_hz[0]) & (one.spectrum.frequency_hz <= zoom.frequency_hz[-1])
    made = graph_of(
        f"{channel}: {zoom.place.name}",
        [("envelope", zoom.frequency_hz, zoom.depth),
         ("noise floor", one.spectrum.frequency_hz[inside], one.spectrum.floor[0, inside])],
        x="Frequency (Hz)", y="Depth (of the mean)",
    )  # fmt: skip
    places = [place for _, place in zoom.place.expected]
    if places:
        height = np.interp(places, zoom.frequency_hz, zoom.depth)
        made["note"] = "Circles: where the defect's line and its sidebands would stand."
        names = [clean(name) for name, _ in zoom.place.expected]
        made["traces"].append(
            {"name": "expected", "x": numbers(np.array(places), digits=8), "y": numbers(height), "text": names}
        )
    return made


def _cursors(found: Envelopes) -> list[dict[str, Any]]:
    groups = []
    if found.shaft is not None:
        groups.append(("shaft orders", True, [(f"{k}X", k * found.shaft.mean_hz) for k in range(1, 7)]))
    for one in found.rhythms:
        short = one.label.split()[0]
        seen = any(one.label in line.name for channel in found.channels for line in channel.lines)
        groups.append((one.label, seen, [(f"{k} x {short}", k * one.frequency_hz) for k in range(1, 5)]))
    return cursors(groups)
