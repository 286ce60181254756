"""Which channel of a recording a user means: by its name, by its title in the file, or by its number from 1."""

from __future__ import annotations

from collections.abc import Sequence

from .readers._names import split_header_cell


def channel_index(wanted: str, *names: Sequence[str | None]) -> int | None:
    """Return the index of the channel that is meant, from 0; None where there is none.

    Parameters
    ----------
    wanted : str
        A name, a title with its unit as it stands in the file, or a number from 1.
    names : sequences of str or None, each of shape (channels,)
        Names of the channels, those of the file before the user's own.

    Examples
    --------
    >>> channel_index("Tacho [V]", ("Acc", "Tacho"))
    1
    >>> channel_index("1", ("Acc", "Tacho"))
    0
    """
    for title in (wanted, split_header_cell(wanted)[0]):
        for choices in names:
            if title in choices:
                return list(choices).index(title)
    return int(wanted) - 1 if wanted.isdigit() and 1 <= int(wanted) <= len(names[0]) else None
