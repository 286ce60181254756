"""The answer of ``rotorwise sidebands``: JSON, table for the terminal, page."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..line_families import ChannelFamilies, LineFamilies
from ..look import Answer, Looked
from ..signal.blind_sidebands import BlindFamily
from .signal_page import SignalPage, cursors, graph_of, spectral_channel
from .text import display_unit, number, unit_words

_HEADS = (
    "Channel",
    "Carrier (Hz)",
    "Order",
    "Spacing (Hz)",
    "Modulator",
    "Off by (%)",
    "Index",
    "Pairs",
    "Over noise (dB)",
)
_MOST_GROUPS = 8


def answer(name: str, looked: Looked, found: LineFamilies) -> Answer:
    """Return what the command prints and draws."""
    rows = [_row(looked, found, one, family) for one in found.channels for family in one.families]
    data = {
        "speed": None if found.shaft is None else found.shaft.data(),
        "modulators_hz": found.modulators_hz,
        "channels": [_channel_data(looked, one) for one in found.channels],
    }
    lines = [f"speed  {found.shaft.words}" if found.shaft else "speed  not found: families are not named"]
    lines += [_cepstrum_words(looked, one) for one in found.channels if one.spacing is not None]
    return Answer(data, tuple(lines), tuple(_tables(rows)), lambda: _page(name, looked, found, rows))


def _first_pair(family: BlindFamily) -> list[float]:
    return [
        10 * float(np.log10(max(side.power_ratio, 1e-12))) for side in family.family.sidebands if abs(side.number) == 1
    ]


def _pairs(family: BlindFamily) -> int:
    """Return how many pairs in a row have a line on either side."""
    count = 0
    for number_ in range(1, 5):
        if not any(side.power_ratio > 16 for side in family.family.sidebands if abs(side.number) == number_):
            break
        count += 1
    return count


def _channel_data(looked: Looked, one: ChannelFamilies) -> dict[str, Any]:
    spacing = one.spacing
    return {
        "channel": looked.recording.channels[one.channel].name,
        "cepstral_spacing_hz": None if spacing is None else spacing.spacing_hz,
        "families": [
            {
                "carrier_hz": family.family.carrier.frequency_hz,
                "carrier_amplitude": family.family.carrier.amplitude,
                "spacing_hz": family.spacing_hz,
                "modulator": family.shaft,
                "modulation_index": family.family.modulation_index,
                "log_odds": family.log_odds,
                "sidebands": [
                    {
                        "number": side.number,
                        "frequency_hz": side.frequency_hz,
                        "amplitude": side.amplitude,
                        "signal_to_noise_db": 10 * float(np.log10(max(side.power_ratio, 1e-12))),
                    }
                    for side in family.family.sidebands
                ],
            }
            for family in one.families
        ],
    }


def _row(looked: Looked, found: LineFamilies, one: ChannelFamilies, family: BlindFamily) -> list[Any]:
    carrier = family.family.carrier
    return [
        looked.recording.channels[one.channel].name,
        round(carrier.frequency_hz, 3),
        None if found.shaft is None else carrier.frequency_hz / found.shaft.mean_hz,
        family.spacing_hz,
        family.shaft or "unknown",
        None if family.shaft_error is None else 100 * family.shaft_error,
        family.family.modulation_index,
        _pairs(family),
        max(_first_pair(family), default=None),
    ]


def _cepstrum_words(looked: Looked, one: ChannelFamilies) -> str:
    assert one.spacing is not None
    name = looked.recording.channels[one.channel].name
    return f"cepstrum  {name}: lines {one.spacing.spacing_hz:.3f} Hz apart, +- {0.5 * one.spacing.resolution_hz:.2g}"


def _tables(rows: list[list[Any]]) -> list[Any]:
    """Return one table a channel: with a column for the channel it would not fit 80 columns."""
    from rich.table import Table

    from ..terminal import escape

    if not rows:
        return ["No sideband family stands out of chance."]
    tables: dict[str, Table] = {}
    for channel, carrier, order, spacing, shaft, _, index, pairs, over in rows:
        if channel not in tables:
            tables[channel] = Table(
                box=None, padding=(0, 2, 0, 0), show_edge=False, title=escape(channel), title_justify="left"
            )
            for head in ("carrier Hz", "order", "spacing Hz", "modulator", "index", "pairs", "noise +dB"):
                tables[channel].add_column(head, justify="left" if head == "modulator" else "right", no_wrap=True)
        shown_order = "" if order is None else f"{order:.3f}"
        tables[channel].add_row(
            f"{carrier:.2f}", shown_order, f"{spacing:.3f}", escape(shaft), f"{index:.2f}", str(pairs), number(over)
        )
    return list(tables.values())


def _page(name: str, looked: Looked, found: LineFamilies, rows: list[list[Any]]) -> str:
    facts = [f"Speed: {found.shaft.words}." if found.shaft else "Speed not found."]
    facts += [f"C{_cepstrum_words(looked, one)[1:]}." for one in found.channels if one.spacing is not None]
    page = SignalPage("sidebands", name, _headline(found), facts, looked.warnings)
    if rows:
        page.table(_HEADS, rows, caption="Sideband families, surest first")
    cepstra = [
        graph_of(
            looked.recording.channels[one.channel].name,
            [("cepstrum", 1e3 * one.cepstrum.quefrency_s[3:], one.cepstrum.height[3:]),
             ("noise floor", 1e3 * one.cepstrum.quefrency_s[3:], one.cepstrum.floor[3:])],
            x="Quefrency (ms)", y="Ripple of ln amplitude",
        )
        for one in found.channels
        if one.cepstrum is not None
    ]  # fmt: skip
    page.payload["speedHz"] = None if found.shaft is None else found.shaft.mean_hz
    page.payload["spectrum"] = [_spectrum(looked, found, one) for one in found.channels]
    page.payload["cursors"] = _cursors(found)
    if cepstra:
        note = "A peak at a quefrency, and at its multiples, is a line spacing of one over it."
        page.graph("Cepstrum", cepstra, label="Channel", note=note)
    zooms = [
        _zoom(looked, one, family, zoom)
        for one in found.channels
        for family, zoom in zip(one.families, one.zooms, strict=False)
    ]
    if zooms:
        page.graph(
            "Carrier and sidebands", zooms, label="Carrier", note="Five sidebands to each side, ten points a bin."
        )
    return page.html()


def _zoom(
    looked: Looked, one: ChannelFamilies, family: BlindFamily, zoom: tuple[np.ndarray, np.ndarray]
) -> dict[str, Any]:
    channel = looked.recording.channels[one.channel]
    factor, _ = display_unit(channel.unit)
    name = f"{channel.name}: {family.family.carrier.frequency_hz:.1f} Hz +- {family.spacing_hz:.2f} Hz"
    return graph_of(
        name,
        [("amplitude", zoom[0], factor * zoom[1])],
        x="Frequency (Hz)",
        y=f"Amplitude ({unit_words(channel.unit)})",
    )


def _headline(found: LineFamilies) -> str:
    families = [family for one in found.channels for family in one.families]
    if not families:
        return "No sidebands"
    best = max(families, key=lambda family: family.log_odds)
    whose = f"modulated by: {best.shaft}" if best.shaft else "of no known modulator"
    return f"Sidebands {best.spacing_hz:.2f} Hz from {best.family.carrier.frequency_hz:.1f} Hz, {whose}"


def _spectrum(looked: Looked, found: LineFamilies, one: ChannelFamilies) -> dict[str, Any]:
    channel = looked.recording.channels[one.channel]
    lines = []
    for family in one.families[:_MOST_GROUPS]:
        place = family.family.carrier
        lines.append((place.frequency_hz, place.amplitude, "carrier"))
        lines += [
            (side.frequency_hz, side.amplitude, f"{side.number:+d} x {family.spacing_hz:.2f} Hz")
            for side in family.family.sidebands
            if side.power_ratio > 16
        ]
    spectrum = one.spectrum
    return spectral_channel(
        channel.name, spectrum.frequency_hz, spectrum.amplitude[one.channel], spectrum.floor[one.channel],
        unit=channel.unit, lines=lines,
    )  # fmt: skip


def _cursors(found: LineFamilies) -> list[dict[str, Any]]:
    groups = []
    if found.shaft is not None:
        groups.append(("shaft orders", False, [(f"{k}X", k * found.shaft.mean_hz) for k in range(1, 11)]))
    families = sorted((f for one in found.channels for f in one.families), key=lambda one: -one.log_odds)
    for number_, family in enumerate(families[:_MOST_GROUPS]):
        place = family.family.carrier.frequency_hz
        items = [(f"{k:+d}" if k else f"{place:.0f} Hz", place + k * family.spacing_hz) for k in range(-4, 5)]
        groups.append((f"{place:.0f} Hz +- {family.spacing_hz:.2f} Hz", number_ == 0, items))
    return cursors(groups)
