"""From signals to answers. ``analyse`` takes a file, ``analyse_recording`` a recording, ``explain_gap`` a campaign."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .gap.explain import explain_gap
    from .gap.explain_lines import explain_lines
    from .gap.result import GapResult
    from .pipeline import analyse, analyse_recording, read_baseline
    from .result import Analysis, Finding, Severity

__all__ = [
    "Analysis",
    "Finding",
    "GapResult",
    "Severity",
    "analyse",
    "analyse_recording",
    "explain_gap",
    "explain_lines",
    "read_baseline",
]

_WHERE = {
    "Analysis": "result",
    "Finding": "result",
    "GapResult": "gap.result",
    "Severity": "result",
    "analyse": "pipeline",
    "analyse_recording": "pipeline",
    "explain_gap": "gap.explain",
    "explain_lines": "gap.explain_lines",
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
