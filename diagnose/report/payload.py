"""The numbers behind the plots of one analysis, thinned for display."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from ..result import Analysis, Cursor, Curve, Line, OrderPart, Pictures
from .encode import RawJson, encode_curve, numbers, pool_map
from .tables import evidence_lines
from .text import clean, decibels, display_unit, file_name, fixed

#: Most points drawn of one curve.
POINT_LIMIT = 8000
_FEWEST_POINTS = 1200
_POINTS_A_TURN = 1500
_POINTS_OF_ALL_FILES = 60_000
# A map with more rows or columns than pixels would lose lines when the browser draws it.
_MAP_ROWS, _MAP_COLUMNS = 220, 250


def point_limit(files: int) -> int:
    """Return how many points a curve may have, so that a report over many files stays small."""
    return max(_FEWEST_POINTS, min(POINT_LIMIT, _POINTS_OF_ALL_FILES // max(files, 1)))


def build_payload(analysis: Analysis, *, limit: int) -> dict[str, Any]:
    """Return what the script needs to draw one analysis; ``to_json`` turns it into text.

    Parameters
    ----------
    analysis : Analysis
        One file's answer with its pictures.
    limit : int
        Most points of one curve.
    """
    pictures, lines = analysis.pictures, list(evidence_lines(analysis))
    baselines = {curve.channel: curve for curve in pictures.baseline_spectra}
    focus = _focus(analysis, lines)
    seen = {kind: [line for line in lines if line.spectrum == kind] for kind in ("spectrum", "envelope")}
    return {
        "speedHz": analysis.speed.speed_hz if analysis.speed else None,
        "spectrum": [_channel(curve, limit, focus, seen["spectrum"], baselines) for curve in pictures.spectra],
        "envelope": [_channel(curve, limit, focus, seen["envelope"], {}) for curve in pictures.envelopes],
        "waveform": [_channel(curve, limit, None, [], {}) for curve in pictures.waveforms],
        "cursors": cursor_groups(pictures, lines),
        "map": _map(pictures.order_map, limit),
        "orbit": _orbit(pictures.orbit, limit),
        "turn": _turn(pictures.order_part, limit),
    }


def _focus(analysis: Analysis, lines: list[Line]) -> float | None:
    """Return the highest frequency with a marker, a little widened: where the reader zooms in."""
    marks = [cursor.frequency_hz for cursor in analysis.pictures.cursors] + [line.frequency_hz for line in lines]
    if analysis.speed:
        marks.append(10 * analysis.speed.speed_hz)
    return 1.1 * max((mark for mark in marks if np.isfinite(mark)), default=0.0) or None


def _channel(
    curve: Curve, limit: int, focus: float | None, lines: list[Line], baselines: dict[str, Curve]
) -> dict[str, Any]:
    factor, unit = display_unit(curve.y_unit)
    floor = None if curve.noise_floor is None else factor * np.asarray(curve.noise_floor, dtype=float)
    coded = encode_curve(curve.x, factor * np.asarray(curve.y, dtype=float), limit=limit, floor=floor, focus=focus)
    notes = [clean(curve.note)] if curve.note else []
    if coded["shown"] < coded["total"]:
        notes.append(
            f"{coded['shown']} of {coded['total']} points drawn: the highest and the lowest of each piece, "
            "so that no peak is lost."
        )
    channel: dict[str, Any] = {
        "channel": clean(curve.channel),
        "name": clean(curve.name),
        "xUnit": clean(curve.x_unit),
        "unit": unit or "unit unknown",
        "note": " ".join(notes),
        "curve": coded,
        "lines": [_marker(line) for line in lines if line.channel == curve.channel],
    }
    base = baselines.get(curve.channel)
    if base is not None:
        base_factor, _ = display_unit(base.y_unit)
        channel["base"] = encode_curve(base.x, base_factor * np.asarray(base.y, dtype=float), limit=limit, focus=focus)
    return channel


def _marker(line: Line) -> dict[str, Any]:
    factor, _ = display_unit(line.unit)
    snr = fixed(decibels(line.signal_to_noise), 1)
    return {
        "f": line.frequency_hz,
        "a": line.amplitude * factor,
        "text": f"{clean(line.name)}, order {fixed(line.order, 3)}, {snr} dB above the noise floor",
    }


def cursor_groups(pictures: Pictures, lines: list[Line]) -> list[dict[str, Any]]:
    """Return the cursors by group; shaft orders start switched on, others when a finding uses them."""
    groups: dict[str, list[Cursor]] = {}
    for cursor in pictures.cursors:
        if np.isfinite(cursor.frequency_hz):
            groups.setdefault(cursor.group, []).append(cursor)
    return [
        {
            "group": clean(group),
            "on": "shaft" in group.casefold() or _is_used(group, members, lines),
            "items": [[clean(cursor.label), cursor.frequency_hz] for cursor in members],
        }
        for group, members in groups.items()
    ]


def _is_used(group: str, members: list[Cursor], lines: list[Line]) -> bool:
    labels = {cursor.label.casefold() for cursor in members}
    word = re.compile(rf"(?<!\w){re.escape(group.casefold())}(?!\w)")
    return any(line.name.casefold() in labels or word.search(line.name.casefold()) for line in lines)


def _map(order_map: dict | None, limit: int) -> dict[str, Any] | None:
    if not order_map or not np.size(order_map["level_db"]):
        return None
    levels = np.atleast_2d(np.asarray(order_map["level_db"], dtype=float))
    shrink = (limit / POINT_LIMIT) ** 0.5
    pooled, per_row, per_column = pool_map(levels, int(_MAP_ROWS * shrink), int(_MAP_COLUMNS * shrink))
    note = "Colour is the level in dB."
    if per_row * per_column > 1:
        note += f" Each cell shows the highest of {per_row} × {per_column} values, so that no line is lost."
    rows = [RawJson(numbers(np.round(row, 1))) for row in pooled]
    return {
        "time": numbers(_centres(order_map["time_s"], per_column), digits=6),
        "y": numbers(_centres(order_map["order_or_hz"], per_row), digits=6),
        "z": rows,
        "axis": "Order" if order_map.get("axis") == "order" else "Frequency (Hz)",
        "channel": clean(order_map.get("channel", "")),
        "note": note,
    }


def _centres(values: Any, size: int) -> np.ndarray:
    positions = np.asarray(values, dtype=float)
    starts = np.arange(0, positions.size, size)
    return np.add.reduceat(positions, starts) / np.diff(starts, append=positions.size)


def _orbit(orbit: dict | None, limit: int) -> dict[str, Any] | None:
    if not orbit or not np.size(orbit["x"]):
        return None
    factor, unit = display_unit(orbit.get("unit"))
    x, y = (factor * np.asarray(orbit[axis], dtype=float).ravel()[:limit] for axis in ("x", "y"))
    names = [clean(name) for name in orbit.get("channels", ("x", "y"))]
    note = f"The first {limit} of {np.size(orbit['x'])} samples." if np.size(orbit["x"]) > limit else ""
    orders = [
        {"name": clean(f"{one['name']} {one['way']}"), "x": numbers(factor * one["x"]), "y": numbers(factor * one["y"])}
        for one in orbit.get("orders", ())
    ]
    if orders:
        note = f"{note} Orders alone: forward turns from {names[0]} towards {names[1]}; a dot where a turn begins."
    return {
        "x": numbers(x), "y": numbers(y), "unit": unit or "unit unknown", "channels": names, "note": note.strip(),
        "orders": orders,
    }  # fmt: skip


def _turn(part: OrderPart | None, limit: int) -> dict[str, Any] | None:
    """Return the waveforms of orders over the shaft's angle in degrees."""
    if part is None:
        return None
    from ..order_waves import order_waves

    found = order_waves(part)
    factor, unit = display_unit(part.unit)
    degrees = 360 * found.turns
    return {
        "channel": clean(part.channel),
        "unit": unit or "unit unknown",
        "note": "Vold-Kalman filter, three turns from the middle of the record. "
        + ("Zero is the tacho's mark." if part.has_mark else "The zero of the angle is arbitrary."),
        "traces": [
            {"name": clean(name), "curve": encode_curve(degrees, factor * wave, limit=min(limit, _POINTS_A_TURN))}
            for name, wave in (("signal", found.signal), *found.waves)
        ],
    }


def short_name(analysis: Analysis) -> str:
    """Return the file name of an analysis, or its label when it has no path."""
    return file_name(analysis.path) if analysis.path else clean(analysis.label or "unnamed")
