"""Channel names that no reader takes for something else; the sidecar holds the true ones."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ..readers._names import is_index, is_label, is_other_axis, is_rate, is_speed, is_step, is_time, number_in

_MEANINGS = (is_index, is_label, is_other_axis, is_rate, is_speed, is_step, is_time)


def safe_names(names: Sequence[str], *, unwanted: str = "") -> list[str]:
    """Return a different name for each channel, its own where a reader sees nothing but a channel in it.

    Parameters
    ----------
    names : sequence of str
    unwanted : str
        Regular expression of signs that the format cannot hold in a name; each run becomes a blank.

    Examples
    --------
    >>> safe_names(["bearing 1", "time", "12", "a,b", "a;b"], unwanted="[,;]")
    ['bearing 1', 'channel 2', 'channel 3', 'a b', 'channel 5']
    """
    made: list[str] = []
    for number, name in enumerate(names, start=1):
        plain = (re.sub(f"(?:{unwanted})+", " ", name) if unwanted else name).strip()
        taken = not plain or plain in made or number_in(plain) is not None or any(means(plain) for means in _MEANINGS)
        made.append(f"channel {number}" if taken else plain)
    return made
