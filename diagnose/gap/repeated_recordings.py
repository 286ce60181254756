"""Recordings that are in a campaign twice."""

from __future__ import annotations

import hashlib
from collections.abc import Collection
from pathlib import Path

from ...datasets.recording import Recording
from ...simulators.errors import InvalidValueError
from .channels import Matched


def without_repeated(kept: dict[Path, tuple[Recording, Matched]], healthy: Collection[Path]) -> list[str]:
    """Take recordings away that hold the samples of another one, and return notes on them.

    Counted twice they would be twice as sure. One that is both healthy and to be explained is told only: nobody here
    knows which it is.

    Raises
    ------
    InvalidValueError
        Where all recordings of the healthy machine are such, or all that are to be explained.
    """
    notes, seen, both = [], {}, set()
    for path, (recording, _) in list(kept.items()):
        own = hashlib.sha256(recording.signals.tobytes()).digest()
        first = seen.setdefault(own, path)
        if first == path:
            continue
        same_role = (first in healthy) == (path in healthy)
        if same_role:
            del kept[path]
        else:
            both |= {first, path}
        what = "It is left out" if same_role else "One is to be explained, the other healthy: check which it is"
        notes.append(f"{path} holds the same samples as {first}. {what}.")
    for role, what in ((True, "healthy recordings"), (False, "recordings to explain")):
        own = [path for path in kept if (path in healthy) == role]
        if own and both.issuperset(own):
            raise InvalidValueError(
                f"All {what} hold the same samples as others of the other kind ({own[0]}); allowed: some of their own. "
                "Correct --baseline, or take the copies away."
            )
    return notes
