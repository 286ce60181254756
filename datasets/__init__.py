"""Recordings of machines, measured or simulated: reading, units, metadata."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .generate import build
    from .metadata import Metadata
    from .reading import find_recordings, read, read_blocks
    from .recipe_file import load_recipe
    from .recording import Campaign, Channel, Nameplate, OperatingCondition, Recording
    from .store import open_store

_WHERE = {
    "Campaign": "recording",
    "Channel": "recording",
    "Metadata": "metadata",
    "Nameplate": "recording",
    "OperatingCondition": "recording",
    "Recording": "recording",
    "build": "generate",
    "find_recordings": "reading",
    "load_recipe": "recipe_file",
    "open_store": "store",
    "read": "reading",
    "read_blocks": "reading",
}

__all__ = [
    "Campaign",
    "Channel",
    "Metadata",
    "Nameplate",
    "OperatingCondition",
    "Recording",
    "build",
    "find_recordings",
    "load_recipe",
    "open_store",
    "read",
    "read_blocks",
]


def __getattr__(name: str) -> object:
    # Imported on first use: `import rotorwise.datasets` must not cost what reading costs.
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_WHERE[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
