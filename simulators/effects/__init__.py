"""Physical effects, one a file. `effects.Unbalance(...)` finds the class wherever its file is."""

from __future__ import annotations

from typing import Any


def __getattr__(name: str) -> Any:
    from ..effect import effect_catalogue

    if not name.startswith("_"):
        for effect in effect_catalogue().values():
            if effect.__name__ == name:
                return effect
    raise AttributeError(f"module {__name__!r} has no effect {name!r}")


def __dir__() -> list[str]:
    from ..effect import effect_catalogue

    return sorted(effect.__name__ for effect in effect_catalogue().values())
