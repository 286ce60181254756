"""What names in files mean: rate, speed, time, units. Shared by the readers."""

from __future__ import annotations

import math
import re

from ..units import parse_unit

_RATE = re.compile(
    r"(fs|sr|rate_?hz|sampl?(e|ing)?_?(rate|freq|frequency)(_?(in_?)?hz)?|samplerate|sampfreq|fsamp|f_?sample)",
    re.ASCII,
)
_STEP = re.compile(r"(dt|x_?inc|x_?axis_?step|x_?step|wf_increment|sample_?(interval|period)|time_?step)(_?s)?")
_SPEED = re.compile(r"((shaft_?|motor_?|rotation(al)?_?)?(speed_?)?rpm|speed_?\(?rpm\)?|speed_in_rpm)")
_LABEL = re.compile(r"(label|class|condition|fault)")
_TIME = re.compile(
    r"(t|time(_?stamps?)?|date_?time|date|elapsed(_time)?|time_?s(ec(onds)?)?|zeit|x:time|seconds|tiempo|temps)"
)
_INDEX = re.compile(r"(index|idx|n|no|nr|#|sample(_?(no|number|index))?|unnamed:_?0|point|row|)")
_NOT_WAVEFORM = re.compile(r"(freq(uency)?|f|hz|rpm|speed|order)")

_SECONDS = {
    "s": 1.0,
    "sec": 1.0,
    "second": 1.0,
    "seconds": 1.0,
    "ms": 1e-3,
    "msec": 1e-3,
    "milliseconds": 1e-3,
    "us": 1e-6,
    "µs": 1e-6,
    "μs": 1e-6,
    "microseconds": 1e-6,
    "ns": 1e-9,
    "nanoseconds": 1e-9,
    "min": 60.0,
    "h": 3600.0,
}


def key_of(text: str) -> str:
    """Return a header name in the form that the patterns here expect."""
    return re.sub(r"[\s\-.]+", "_", text.strip().strip("\"'").casefold()).strip("_:")


def is_rate(name: str) -> bool:
    """Whether a field holds a sampling rate."""
    return _RATE.fullmatch(key_of(name)) is not None


def is_step(name: str) -> bool:
    """Whether a field holds the time between samples."""
    return _STEP.fullmatch(key_of(name)) is not None


def is_speed(name: str) -> bool:
    """Whether a field holds a shaft speed in rpm."""
    return _SPEED.fullmatch(key_of(name)) is not None


def is_label(name: str) -> bool:
    """Whether a field holds the machine's state in words."""
    return _LABEL.fullmatch(key_of(name)) is not None


def is_time(name: str) -> bool:
    """Whether a column or variable holds time."""
    return _TIME.fullmatch(key_of(name)) is not None


def is_index(name: str) -> bool:
    """Whether a column only counts the rows."""
    return _INDEX.fullmatch(key_of(name)) is not None


def is_other_axis(name: str) -> bool:
    """Whether a first column makes the table a spectrum or a run-up rather than a waveform."""
    return _NOT_WAVEFORM.fullmatch(key_of(re.sub(r"[(\[].*", "", name))) is not None


def seconds_per(unit: str | None) -> float | None:
    """Return the seconds in one unit of time; None when the text is no unit of time."""
    return None if unit is None else _SECONDS.get(unit.strip().strip("()[]").strip().casefold())


def number_in(text: object) -> float | None:
    """Return the finite number of a text, kHz and ms applied (``"25.6 kHz"`` is 25600); else None."""
    match = re.fullmatch(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*([A-Za-z/µ]*)\s*", str(text).replace(",", "."))
    if match is None:
        return None
    try:
        value = float(match.group(1))
    except ValueError:
        return None
    unit = match.group(2).casefold()
    scale = {"khz": 1e3, "mhz": 1e6, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}.get(unit, 1.0)
    return value * scale if math.isfinite(value) else None


def positive(text: object) -> float | None:
    """Return the number that a text holds when it is above zero; else None."""
    value = number_in(text)
    return value if value is not None and value > 0 else None


def split_header_cell(cell: str) -> tuple[str, str | None]:
    """Split a column title into name and unit.

    Only a known unit or a unit of time is taken off: ``"acc (front)"`` stays a name.

    Examples
    --------
    >>> split_header_cell("acc_x (g)")
    ('acc_x', 'g')
    >>> split_header_cell("Y:(g)")
    ('Y', 'g')
    >>> split_header_cell("ax")
    ('ax', None)
    """
    text = cell.strip().strip("\"'").strip()
    match = re.fullmatch(r"(.*?)[\s:,_/]*[\[(]([^\])]*)[\])]\s*", text)
    if match is None:
        return text, None
    unit = match.group(2).strip()
    if parse_unit(unit) is None and seconds_per(unit) is None:
        return text, None
    return match.group(1).strip().rstrip(":") or "channel", unit


def unique_names(names: list[str]) -> tuple[str, ...]:
    """Return the names with a number behind repeated ones: each channel must be told from the others."""
    seen: dict[str, int] = {}
    out: list[str] = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        candidate = name if seen[name] == 1 else f"{name} ({seen[name]})"
        while candidate in out:
            seen[name] += 1
            candidate = f"{name} ({seen[name]})"
        out.append(candidate)
    return tuple(out)
