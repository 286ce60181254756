"""The HTML around each plot: heading, switches, drawing area, caption."""

from __future__ import annotations

from typing import Any

from .text import escape

_TITLES = {"spectrum": "Spectrum", "envelope": "Envelope spectrum", "waveform": "Waveform"}
_CAPTIONS = {
    "spectrum": "Amplitudes are peak values of a sine.",
    "envelope": "Spectrum of the demodulated signal.",
}


def figures(payload: dict[str, Any], uid: str, level: int) -> str:
    """Return the figures of one analysis; the script fills them from its payload.

    Parameters
    ----------
    payload : dict
        From ``build_payload``.
    uid : str
        Prefix that keeps the identifiers of several files apart.
    level : int
        Heading level.
    """
    blocks = [_spectral("spectrum", payload, uid, level)]
    if payload["map"]:
        blocks.append(_single("map", "Level over time", payload["map"], uid, level))
    blocks.append(_spectral("envelope", payload, uid, level))
    pair = ""
    if payload["orbit"]:
        pair = _single("orbit", "Shaft orbit", payload["orbit"], uid, level)
    if payload["waveform"]:
        chooser = channel_chooser(payload["waveform"], f"{uid}-waveform")
        pair += figure("waveform", _TITLES["waveform"], chooser, "", level)
    blocks.append(f'<div class="pair">{pair}</div>' if pair else "")
    if payload.get("turn"):
        turn = _single("turn", "Orders over the shaft's angle", payload["turn"], uid, level)
        # Not drawn before it is opened.
        blocks.append(f'<details class="fold"><summary>First orders within a turn</summary>{turn}</details>')
    return "".join(blocks)


def figure(kind: str, title: str, controls: str, caption: str, level: int, *, css: str = "") -> str:
    """Return one figure. Title and caption are plain text, controls are HTML."""
    bar = f'<div class="controls">{controls}</div>' if controls else ""
    save = '<button type="button" class="save" data-role="save">Save picture</button>'
    return (
        f'<figure class="plot {css}" data-plot="{kind}" data-caption="{escape(caption)}">'
        f'<div class="head"><h{level}>{escape(title)}</h{level}>{save}</div>{bar}'
        f'<div class="canvas" role="img" aria-label="{escape(title)}"></div>'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def _single(kind: str, title: str, content: dict[str, Any], uid: str, level: int) -> str:
    channels = [content["channel"]] if "channel" in content else content["channels"]
    return figure(kind, f"{title}: {' / '.join(channels)}", "", content["note"], level)


def _spectral(kind: str, payload: dict[str, Any], uid: str, level: int) -> str:
    if not payload[kind]:
        return ""
    orders = ""
    if payload["speedHz"]:
        orders = (
            '<label>Axis <select data-role="axis"><option value="hz">Hz</option>'
            '<option value="order">orders</option></select></label>'
        )
    controls = (
        channel_chooser(payload[kind], f"{uid}-{kind}")
        + '<label>Scale <select data-role="scale"><option value="log">logarithmic</option>'
        '<option value="linear">linear</option></select></label>'
        + orders
        + '<span class="zooms" role="group" aria-label="Range">'
        '<button type="button" data-zoom="near">Marked lines</button>'
        '<button type="button" data-zoom="all">Whole range</button></span>' + _cursor_boxes(payload["cursors"])
    )
    return figure(kind, _TITLES[kind], controls + _legend(payload[kind]), _CAPTIONS[kind], level)


def _legend(channels: list[dict[str, Any]]) -> str:
    entries = ['<span class="key-curve">this recording</span>']
    if any("base" in channel for channel in channels):
        entries.append('<span class="key-base">baseline</span>')
    if any("floor" in channel["curve"] for channel in channels):
        entries.append('<span class="key-floor">noise floor</span>')
    if any(channel["lines"] for channel in channels):
        entries.append('<span class="ring">line behind a finding</span>')
    return f'<p class="legend">{"".join(entries)}</p>'


def channel_chooser(channels: list[dict[str, Any]], identifier: str) -> str:
    """Return the channel selector, set to the first channel with evidence; plain text for one channel."""
    names = [channel["channel"] for channel in channels]
    labels = [
        name if names.count(name) == 1 or not channel["name"] else f"{name}: {channel['name']}"
        for name, channel in zip(names, channels, strict=True)
    ]
    first = next((index for index, channel in enumerate(channels) if channel["lines"]), 0)
    if len(channels) == 1:
        return f'<span class="only">Channel <b>{escape(labels[0])}</b></span>'
    options = "".join(
        f'<option value="{index}"{" selected" if index == first else ""}>{escape(label)}</option>'
        for index, label in enumerate(labels)
    )
    return f'<label for="{identifier}">Channel <select id="{identifier}" data-role="channel">{options}</select></label>'


def _cursor_boxes(groups: list[dict[str, Any]]) -> str:
    if not groups:
        return ""
    boxes = "".join(
        f'<label class="group-{index % 8}"><input type="checkbox" data-group="{index}"'
        f"{' checked' if group['on'] else ''}>"
        f"<i></i>{escape(group['group'])}</label>"
        for index, group in enumerate(groups)
    )
    return f'<fieldset class="cursors"><legend>Cursors</legend>{boxes}</fieldset>'
