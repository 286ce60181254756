"""Whether the lines of a recording are spaced by the speed of a gear's shaft: the cepstrum's view of all families.

One damaged tooth modulates every line that its gear makes, once a turn and with many sidebands, so that the whole
spectrum is spaced by its shaft's speed. An eccentric gear makes one pair, a worn one none.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

from ..simulators.errors import InvalidValueError
from .observe import Observation
from .signal.cepstrum import band_cepstrum, line_spacing

_LOWEST_HZ, _HIGHEST = 200.0, 0.4  # of the band; the upper end over the sampling rate
_SLOWEST, _FASTEST = 0.8, 6.0  # spacings looked for, over the slowest and the fastest shaft of a gear
_NEAR = 0.01


@dataclass(frozen=True)
class GearSpacing:
    """The spacing that stands out on a channel, where it is a gear's: power over noise of the cepstrum's peak."""

    gear: str
    channel: int
    spacing_hz: float
    power_ratio: float


_KNOWN: WeakKeyDictionary[Observation, GearSpacing | None] = WeakKeyDictionary()


def gear_spacing(now: Observation) -> GearSpacing | None:
    """Return the clearest spacing that is the speed of a gear's shaft; None where none is or none can be told.

    Parameters
    ----------
    now : Observation
        With a speed and gears.
    """
    if now not in _KNOWN:
        _KNOWN[now] = max(_of_channels(now), key=lambda one: one.power_ratio, default=None)
    return _KNOWN[now]


def _of_channels(now: Observation) -> list[GearSpacing]:
    shafts = {
        f"{teeth}-tooth gear": ratio * now.speed_hz
        for gear in now.recording.nameplate.gears
        for ratio, teeth in ((gear.driver_ratio, gear.driver_teeth), (gear.driven_ratio, gear.driven_teeth))
        if ratio is not None
    }
    if now.speed is None or not shafts:
        return []
    limits = {"narrowest_hz": _SLOWEST * min(shafts.values()), "widest_hz": _FASTEST * max(shafts.values())}
    rate_hz, found = now.recording.rate_hz, []
    for channel, row in enumerate(now.recording.signals):
        try:
            cepstrum = band_cepstrum(
                row,
                rate_hz=rate_hz,
                low_hz=_LOWEST_HZ,
                high_hz=_HIGHEST * rate_hz,
                narrowest_hz=limits["narrowest_hz"],
            )
        except InvalidValueError:
            continue  # too short a record, or too narrow a band
        spacing = line_spacing(cepstrum, **limits)
        if spacing is None:
            continue
        off = {gear: abs(spacing.spacing_hz / speed_hz - 1.0) for gear, speed_hz in shafts.items()}
        gear = min(off, key=lambda one: off[one])
        if off[gear] < _NEAR:
            found.append(GearSpacing(gear, channel, spacing.spacing_hz, spacing.power_ratio))
    return found
