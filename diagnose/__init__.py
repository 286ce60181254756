"""From signals to answers. ``analyse`` takes a file, ``analyse_recording`` a recording in memory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .pipeline import analyse, analyse_recording, read_baseline
    from .result import Analysis, Finding, Severity

__all__ = ["Analysis", "Finding", "Severity", "analyse", "analyse_recording", "read_baseline"]

_WHERE = {
    "Analysis": "result",
    "Finding": "result",
    "Severity": "result",
    "analyse": "pipeline",
    "analyse_recording": "pipeline",
    "read_baseline": "pipeline",
}


def __getattr__(name: str) -> Any:
    # Heavy libraries load on first use, so that `rotorwise --help` answers at once.
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(f".{_WHERE[name]}", __name__), name)
    globals()[name] = value
    return value
