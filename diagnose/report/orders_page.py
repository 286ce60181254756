"""The answer of ``rotorwise orders``: JSON, tables for the terminal, page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ..look import Answer, Looked
from ..observe import order_name
from ..orders import CLEAR_DB, FollowedOrder, Orders, summary
from ..passed_speeds import passed_speeds
from ..signal.critical_speed import CriticalSpeed
from ..signal.orbit import FullSpectrum, filtered_orbit
from ..signal.order_map import Waterfall
from .encode import numbers
from .signal_page import SignalPage, graph_of, heat_map
from .text import clean, display_unit, unit_words

_WAVE_SECONDS = 0.5
_SHORT = {"Phase there (deg)": "phase deg", "Over noise (dB)": "noise +dB"}
_HEADS = ("Channel", "Order", "Unit", "Median", "Largest", "at rpm", "Phase there (deg)", "Over noise (dB)")


def answer(name: str, looked: Looked, found: Orders) -> Answer:
    """Return what the command prints and draws."""
    rows, passed = _rows(looked, found), passed_speeds(looked, found)
    channels = looked.recording.channels
    data = {
        "speed": found.shaft.data(),
        "orders": [
            {"channel": channels[one.channel].name, "unit": channels[one.channel].unit} | summary(found, one)
            for one in found.followed
        ],
        "orbits": [
            {"order": order, "major": shape.major, "minor": shape.minor, "whirl": shape.direction}
            for order, shape, _, _ in found.orbits
        ],
        "critical_speeds": [asdict(one) for one in passed],
    }
    lines = [*_critical_lines(passed), *_orbit_lines(looked, found)]
    shown = (f"speed  {found.shaft.words}", *lines)
    return Answer(data, shown, (_table(rows),), lambda: _page(name, looked, found, rows, lines))


def _critical_lines(passed: Sequence[CriticalSpeed]) -> list[str]:
    return [
        f"critical speed  {one.speed_rpm:.0f} rpm ({one.low_rpm:.0f} to {one.high_rpm:.0f}), damping ratio "
        f"{one.damping_ratio:.2g} ({one.low_ratio:.2g} to {one.high_ratio:.2g})"
        for one in passed
    ]


def _rows(looked: Looked, found: Orders) -> list[list[Any]]:
    rows = []
    for one in found.followed:
        channel = looked.recording.channels[one.channel]
        factor, _ = display_unit(channel.unit)
        values = summary(found, one)
        rows.append(
            [
                channel.name,
                order_name(one.order),
                unit_words(channel.unit),
                factor * values["median"],
                factor * values["largest"],
                values["rpm_at_largest"],
                values["phase_deg_at_largest"],
                values["over_noise_db"],
            ]
        )
    return rows


def _table(rows: list[list[Any]]) -> Any:
    from rich.table import Table

    from ..terminal import escape
    from .text import number

    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False)
    for head in _HEADS:
        left = head in ("Channel", "Order", "Unit")
        table.add_column(_SHORT.get(head, head.lower()), justify="left" if left else "right", no_wrap=True)
    for row in rows:
        words = [escape(str(value)) for value in row[:3]]
        words[2] = "" if words[2] == "unit unknown" else words[2]
        table.add_row(*words, *(number(value) for value in row[3:]))
    return table


def _orbit_lines(looked: Looked, found: Orders) -> list[str]:
    if found.orbit_channels is None:
        return []
    x, y = (looked.recording.channels[index] for index in found.orbit_channels)
    factor, unit = display_unit(x.unit)
    words = []
    clear = {one.order for one in found.followed if summary(found, one)["over_noise_db"] > CLEAR_DB}
    for order, shape, _, _ in found.orbits:
        if order not in clear:
            continue
        words.append(
            f"orbit  {order_name(order)}: {factor * shape.major:.3g} x {factor * abs(shape.minor):.3g} {unit}, "
            f"{shape.words} ({shape.direction:+.2f}; forward turns from {x.name} towards {y.name})"
        )
    return words


def _page(name: str, looked: Looked, found: Orders, rows: list[list[Any]], lines: Sequence[str]) -> str:
    recording = looked.recording
    facts = [
        f"Speed: {found.shaft.words}.",
        *(f"{line[0].upper()}{' '.join(line[1:].split())}." for line in lines),
    ]
    page = SignalPage("orders", name, f"Shaft orders at {found.shaft.words.split(',')[0]}", facts, looked.warnings)
    page.table(_HEADS, rows, caption="Orders over the run, peak amplitudes")
    _map(page, looked, found)
    if found.waterfall is not None:
        _waterfall(page, looked, found.waterfall)
    x_title, x = ("Speed (rpm)", 60 * found.speed_hz) if found.goes_one_way else ("Time (s)", found.time_s)
    page.graph("Order amplitudes", _curves(looked, found, x, x_title, phase=False), label="Channel")
    if found.shaft.has_mark:
        note = "Lead over the tacho's mark, where the order stands 10 dB above the noise."
        page.graph("Order phases", _curves(looked, found, x, x_title, phase=True), label="Channel", note=note)
    sure = found.shaft.confidences
    page.graph(
        "Speed",
        [
            graph_of(
                "speed", [("speed", found.shaft.time_s, 60 * found.shaft.speed_hz)], x="Time (s)", y="Speed (rpm)"
            ),
            graph_of(
                "confidence",
                [("confidence", found.shaft.time_s, sure)],
                x="Time (s)",
                y="Confidence",
                value_range=(0, 1.05),
            ),
        ],
    )
    _waves(page, looked, found)
    if found.full is not None:
        _full(page, looked, found, found.full)
    if found.orbit_channels is not None:
        names = [clean(recording.channels[index].name) for index in found.orbit_channels]
        factor, unit = display_unit(recording.channels[found.orbit_channels[0]].unit)
        order, _, one, other = max(found.orbits, key=lambda orbit: orbit[1].major)
        x_values, y_values = factor * filtered_orbit(one, other)
        note = f"{order_name(order)} alone, where it is largest."
        page.payload["orbit"] = {
            "x": numbers(x_values), "y": numbers(y_values), "unit": unit, "channels": names, "note": note,
        }  # fmt: skip
    return page.html()


def _map(page: SignalPage, looked: Looked, found: Orders) -> None:
    maps = []
    for index, channel in enumerate(looked.recording.channels):
        decibels = _decibels(np.abs(found.map.amplitude[index]).T)
        maps.append(heat_map(channel.name, found.map.time_s, found.map.orders, decibels))
    page.heat("Order map", maps, x="Time (s)", y="Order of shaft speed", unit="dB", note="0 dB is the highest value.")


def _decibels(level: np.ndarray) -> np.ndarray:
    """Return levels in dB of the highest."""
    decibels = 20 * np.log10(np.maximum(level, 1e-300))
    return decibels - decibels.max()


def _waterfall(page: SignalPage, looked: Looked, found: Waterfall) -> None:
    maps = [
        heat_map(channel.name, found.time_s, found.frequency_hz, _decibels(found.amplitude[index].T))
        for index, channel in enumerate(looked.recording.channels)
    ]
    note = "Slanted lines are orders; what stays at its frequency is a resonance, the mains or another machine."
    page.heat("Frequency map", maps, x="Time (s)", y="Frequency (Hz)", unit="dB", note=note)


def _full(page: SignalPage, looked: Looked, found: Orders, full: FullSpectrum) -> None:
    """Draw forward whirl at positive and backward whirl at negative orders."""
    assert found.orbit_channels is not None
    x, y = (looked.recording.channels[index] for index in found.orbit_channels)
    factor, _ = display_unit(x.unit)
    kept = full.frequency_hz <= found.map.orders[-1]
    order = np.concatenate([-full.frequency_hz[kept][:0:-1], full.frequency_hz[kept]])
    radius = factor * np.concatenate([full.backward[kept][:0:-1], full.forward[kept]])
    variant = graph_of(
        "whirl", [("whirl", order, radius)], x="Order; below 0 backward", y=f"Radius ({unit_words(x.unit)})"
    )
    note = f"Forward turns from {x.name} towards {y.name}. Equal radii at +n and -n are a straight line."
    page.graph("Full spectrum", [variant], note=note)


def _curves(looked: Looked, found: Orders, x: np.ndarray, x_title: str, *, phase: bool) -> list[dict[str, Any]]:
    order = np.argsort(x, kind="stable")
    variants = []
    for index, channel in enumerate(looked.recording.channels):
        factor, _ = display_unit(channel.unit)
        own = [one for one in found.followed if one.channel == index]
        traces = [
            (order_name(one.order), x[order], (_clear_phase(one) if phase else factor * one.amplitude)[order])
            for one in own
        ]
        title = "Phase (deg)" if phase else f"Amplitude ({unit_words(channel.unit)})"
        limits = (-185.0, 185.0) if phase else None
        variants.append(graph_of(channel.name, traces, x=x_title, y=title, value_range=limits))
    return variants


def _clear_phase(one: FollowedOrder) -> np.ndarray:
    """Return the phase with gaps where the order is lost in the noise, and where it passes 180 degrees."""
    shown = np.where(one.amplitude > 10 ** (CLEAR_DB / 20) * one.noise, one.phase_deg, np.nan)
    shown[1:][np.abs(np.diff(one.phase_deg)) > 180] = np.nan
    return shown


def _waves(page: SignalPage, looked: Looked, found: Orders) -> None:
    """Draw what each order moves, half a second from the middle of the record, with the signal behind."""
    recording, waves = looked.recording, found.waveforms
    half = min(int(0.5 * _WAVE_SECONDS * recording.rate_hz), recording.samples // 2)
    middle = recording.samples // 2
    part = slice(middle - half, middle + half)
    time = np.arange(part.start, part.stop) / recording.rate_hz
    _, moved = waves.part(part.start, part.stop)
    variants = []
    for index, channel in enumerate(recording.channels):
        factor, _ = display_unit(channel.unit)
        traces = [("signal", time, factor * recording.signals[index, part])]
        traces += [
            (order_name(float(order)), time, factor * moved[index, number]) for number, order in enumerate(waves.orders)
        ]
        reach = float(np.abs(traces[0][2]).max()) * 1.05 or 1.0
        variants.append(
            graph_of(
                channel.name,
                traces,
                x="Time (s)",
                y=f"Signal ({unit_words(channel.unit)})",
                value_range=(-reach, reach),
            )
        )
    note = "Vold-Kalman filtered orders, from the middle of the record."
    page.graph("Order waveforms", variants, label="Channel", note=note)
