"""What the readers of the files warned of: units that contradict a file, channels left out, a doubtful time column."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from ...datasets.recording import Recording

#: Different warnings that are told; the rest is counted.
MOST_TOLD = 6


def warnings_told(recordings: Sequence[Recording]) -> list[str]:
    """Return each warning once, with the file where it is one, or the number of them."""
    counts = Counter(text for one in recordings for text in dict.fromkeys(one.warnings))
    told = []
    for text, count in counts.most_common(MOST_TOLD):
        first = next(Path(one.provenance.path or "recording").name for one in recordings if text in one.warnings)
        where = first if count == 1 else f"{first} and {count - 1} more" if count < len(recordings) else ""
        told.append(f"{where}: {text}" if where else text)
    more = len(counts) - len(told)
    return [*told, f"{more} more warnings of the readers; analyse tells them."] if more > 0 else told
