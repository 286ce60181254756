"""What one file holds, as stored: the common answer of every reader, before any unit conversion."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

_TACHO_NAME = re.compile(r"tach|key[ _-]?phas|trigger|(^|[^a-z])(once[ _-]?per[ _-]?rev|1/rev)", re.IGNORECASE)


def quantity_hint(channel_name: str) -> str | None:
    """Return ``"tacho"`` when a channel's name says that it carries speed pulses, else None.

    Examples
    --------
    >>> quantity_hint("Keyphasor 1")
    'tacho'
    >>> quantity_hint("DE vertical") is None
    True
    """
    return "tacho" if _TACHO_NAME.search(channel_name) else None


@dataclass(frozen=True, eq=False)
class FileContent:
    """Signals and header of one file, in the file's own units.

    Attributes
    ----------
    signals : numpy.ndarray, shape (channels, samples)
        float32 or float64, as stored; integers become float64.
    channel_names : tuple of str
        One a channel, all different.
    units : tuple of (str or None)
        Unit text of each channel as the file spells it; None when the file has none.
    rate_hz : float or None
        Sampling rate, when the file holds it or a time axis.
    speed_rpm, load, load_unit, label
        Of the header, when there.
    total_samples : int or None
        Samples per channel in the whole file; None when only reading it all would tell.
    start_sample : int
        Index in the file of the first sample here.
    warnings : tuple of str
        What the user should know about this file.
    notes : mapping of str to str
        Header fields that have no place of their own.
    """

    signals: np.ndarray
    channel_names: tuple[str, ...]
    units: tuple[str | None, ...]
    rate_hz: float | None = None
    speed_rpm: float | None = None
    load: float | None = None
    load_unit: str | None = None
    label: str | None = None
    total_samples: int | None = None
    start_sample: int = 0
    warnings: tuple[str, ...] = ()
    notes: Mapping[str, str] = field(default_factory=dict)

    @property
    def quantity_hints(self) -> tuple[str | None, ...]:
        """Per channel, the quantity that its name gives away (``"tacho"``), or None."""
        return tuple(quantity_hint(name) for name in self.channel_names)

    @property
    def samples(self) -> int:
        """Number of samples per channel held here."""
        return self.signals.shape[1]
