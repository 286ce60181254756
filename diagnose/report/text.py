"""Words and numbers as a report prints them."""

from __future__ import annotations

import html
import math
import re
from pathlib import PurePosixPath, PureWindowsPath

#: Fault names in plain words.
FAULT_WORDS = {
    "unbalance": "Unbalance",
    "misalignment": "Shaft misalignment",
    "bent_shaft": "Bent shaft",
    "looseness": "Mechanical looseness",
    "rub": "Rotor rub",
    "oil_whirl": "Oil whirl in a journal bearing",
    "bearing_outer_race": "Rolling bearing: outer race damaged",
    "bearing_inner_race": "Rolling bearing: inner race damaged",
    "bearing_ball": "Rolling bearing: ball or roller damaged",
    "bearing_cage": "Rolling bearing: cage damaged",
    "gear_wear": "Gear wear",
    "gear_tooth_fault": "Gear tooth cracked, chipped or broken",
    "gear_eccentricity": "Eccentric gear",
    "electrical": "Electrical fault of the motor",
    "resonance": "Resonance",
    "sensor_fault": "Sensor or cable fault",
}
# Vibration engineers read mm/s and um; everything inside rotorwise is SI.
_DISPLAY = {"m/s": (1e3, "mm/s"), "m": (1e6, "µm"), "m/s2": (1.0, "m/s²"), "um": (1.0, "µm")}
# Controls and lone surrogates are not allowed in HTML; direction marks would let a file name pose as another.
_UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\u202a-\u202e\u2066-\u2069\ufffe\uffff]")
MISSING = "–"


def clean(text: object) -> str:
    """Return the text with every character that HTML forbids, or that can disguise it, made visible."""
    return _UNPRINTABLE.sub("\ufffd", str(text))


def escape(text: object) -> str:
    """Return the text, safe between HTML tags and inside quoted attributes."""
    return html.escape(clean(text), quote=True)


def fault_words(fault: str) -> str:
    """Return a fault's name in plain words (not escaped)."""
    return FAULT_WORDS.get(fault) or clean(fault).replace("_", " ").capitalize()


def display_unit(unit: str | None) -> tuple[float, str | None]:
    """Return the factor from a unit to the one that is printed, and that one's name.

    Examples
    --------
    >>> display_unit("m/s")
    (1000.0, 'mm/s')
    >>> display_unit(None)
    (1.0, None)
    """
    if unit is None:
        return 1.0, None
    return _DISPLAY.get(unit, (1.0, clean(unit)))


def unit_words(unit: str | None) -> str:
    """Return the printed unit, or ``"unit unknown"`` (not escaped)."""
    return display_unit(unit)[1] or "unit unknown"


def number(value: float | None, *, digits: int = 3) -> str:
    """Return a number with this many significant digits; a dash when there is none.

    Examples
    --------
    >>> number(1234.5), number(0.00012345), number(float("nan"))
    ('1234', '0.000123', '–')
    """
    if value is None or math.isnan(value):
        return MISSING
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    places = digits - 1 - math.floor(math.log10(abs(value)))
    if not -6 <= places <= digits + 4:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{max(places, 0)}f}"


def fixed(value: float | None, places: int) -> str:
    """Return a number with this many decimals; a dash when there is none."""
    if value is None or not math.isfinite(value):
        return number(value)
    return f"{value:.{places}f}"


def percent(probability: float | None) -> str:
    """Return a probability as a percentage that never rounds to certainty."""
    if probability is None or not math.isfinite(probability):
        return "unknown"
    if 0 < probability < 0.01:
        return "below 1 %"
    if 0.99 < probability < 1:
        return "above 99 %"
    return f"{100 * probability:.0f} %"


def decibels(ratio: float | None) -> float | None:
    """Return an amplitude ratio in dB; None when it has none."""
    if ratio is None or not ratio > 0:
        return None
    return math.inf if math.isinf(ratio) else 20 * math.log10(ratio)


def duration(seconds: float) -> str:
    """Return a time span in the unit that suits it."""
    if not math.isfinite(seconds) or seconds < 120:
        return f"{number(seconds)} s"
    return f"{seconds / 60:.1f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


def file_name(path: str) -> str:
    """Return the last part of a path of any system (not escaped)."""
    return clean(PureWindowsPath(path).name or PurePosixPath(path).name or path)


def cell(shown: str, value: float | None, *, css: str = "num") -> str:
    """Return a table cell that sorts by a number; cells without one sort last."""
    key = "" if value is None or math.isnan(value) else f"{value:.9g}".replace("inf", "Infinity")
    return f'<td class="{css}" data-v="{key}">{shown}</td>'
